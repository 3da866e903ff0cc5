//! The commands of the program, one file each.

pub mod arguments;
pub mod bake;
pub mod bench;
mod describe;
pub mod height_args;
pub mod info;
pub mod fly;
mod inputs;
pub mod misuse;
pub mod progress;
pub mod render;
pub mod styles;

use serde::Serialize;

use crate::file::message::harmless;
use crate::file::standard;
use crate::scene::stereo::Eyes;

/// What a command answers, with control characters escaped; see [`standard::print`].
fn print(text: &str) -> anyhow::Result<()> {
    Ok(standard::print(&harmless(text))?)
}

/// [`print`] for programs.
fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}

/// `--eyes` of what draws one eye for now.
fn parse_one_eye(text: &str) -> Result<Eyes, String> {
    match text.parse()? {
        Eyes::Mono => Ok(Eyes::Mono),
        _ => Err("this version draws two eyes into files only (hachure render)".to_owned()),
    }
}
