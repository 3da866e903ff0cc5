//! `hachure man`: prints the manual page of the program, or writes the pages of the program and of all its commands.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Command};
use clap_mangen::Man;

use super::print;
use crate::file::message::named;
use crate::file::{FileError, atomic, standard, unnamed};

/// Arguments of `man`.
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Folder for one page for hachure and one for each command; it is created if it is missing. Without a folder, the
    /// page of hachure is printed
    folder: Option<PathBuf>,
    /// Replace files in the folder even if hachure did not write them
    #[arg(long, requires = "folder")]
    overwrite: bool,
}

/// The first line of each page, by which hachure recognises its own files.
const MARK: &str = ".\\\" Written by hachure man.\n";

/// Sections of every page that do not follow from its options.
const EXIT_STATUS: &str = "\
.SH \"EXIT STATUS\"
0: success. 1: failure. 2: wrong arguments. An error is one line on standard error.
";

/// Sections of the page of the program.
const ENVIRONMENT: &str = "\
.SH ENVIRONMENT
.TP
.B HACHURE_CACHE
Folder for baked elevation data and blocks of remote files, instead of the cache folder of the system. hachure uses only
its own subfolder there.
.SH EXAMPLES
.nf
hachure mountain.tif
hachure render mountain.tif \\-o mountain.png \\-\\-style engraving
hachure styles
.fi
";

/// A manual page.
struct Page {
    /// Name of the file, such as `hachure-render.1`.
    name: String,
    /// The page in roff.
    text: String,
}

/// Prints the page of the program, or writes all pages of the command line that `program` defines.
///
/// # Errors
/// Fails if a file exists that hachure did not write, or if a file cannot be written. No file is written if one of them
/// may not be replaced.
pub(crate) fn run(args: &ManArgs, program: &Command) -> anyhow::Result<()> {
    let Some(folder) = &args.folder else {
        return Ok(standard::print(&page(&built(program))?.text)?);
    };
    let pages = pages(program)?;
    let paths: Vec<PathBuf> = pages.iter().map(|page| folder.join(&page.name)).collect();
    paths.iter().try_for_each(|path| unnamed::check(path, args.overwrite, is_own))?;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", named(folder)))?;
    for (page, path) in pages.iter().zip(&paths) {
        atomic::write(path, page.text.as_bytes()).map_err(|error| FileError::write(path, error))?;
    }
    print(&format!("{}: {} manual pages", named(folder), pages.len()))
}

/// Returns whether hachure wrote the page at `path`.
fn is_own(path: &Path) -> bool {
    unnamed::head(path, MARK.len()) == MARK.as_bytes()
}

/// Completes the definition: each command then has the options of all commands and its full name.
fn built(program: &Command) -> Command {
    // The command `help` repeats what `--help` and these pages say.
    let mut program = program.clone().disable_help_subcommand(true);
    program.build();
    program
}

/// Returns the pages of the program, its commands, and the commands of these.
fn pages(program: &Command) -> io::Result<Vec<Page>> {
    let mut pages = Vec::new();
    append(&built(program), &mut pages)?;
    Ok(pages)
}

fn append(command: &Command, pages: &mut Vec<Page>) -> io::Result<()> {
    pages.push(page(command)?);
    command.get_subcommands().filter(|command| !command.is_hide_set()).try_for_each(|command| append(command, pages))
}

/// Returns the page of one command.
fn page(command: &Command) -> io::Result<Page> {
    let source = concat!("hachure ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).source(source).manual("Manual of hachure");
    let (name, is_program) = (man.get_filename(), command.get_version().is_some());
    let mut text = MARK.as_bytes().to_vec();
    man.render_title(&mut text)?;
    man.render_name_section(&mut text)?;
    man.render_synopsis_section(&mut text)?;
    man.render_description_section(&mut text)?;
    man.render_options_section(&mut text)?;
    if command.get_subcommands().any(|command| !command.is_hide_set()) {
        man.render_subcommands_section(&mut text)?;
    }
    text.write_all(EXIT_STATUS.as_bytes())?;
    text.write_all(if is_program { ENVIRONMENT } else { ".SH \"SEE ALSO\"\nhachure(1)\n" }.as_bytes())?;
    Ok(Page { name, text: String::from_utf8(text).map_err(io::Error::other)? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::misuse::COMMANDS;
    use crate::commands::program;

    /// Returns the options of a command that a page does not describe.
    fn missing(page: &str, command: &Command) -> Vec<String> {
        let options = command.get_arguments().filter(|argument| !argument.is_hide_set());
        let names = options.filter_map(|argument| Some(format!("--{}", argument.get_long()?)));
        let is_missing = |name: &String| {
            let bold = format!("\\fB{}\\fR", name.replace('-', "\\-"));
            !page.lines().any(|line| line.starts_with(&bold) || line.contains(&format!(", {bold}")))
        };
        names.filter(is_missing).collect()
    }

    #[test]
    fn pages_have_every_command_and_every_option() {
        let program = program::definition();
        let pages = pages(&program).unwrap();
        let text = |name: &str| &pages.iter().find(|page| page.name == name).unwrap().text;
        assert_eq!(missing(text("hachure.1"), &program), Vec::<String>::new());
        for command in program.get_subcommands() {
            let name = command.get_name();
            assert!(COMMANDS.contains(&name), "{name}");
            assert_eq!(missing(text(&format!("hachure-{name}.1")), command), Vec::<String>::new(), "{name}");
            assert!(text("hachure.1").contains(&format!("hachure\\-{name}(1)")), "{name}");
        }
        assert_eq!(program.get_subcommands().count(), COMMANDS.len());
        assert!(text("hachure-styles-show.1").contains("\\fB\\-\\-all\\fR"));

        // Planted: an option that is newer than the page, and a page without one of its options.
        let newer = program.find_subcommand("render").unwrap().clone().arg(clap::Arg::new("x").long("planted-option"));
        assert_eq!(missing(text("hachure-render.1"), &newer), ["--planted-option"]);
        let spoiled = text("hachure-render.1").replace("\\fB\\-\\-tolerance\\-px\\fR", "");
        assert_eq!(missing(&spoiled, program.find_subcommand("render").unwrap()), ["--tolerance-px"]);
    }
}
