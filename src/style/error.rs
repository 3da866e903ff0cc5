//! What is wrong with a style, or with what it names.

use super::{marks, names, texture};
use crate::file::hdr::HdrError;
use crate::file::message::{did_you_mean, named, printable, shown};
use crate::file::toml_text::TomlError;

/// Characters of the name of a recipe in errors, at most: the names that there are follow it.
const LONGEST_NAME: usize = 40;

/// A style that is not there or does not hold.
#[derive(Debug, thiserror::Error)]
pub enum StyleError {
    /// Neither a preset nor a file.
    #[error("{}: no such style{}", shown(name), hint(name, &names(), "`hachure styles` lists them"))]
    Unknown {
        /// As given.
        name: String,
    },
    /// The file cannot be read.
    #[error("{}: cannot read the style: {source}", named(path))]
    Read {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// Neither a stroke texture of the program nor a file.
    #[error("{}: no such stroke texture{}", cut(name), hint(name, &texture::names(), &there_is(&texture::names())))]
    UnknownTexture {
        /// As given.
        name: String,
    },
    /// The stroke texture's file cannot be read.
    #[error("{}: cannot read the stroke texture: {source}", named(path))]
    ReadTexture {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// Neither marks of the program nor a file.
    #[error("{}: no such marks{}", cut(name), hint(name, &marks::names(), &there_is(&marks::names())))]
    UnknownMarks {
        /// As given.
        name: String,
    },
    /// The marks' file cannot be read.
    #[error("{}: cannot read the marks: {source}", named(path))]
    ReadMarks {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A picture of marks does not hold.
    #[error("{}: {cause}", named(path))]
    MarkImage {
        /// The picture.
        path: String,
        /// What, in one line.
        cause: String,
    },
    /// A picture of the surroundings does not hold.
    #[error(transparent)]
    Environment(#[from] HdrError),
    /// A recipe that a style names is not there or does not hold.
    #[error("{place}")]
    Named {
        /// Where the style names it, and what is wrong with it.
        place: TomlError,
        /// What is wrong with it.
        #[source]
        source: Box<Self>,
    },
    /// The text is not a style, not a stroke texture, or not marks.
    #[error(transparent)]
    Parse(#[from] TomlError),
}

fn cut(name: &str) -> String {
    printable(name, LONGEST_NAME)
}

/// What a name was meant to be, or where the known names are told.
fn hint(name: &str, known: &[&str], where_told: &str) -> String {
    let meant = did_you_mean(name, known.iter().copied());
    if meant.is_empty() { format!("; {where_told}, and a file ends with .toml") } else { meant }
}

fn there_is(names: &[&str]) -> String {
    format!("there is {}", names.join(", "))
}
