//! `docs/commands.md` is the page that the definitions of the command line generate, and it leaves no option out.
#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic as the tests do")]

#[path = "../examples/shared/command_page.rs"]
mod command_page;

use std::fs;
use std::path::Path;

use clap::{Arg, ArgAction, Command};
use command_page::page;
use hachure::commands::program;

/// The number of the first line in which two pages differ, counted from 1.
fn first_difference(written: &str, generated: &str) -> Option<usize> {
    if written == generated {
        return None;
    }
    let same = written.lines().zip(generated.lines()).take_while(|(written, generated)| written == generated).count();
    Some(same + 1)
}

#[test]
fn the_page_is_current() {
    let written =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/commands.md")).unwrap_or_default();
    let generated = page(&program::definition());
    if let Some(line) = first_difference(&written, &generated) {
        panic!(
            "docs/commands.md is out of date from line {line} on; rewrite it with\n  \
             cargo run --release --example command_reference"
        );
    }

    // Planted: pages in which one line is spoiled, or missing.
    let lines: Vec<&str> = generated.lines().collect();
    for at in [0, lines.len() / 2, lines.len() - 1] {
        let mut spoiled = lines.clone();
        spoiled[at] = "spoiled";
        assert_eq!(first_difference(&(spoiled.join("\n") + "\n"), &generated), Some(at + 1));
        let mut shorter = lines.clone();
        shorter.remove(at);
        assert!(first_difference(&(shorter.join("\n") + "\n"), &generated).is_some(), "line {} is missing", at + 1);
    }
    // Planted: an option that is newer than the page.
    let option = Arg::new("planted").long("planted").help("Does nothing").action(ArgAction::SetTrue);
    let changed = program::definition().mut_subcommand("render", |render| render.arg(option));
    let newer = page(&changed);
    assert!(first_difference(&generated, &newer).is_some() && newer.contains("| `--planted` | Does nothing. |  |"));
}

/// The part of a page that is about one command, without those below it.
fn section<'a>(page: &'a str, title: &str) -> &'a str {
    let heading = format!("# `{title}`\n");
    let start = page.find(&heading).unwrap_or_else(|| panic!("{title} is not on the page")) + heading.len();
    page[start..].split("\n##").next().unwrap()
}

/// Arguments that a page does not have, of a command and all below it.
fn missing(page: &str, command: &Command, title: &str) -> Vec<String> {
    let text = section(page, title);
    let mut missing = Vec::new();
    for argument in command.get_arguments().filter(|argument| !argument.is_hide_set()) {
        let name = match argument.get_long() {
            Some(long) => format!("--{long}"),
            None => argument.get_value_names().unwrap()[0].to_string(),
        };
        let is_row = |line: &str| {
            let cell = line.strip_prefix("| `").and_then(|line| line.split('`').next()).unwrap_or_default();
            cell.split([' ', ',', '<', '>', '[', ']', '.']).any(|word| word == name)
        };
        if !text.lines().any(is_row) {
            missing.push(format!("{title} {name}"));
        }
    }
    for command in command.get_subcommands() {
        missing.extend(self::missing(page, command, &format!("{title} {}", command.get_name())));
    }
    missing
}

#[test]
fn every_argument_is_on_the_page() {
    let program = program::definition();
    let generated = page(&program);
    for command in program.get_subcommands() {
        let title = format!("{} {}", program.get_name(), command.get_name());
        assert_eq!(missing(&generated, command, &title), Vec::<String>::new());
    }
    // The program alone takes the options of the flight, and the two that all commands have.
    let fly = program.find_subcommand("fly").unwrap();
    for argument in program.get_arguments().filter(|argument| !argument.is_hide_set()) {
        let is_of_fly = fly.get_arguments().any(|other| other.get_id() == argument.get_id());
        assert!(is_of_fly || argument.is_global_set(), "{argument:?} is neither global nor an option of fly");
    }
    let everywhere =
        &generated[generated.find("## All commands").unwrap()..generated.find("## `hachure fly`").unwrap()];
    assert!(everywhere.contains("| `--adapter <") && everywhere.contains("| `-v, --verbose"), "{everywhere}");

    // Planted: a page that has lost the row of one option.
    let lost: Vec<&str> = generated.lines().filter(|line| !line.starts_with("| `--tolerance-px")).collect();
    let render = program.find_subcommand("render").unwrap();
    assert_eq!(missing(&lost.join("\n"), render, "hachure render"), ["hachure render --tolerance-px"]);
}

#[test]
fn a_row_has_name_values_help_and_default() {
    let tool = Command::new("tool").subcommand(
        Command::new("cut")
            .about("Cuts | a file")
            .arg(Arg::new("file").value_name("FILE").required(true).help("The file"))
            .arg(Arg::new("size").short('s').long("size").value_name("PX").default_value("7").help("How wide,\nin px"))
            .arg(Arg::new("mode").long("mode").value_name("MODE").value_parser(["a", "b"]).help("How [default: a]"))
            .arg(Arg::new("pen").long("pen").value_name("PEN").help_heading("Plotters").help("A <pen>"))
            .arg(Arg::new("secret").long("secret").value_name("X").hide(true)),
    );
    let made = page(&tool);
    for expected in [
        "\n## `tool cut`\n\nCuts \\| a file.\n",
        "**Arguments**\n\n| | what it does | default |\n| --- | --- | --- |\n| `<FILE>` | The file. | required |\n",
        "| `-s, --size <PX>` | How wide, in px. | `7` |\n",
        "| `--mode <MODE>` | How. Values: `a`, `b`. | a |\n",
        "**Plotters**\n\n| | what it does | default |\n| --- | --- | --- |\n| `--pen <PEN>` | A &lt;pen>. |  |\n",
    ] {
        assert!(made.contains(expected), "{expected:?} is not in\n{made}");
    }
    assert!(!made.contains("secret") && !made.contains("--help <") && !made.contains("| `-h"), "{made}");
}
