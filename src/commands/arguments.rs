//! Parsers and checks of argument values, with their error messages.

use std::path::Path;

use anyhow::bail;

use super::misuse::{Misuse, mistyped_command};
use crate::file::input::{LARGEST_SCENE_BYTES, LARGEST_STYLE_BYTES, read_text};
use crate::file::message::{did_you_mean, named, quoted};
use crate::file::toml_text;
use crate::scene::embedded;
use crate::scene::path::CameraPath;
use crate::scene::ranges::{self, NumberRange};
use crate::style::set::{self, SetValue};
use crate::style::{Style, StyleError, preset_text};
use crate::tones::hatching::maps;

/// Returns a parser of the numbers in a range, which imprints and scene files check too.
///
/// # Errors
/// The parser returns what the value must be; so do the other parsers of this module.
pub(crate) fn within(range: NumberRange) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| range.parse(text)
}

/// Returns a parser of the whole numbers in a range.
pub(crate) fn whole_within<T: TryFrom<u64> + Clone>(range: NumberRange) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| range.parse_whole(text)
}

/// Parses the time that a frame may take, in milliseconds.
pub(crate) fn budget_ms(text: &str) -> Result<f64, String> {
    let rule = "it must be a time in milliseconds, above 0 and at most 60000, such as 11.1 for 90 frames a second";
    ranges::BUDGET_MS.parse(text).map_err(|_| rule.to_owned())
}

/// Parses a finite number above 0.
pub(crate) fn above_0(text: &str) -> Result<f64, String> {
    NumberRange::Above0.parse(text)
}

/// Returns a parser of numbers from `least` to `most`, ends included.
pub(crate) fn from_to(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    within(NumberRange::Within(least, most))
}

/// Returns a parser of whole numbers from `least` to `most`, ends included.
pub(crate) fn whole<T: TryFrom<u64> + Clone>(least: u64, most: u64) -> impl Fn(&str) -> Result<T, String> + Clone {
    whole_within(NumberRange::Whole(least, most))
}

/// Loads a preset or a style file, and checks that its pictures exist.
///
/// # Errors
/// Returns [`Misuse`] if there is no style of that name, else what is wrong with its file.
pub(crate) fn style(name: &str) -> anyhow::Result<Style> {
    let style = Style::load(name).map_err(|error| match error {
        StyleError::Unknown { .. } => anyhow::Error::from(Misuse::of(error)),
        _ => error.into(),
    })?;
    maps::check(&style)?;
    Ok(style)
}

/// Loads a style like [`style`], with other values at some keys, which were given by `option`.
///
/// # Errors
/// The errors of [`style`], and [`Misuse`] for a value.
pub(crate) fn style_with(option: &str, name: &str, values: &[SetValue]) -> anyhow::Result<Style> {
    let before = style(name)?;
    if values.is_empty() {
        return Ok(before);
    }
    let text = match preset_text(name) {
        Some(text) => text.to_owned(),
        None => read_text(Path::new(name), LARGEST_STYLE_BYTES)
            .map_err(|source| StyleError::Read { path: name.to_owned(), source })?,
    };
    let text = set::with_values(name, &text, &before, values).map_err(|error| of_value(option, error))?;
    let mut style = Style::parse(name, &text).map_err(|error| of_value(option, error))?;
    style.files.extend(before.files.into_iter().filter(|file| file == Path::new(name)));
    maps::check(&style)?;
    Ok(style)
}

/// Returns a style of a picture with other values at some keys. Recipes that are files are those of the picture.
///
/// # Errors
/// [`Misuse`] for a value.
pub(crate) fn with_values(style: Style, values: &[SetValue]) -> anyhow::Result<Style> {
    if values.is_empty() {
        return Ok(style);
    }
    let text =
        set::with_values(&style.name, &style.text(), &style, values).map_err(|error| of_value("--set", error))?;
    let changed =
        Style::parse_with(&style.name, &text, &style.recipe_files()).map_err(|error| of_value("--set", error))?;
    maps::check(&changed)?;
    Ok(changed)
}

/// Returns the error of a value that an option gives. Its line in the text of the style would not help.
pub(crate) fn of_value(option: &str, error: StyleError) -> Misuse {
    let cause = match error {
        StyleError::Parse(error) => error.cause,
        StyleError::Named { place, .. } => place.cause,
        other => other.to_string(),
    };
    Misuse(format!("{option}: {cause}"))
}

/// Checks that WORLD exists, if it is a file.
///
/// # Errors
/// Returns [`Misuse`] if the name looks like a mistyped command, is a bare name or a style, else an error that there is
/// no such file.
pub(crate) fn check_world(world: Option<&str>) -> anyhow::Result<()> {
    let Some(world) = world.filter(|world| !world.contains("://")) else { return Ok(()) };
    if world.is_empty() {
        return Err(Misuse("WORLD is empty; leave it out for the built-in world".to_owned()).into());
    }
    check_no_style(Path::new(world))?;
    // A file that may not be looked at is reported when it is opened.
    if Path::new(world).try_exists().unwrap_or(true) {
        return Ok(());
    }
    if embedded::scene(world).is_some() {
        return Ok(());
    }
    if let Some(mistyped) = mistyped_command(world) {
        return Err(Misuse(mistyped).into());
    }
    let name = if world.trim().is_empty() { quoted(world) } else { named(world) };
    let error = format!("{name}: {}", no_such_file(world));
    // A bare name is meant as that of a built-in scene.
    match world.contains(['.', '/', '\\']) {
        true => bail!(error),
        false => Err(Misuse(error).into()),
    }
}

/// Returns the text of a camera path.
///
/// # Errors
/// Returns [`Misuse`] for a bare name that no built-in path has, else why the file cannot be read.
pub(crate) fn camera_path(path: &Path) -> anyhow::Result<String> {
    CameraPath::read_text(path).map_err(|error| match error.is_unknown_name() {
        true => Misuse::of(error).into(),
        false => error.into(),
    })
}

/// Checks that a TOML file that is given as a world is not a style.
///
/// # Errors
/// Returns [`Misuse`] for a style.
fn check_no_style(world: &Path) -> Result<(), Misuse> {
    if world.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("toml")) || !world.is_file() {
        return Ok(());
    }
    // Mistakes in the file are reported when it is read as a scene.
    let text = read_text(world, LARGEST_SCENE_BYTES).unwrap_or_default();
    let keys = toml_text::keys(&world.to_string_lossy(), &text).unwrap_or_default();
    let has = |key: &str| keys.iter().any(|known| known == key);
    match !has("world") && ["tone", "lines", "layers", "paper"].into_iter().any(has) {
        true => Err(Misuse(format!("{0}: is a style; give it as --style {0}", named(world)))),
        false => Ok(()),
    }
}

/// Returns the message for a file that does not exist; for a bare name it lists the built-in scenes.
pub(crate) fn no_such_file(name: &str) -> String {
    match name.contains(['.', '/', '\\']) || name.trim().is_empty() {
        true => "there is no such file".to_owned(),
        false => {
            let meant = did_you_mean(name, embedded::SCENES.iter().map(|scene| scene.name));
            format!("there is no such file; the built-in scenes are {}{meant}", embedded::scene_names())
        }
    }
}

/// Checks that `file` is not a URL, since `command` only reads local files.
///
/// # Errors
/// Returns [`Misuse`] for a URL.
pub(crate) fn check_local(file: &Path, command: &str) -> Result<(), Misuse> {
    if !file.to_string_lossy().contains("://") || file.exists() {
        return Ok(());
    }
    // A URL may contain a password, so it is not repeated.
    Err(Misuse(format!("{command} reads local files only; render, bench, fly and info also read URLs")))
}
