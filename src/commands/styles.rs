//! `hachure styles`: lists the presets, prints the text (a starting point for new styles) and the parameters of a
//! style, checks style files, and migrates older ones.

mod all;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use serde::Serialize;

use super::misuse::Misuse;
use super::{print, print_json};
use crate::file::atomic;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::message::named;
use crate::style::{self, Style};
use crate::tones::hatching::maps;

/// Arguments of `styles`.
#[derive(Debug, Args)]
pub(crate) struct StylesArgs {
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
    /// Print a style as TOML in the current form, or every parameter of it
    Show {
        /// Preset (`hachure styles` lists them) or style file
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
    /// Print a style file in the current form; comments are kept, and the file itself is not changed
    ///
    /// In the current form, ink layers are a list, [[layers]]. Older style files have a section for each kind of layer
    /// ([strokes], [cuts]). They are still read, but only [[layers]] can be reordered and, for some kinds, repeated.
    /// [[hatching.layers]] become [[layers.sets]], and [[cuts.layers]] become [[layers.families]]. A file that `hachure
    /// styles check` refuses is not migrated.
    Migrate {
        /// Style file
        file: PathBuf,
        /// New file for the text; a file that exists is not overwritten
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
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

#[derive(Serialize)]
struct Migrated<'a> {
    file: &'a Path,
    output: &'a Path,
    has_changed: bool,
}

/// Runs the command.
///
/// # Errors
/// Fails for an unknown preset or an invalid style file.
pub(crate) fn run(args: &StylesArgs) -> anyhow::Result<()> {
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
            let (_, text) = all::load(name)?;
            let text = &style::migrated(name, &text)?;
            if args.json { print_json(&Shown { name, text }) } else { print(text.trim_end_matches('\n')) }
        }
        Some(Action::Migrate { file, output }) => {
            check_no_preset(file, "migrate")?;
            migrate(file, output.as_deref(), args.json)
        }
        Some(Action::Check { file }) => {
            check_no_preset(file, "check")?;
            let style = read(file)?;
            let checked = Checked { file, name: style.name, holds: true };
            if args.json { print_json(&checked) } else { print(&format!("{}: valid", named(file))) }
        }
    }
}

/// Loads a preset or a style file, with its text.
///
/// # Errors
/// Fails for an unknown preset or an invalid style file.
pub(crate) fn load(name: &str) -> anyhow::Result<(Style, String)> {
    all::load(name)
}

/// Returns the parameters of a style as JSON; `text` is the TOML from which it was read.
///
/// # Errors
/// Fails if a value cannot be written as JSON.
pub(crate) fn parameters(style: &Style, text: &str) -> anyhow::Result<String> {
    Ok(serde_json::to_string(&all::rows(style, text)?)?)
}

/// Checks that `file` is not the name of a preset, since `action` reads a file.
///
/// # Errors
/// Returns [`Misuse`] for the name of a preset, unless a file of that name exists.
fn check_no_preset(file: &Path, action: &str) -> Result<(), Misuse> {
    match file.to_str().filter(|name| style::names().contains(name) && !file.exists()) {
        Some(name) => Err(Misuse(format!(
            "{name} is a preset, but hachure styles {action} reads a file; hachure styles show {name} prints the preset"
        ))),
        None => Ok(()),
    }
}

/// Prints a style file in its current form, or writes it to a new file.
fn migrate(file: &Path, output: Option<&Path>, json: bool) -> anyhow::Result<()> {
    let text =
        read_text(file, LARGEST_STYLE_BYTES).with_context(|| format!("{}: cannot read the style", named(file)))?;
    let migrated = style::migrated(&file.display().to_string(), &text)?;
    let Some(output) = output else {
        return match json {
            true => print_json(&Shown { name: &file.display().to_string(), text: &migrated }),
            false => print(migrated.trim_end_matches('\n')),
        };
    };
    if output.symlink_metadata().is_ok() {
        bail!("{}: the file exists; choose another name", named(output));
    }
    atomic::write(output, migrated.as_bytes()).with_context(|| format!("cannot write {}", named(output)))?;
    let changed = if migrated == text { "nothing had to change" } else { "written" };
    match json {
        true => print_json(&Migrated { file, output, has_changed: migrated != text }),
        false => print(&format!("{}: {changed}", named(output))),
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
