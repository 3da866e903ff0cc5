//! `hachure styles`: lists the presets, prints their text (a starting point for new styles) and parameters, and checks
//! style files.

mod all;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use serde::Serialize;

use super::misuse::Misuse;
use super::{print, print_json};
use crate::file::message::named;
use crate::style::{self, Style, StyleError};
use crate::tones::hatching::maps;

/// Arguments of `styles`.
#[derive(Debug, Args)]
pub struct StylesArgs {
    #[command(subcommand)]
    action: Option<Action>,
    /// Print as JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the presets, with a line about each (the default)
    List,
    /// Print the text of a preset, or every parameter of a style
    Show {
        /// Preset; with --all also a style file
        name: String,
        /// Print every parameter with its value, unit, range, default and meaning
        #[arg(long)]
        all: bool,
    },
    /// Check whether a style file is valid
    Check {
        /// Style file
        file: PathBuf,
    },
}

#[derive(Serialize)]
struct Listed {
    name: &'static str,
    description: String,
}

#[derive(Serialize)]
struct Shown<'a> {
    name: &'a str,
    text: &'a str,
}

#[derive(Serialize)]
struct Explained<'a> {
    name: &'a str,
    parameters: &'a [all::Row],
}

#[derive(Serialize)]
struct Checked<'a> {
    file: &'a Path,
    name: String,
    holds: bool,
}

/// Runs the command.
///
/// # Errors
/// Fails for an unknown preset or an invalid style file.
pub fn run(args: &StylesArgs) -> anyhow::Result<()> {
    match &args.action {
        None | Some(Action::List) => list(args.json),
        Some(Action::Show { name, all: true }) => {
            let (style, text) = all::load(name)?;
            let rows = all::rows(&style, &text)?;
            match args.json {
                true => print_json(&Explained { name: &style.name, parameters: &rows }),
                false => print(&all::table(&style, &rows)),
            }
        }
        Some(Action::Show { name, all: false }) => {
            let text =
                style::preset_text(name).ok_or_else(|| Misuse::of(StyleError::Unknown { name: name.clone() }))?;
            if args.json { print_json(&Shown { name, text }) } else { print(text) }
        }
        Some(Action::Check { file }) => {
            let style = read(file)?;
            let checked = Checked { file, name: style.name, holds: true };
            if args.json { print_json(&checked) } else { print(&format!("{}: valid", named(file))) }
        }
    }
}

fn list(json: bool) -> anyhow::Result<()> {
    let mut listed = Vec::new();
    for name in style::names() {
        listed.push(Listed { name, description: Style::load(name)?.description });
    }
    if json {
        return print_json(&listed);
    }
    let width = listed.iter().map(|style| style.name.len()).max().unwrap_or(0);
    let lines: Vec<String> =
        listed.iter().map(|style| format!("{:width$}  {}", style.name, style.description)).collect();
    print(&lines.join("\n"))
}

/// Reads a style file, whatever its extension.
pub(super) fn read(file: &Path) -> anyhow::Result<Style> {
    let style = Style::read(file)?;
    maps::check(&style)?;
    Ok(style)
}
