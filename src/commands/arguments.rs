//! Values of arguments: what they may be, and what is said where they are not.

use std::path::Path;

use anyhow::bail;

use super::misuse::{Misuse, mistyped_command};
use crate::file::message::{named, quoted};
use crate::scene::embedded;
use crate::style::{Style, StyleError};
use crate::tones::hatching::maps;

/// A finite number.
///
/// # Errors
/// Says what it must be; so do the others.
pub fn number(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "it must be a number".to_owned())
}

/// A finite number above 0.
pub fn above_0(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|&number| number > 0.0).ok_or_else(|| "it must be a number above 0".to_owned())
}

/// A number other than 0.
pub fn not_0(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|&number| number != 0.0).ok_or_else(|| "it must be a number other than 0".to_owned())
}

/// A number from `least` to `most`.
pub fn from_to(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = number(text).ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("it must be a number between {least} and {most}"))
    }
}

/// Frames in a second.
pub fn frame_rate(text: &str) -> Result<f64, String> {
    let rate = above_0(text).ok().filter(|&rate| rate <= 1000.0);
    rate.ok_or_else(|| "it must be a number above 0, at most 1000".to_owned())
}

/// A whole number from `least` to `most`.
pub fn whole<T: TryFrom<u64> + Clone>(least: u64, most: u64) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| (least..=most).contains(number));
        number
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| format!("it must be a whole number from {least} to {most}"))
    }
}

/// A preset or a style file, whose pictures are there.
///
/// # Errors
/// [`Misuse`] where there is no style of that name; what is wrong with its file.
pub fn style(name: &str) -> anyhow::Result<Style> {
    let style = Style::load(name).map_err(|error| match error {
        StyleError::Unknown { .. } => anyhow::Error::from(Misuse::of(error)),
        _ => error.into(),
    })?;
    maps::check(&style)?;
    Ok(style)
}

/// That a WORLD, if it is a file, is there.
///
/// # Errors
/// [`Misuse`] where it looks like a command; else that there is no such file.
pub fn check_world(world: Option<&str>) -> anyhow::Result<()> {
    let Some(world) = world.filter(|world| !world.contains("://")) else { return Ok(()) };
    if world.is_empty() {
        return Err(Misuse("the WORLD is empty; without one, it is the embedded world".to_owned()).into());
    }
    // Where nobody may look the opening tells.
    if Path::new(world).try_exists().unwrap_or(true) {
        return Ok(());
    }
    if embedded::scene(world).is_some() {
        return Ok(());
    }
    if let Some(mistyped) = mistyped_command(world) {
        return Err(Misuse(mistyped).into());
    }
    bail!("{}: {}", if world.trim().is_empty() { quoted(world) } else { named(world) }, no_such_file(world))
}

/// What is said of a file that is not there; of a bare name also what is inside the program.
pub fn no_such_file(name: &str) -> String {
    match name.contains(['.', '/', '\\']) || name.trim().is_empty() {
        true => "there is no such file".to_owned(),
        false => format!("there is no such file, and inside hachure are the scenes {}", embedded::scene_names()),
    }
}

/// That a file is not an address: `command` reads files of this machine.
///
/// # Errors
/// [`Misuse`].
pub fn check_local(file: &Path, command: &str) -> Result<(), Misuse> {
    if !file.to_string_lossy().contains("://") || file.exists() {
        return Ok(());
    }
    // An address may hold a password: it is not repeated.
    Err(Misuse(format!("{command} reads files of this machine; render, bench and fly read addresses")))
}
