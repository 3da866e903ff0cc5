//! Errors of styles and of the recipes and images that they refer to.

use super::{marks, names, texture};
use crate::file::hdr::HdrError;
use crate::file::message::{did_you_mean, named, printable, shown};
use crate::file::toml_text::TomlError;

/// Longest name of a recipe in an error, in characters, so that the list of available names still fits after it.
const LONGEST_NAME: usize = 40;

/// Why a style cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum StyleError {
    /// The name is neither a preset nor a `.toml` file.
    #[error("{}: no such style{}", shown(name), hint(name, &names(), "`hachure styles` lists the presets"))]
    Unknown {
        /// The name, as given.
        name: String,
    },
    /// The style file cannot be read.
    #[error("{}: cannot read the style: {source}", named(path))]
    Read {
        /// Path of the file.
        path: String,
        #[source]
        source: std::io::Error,
    },
    /// The name is neither a built-in stroke texture nor a `.toml` or `.png` file.
    #[error("{}: no such stroke texture{}", cut(name), hint_of_texture(name))]
    UnknownTexture {
        /// The name, as given.
        name: String,
    },
    /// The file of a stroke texture cannot be read.
    #[error("{}: cannot read the stroke texture: {source}", named(path))]
    ReadTexture {
        /// Path of the file.
        path: String,
        #[source]
        source: std::io::Error,
    },
    /// The name is neither a built-in recipe of hatching marks nor a `.toml` file.
    #[error("{}: no such marks{}", cut(name), hint(name, &marks::names(), &there_is(&marks::names())))]
    UnknownMarks {
        /// The name, as given.
        name: String,
    },
    /// The file of a recipe of hatching marks cannot be read.
    #[error("{}: cannot read the marks: {source}", named(path))]
    ReadMarks {
        /// Path of the file.
        path: String,
        #[source]
        source: std::io::Error,
    },
    /// An image of hatching marks or of a stroke is missing or unusable.
    #[error("{}: {cause}", named(path))]
    Image {
        /// Path of the image.
        path: String,
        /// The cause, in one line.
        cause: String,
    },
    /// A condition on attributes of features has a mistake.
    #[error("{0}")]
    Condition(
        /// The column in the condition, and what is wrong there.
        String,
    ),
    /// The environment map (`.hdr`) cannot be used.
    #[error(transparent)]
    Environment(#[from] HdrError),
    /// A recipe or image that the style refers to cannot be loaded.
    #[error("{place}")]
    Named {
        /// The place in the style that names it, and what is wrong with it.
        place: TomlError,
        /// The underlying error.
        #[source]
        source: Box<Self>,
    },
    /// The text is not a valid style, stroke texture or recipe of hatching marks.
    #[error(transparent)]
    Parse(#[from] TomlError),
}

fn cut(name: &str) -> String {
    printable(name, LONGEST_NAME)
}

/// Returns the end of the message: the most similar known name or, without one, the available names.
fn hint(name: &str, known: &[&str], where_told: &str) -> String {
    let meant = did_you_mean(name, known.iter().copied());
    if meant.is_empty() { format!("; {where_told}; a file name must end with .toml") } else { meant }
}

fn hint_of_texture(name: &str) -> String {
    let hint = hint(name, &texture::names(), &there_is(&texture::names()));
    hint.replace("end with .toml", "end with .toml, or .png for a picture of a stroke")
}

fn there_is(names: &[&str]) -> String {
    format!("available: {}", names.join(", "))
}
