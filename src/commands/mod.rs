//! The commands of the program, one file each.

pub(crate) mod arguments;
pub(crate) mod bake;
pub(crate) mod bench;
pub(crate) mod completions;
mod describe;
pub(crate) mod height_args;
pub mod host;
pub(crate) mod land_args;
pub(crate) mod layer_args;
pub(crate) mod info;
pub(crate) mod fly;
mod inputs;
pub(crate) mod place_args;
pub mod log;
pub(crate) mod light_args;
pub(crate) mod man;
pub mod misuse;
pub mod program;
pub(crate) mod progress;
pub(crate) mod quality_args;
pub(crate) mod render;
pub(crate) mod stereo_args;
pub(crate) mod styles;
pub(crate) mod water_args;
pub(crate) mod world_args;

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
