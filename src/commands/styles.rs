//! `hachure styles`: the presets, their text as a start for one's own, their parameters, and a check of one's own.

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
    /// Print for programs
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// The presets, with a line about each (the default)
    List,
    /// The text of a preset, or every parameter of a style
    Show {
        /// A preset; with --all a style file as well
        name: String,
        /// Every parameter with its value, unit, range, default and what it does
        #[arg(long)]
        all: bool,
    },
    /// Whether a style file holds
    Check {
        /// The style file
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
/// An unknown preset; a file that is no style.
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
            if args.json { print_json(&checked) } else { print(&format!("{}: holds", named(file))) }
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

/// A style from a file, whatever its name ends with.
pub(super) fn read(file: &Path) -> anyhow::Result<Style> {
    let style = Style::read(file)?;
    maps::check(&style)?;
    Ok(style)
}
