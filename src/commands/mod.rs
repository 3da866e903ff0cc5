//! The commands of the program, one file each.

pub mod bake;
pub mod bench;
mod describe;
pub mod info;
pub mod fly;
pub mod progress;
pub mod render;
pub mod styles;

use std::io::{ErrorKind, Write};

use serde::Serialize;

use crate::scene::Scene;

/// Writes `text` and a line's end to standard output. A reader that has heard enough (`… | head`) is no failure.
fn tell(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{}", text.trim_end()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// [`tell`] for programs.
fn tell_json(value: &impl Serialize) -> anyhow::Result<()> {
    tell(&serde_json::to_string_pretty(value)?)
}

/// `--nodata`: a height in metres.
fn parse_no_data(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("{text:?} is not a height in metres, like -9999"))
}

/// A scene with what the command line says of its voids.
fn with_no_data(scene: Scene, no_data: Option<f64>) -> Scene {
    Scene { no_data: no_data.or(scene.no_data), ..scene }
}

/// `--eyes`: for now there is one.
fn parse_eyes(text: &str) -> Result<String, String> {
    match text {
        "mono" => Ok(text.to_owned()),
        "side-by-side" | "anaglyph" => Err("this version draws mono only".to_owned()),
        _ => Err("it must be mono".to_owned()),
    }
}
