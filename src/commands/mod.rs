//! The commands of the program, one file each.

pub mod arguments;
pub mod bake;
pub mod bench;
mod describe;
pub mod height_args;
pub mod info;
pub mod fly;
mod inputs;
pub mod light_args;
pub mod misuse;
pub mod program;
pub mod progress;
pub mod render;
pub mod stereo_args;
pub mod styles;
pub mod water_args;
pub mod world_args;

use serde::Serialize;

use crate::file::message::harmless;
use crate::file::standard;

/// Prints a command's answer, with control characters escaped; see [`standard::print`].
fn print(text: &str) -> anyhow::Result<()> {
    Ok(standard::print(&harmless(text))?)
}

/// Prints `value` as JSON, see [`print`].
fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}
