//! The text of `docs/commands.md`, generated from the definitions by which clap parses the command line.

use std::fmt::Write as _;

use clap::{Arg, Command};

const HEAD: &str = "\
# Command reference

This page is generated from the definitions of the command line; `cargo run --release --example command_reference` \
rewrites it. `hachure COMMAND --help` prints the same for one command. [The guide](README.md) explains the options by \
task, with examples.

Without a command, hachure opens a window and takes the options of `hachure fly`. Exit status: 0 success, 1 failure, \
2 wrong arguments.
";

/// Returns the page: how the program is called, the options of all commands, and each command with its arguments.
pub(crate) fn page(program: &Command) -> String {
    // Building completes the usage lines and the number of values. It also adds global options and `--help` to each
    // command, so each command lists only the arguments of its own definition.
    let mut built = program.clone();
    built.build();
    let mut text = HEAD.to_owned();
    usage(&mut text, &built);
    text.push_str("\n| command | what it does |\n| --- | --- |\n");
    for (_, command) in commands(program, &built) {
        let title = title(command);
        // Writing into a string does not fail.
        let _ = writeln!(text, "| [`{title}`](#{}) | {} |", title.replace(' ', "-"), about(command));
    }
    text.push_str("\n## All commands\n");
    let everywhere: Vec<&Arg> = own(program, &built).into_iter().filter(|argument| argument.is_global_set()).collect();
    tables(&mut text, &everywhere);
    for (defined, command) in commands(program, &built) {
        section(&mut text, defined, command, "##");
    }
    text
}

/// Appends a command and those below it.
fn section(text: &mut String, defined: &Command, built: &Command, level: &str) {
    let _ = write!(text, "\n{level} `{}`\n\n{}.\n", title(built), about(built));
    usage(text, built);
    tables(text, &own(defined, built));
    for (defined, command) in commands(defined, built) {
        section(text, defined, command, &format!("{level}#"));
    }
}

/// Returns the visible commands of a program: each as it is defined, and as it is built.
fn commands<'a>(defined: &'a Command, built: &'a Command) -> Vec<(&'a Command, &'a Command)> {
    let visible = defined.get_subcommands().filter(|command| !command.is_hide_set());
    visible.filter_map(|command| Some((command, built.find_subcommand(command.get_name())?))).collect()
}

/// Returns the visible arguments that a command defines itself, as they are built.
fn own<'a>(defined: &Command, built: &'a Command) -> Vec<&'a Arg> {
    let is_own = |argument: &Arg| defined.get_arguments().any(|own| own.get_id() == argument.get_id());
    built.get_arguments().filter(|argument| !argument.is_hide_set() && is_own(argument)).collect()
}

/// Returns the words by which a command is called, for example `hachure styles show`.
fn title(built: &Command) -> &str {
    built.get_bin_name().unwrap_or(built.get_name())
}

/// Returns the description of a command, without the last full stop.
fn about(command: &Command) -> String {
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let paragraphs = about.split("\n\n").map(|paragraph| paragraph.trim().trim_end_matches('.'));
    prose(&paragraphs.collect::<Vec<_>>().join(". "))
}

fn usage(text: &mut String, built: &Command) {
    let usage = built.clone().render_usage().to_string();
    text.push_str("\n```text\n");
    for line in usage.trim_start_matches("Usage:").lines() {
        let _ = writeln!(text, "{}", line.trim());
    }
    text.push_str("```\n");
}

/// Appends a table for each help heading. Arguments without a heading come first.
fn tables(text: &mut String, arguments: &[&Arg]) {
    let mut headings = vec!["Arguments", "Options"];
    for argument in arguments {
        if !headings.contains(&heading(argument)) {
            headings.push(heading(argument));
        }
    }
    for shown in headings {
        let mut rows = arguments.iter().filter(|argument| heading(argument) == shown).peekable();
        if rows.peek().is_none() {
            continue;
        }
        let _ = write!(text, "\n**{shown}**\n\n| | what it does | default |\n| --- | --- | --- |\n");
        for argument in rows {
            let (help, default) = help_and_default(argument);
            let _ = writeln!(text, "| `{}` | {help} | {default} |", name(argument).replace('|', "\\|"));
        }
    }
}

fn heading(argument: &Arg) -> &str {
    argument.get_help_heading().unwrap_or(if argument.is_positional() { "Arguments" } else { "Options" })
}

/// Returns the argument as it is typed: `-o, --output <OUTPUT>`.
fn name(argument: &Arg) -> String {
    match (argument.get_short(), argument.get_long()) {
        (Some(short), Some(_)) => format!("-{short}, {argument}"),
        _ => argument.to_string(),
    }
}

/// Returns the help with the possible values, and the default. A help may end with its default: `[default: 10]`.
fn help_and_default(argument: &Arg) -> (String, String) {
    let help = argument.get_long_help().or(argument.get_help()).map(ToString::to_string).unwrap_or_default();
    let help = help.trim_end_matches('.');
    let written = help.strip_suffix(']').and_then(|help| help.rsplit_once("[default: "));
    let (help, written) = written.map_or((help, ""), |(help, default)| (help.trim_end(), default));
    let values: Vec<String> = argument
        .get_default_values()
        .iter()
        .map(|value| value.to_string_lossy().into_owned())
        .filter(|value| !value.is_empty())
        .collect();
    let default = if argument.is_required_set() {
        "required".to_owned()
    } else if values.is_empty() || !argument.get_action().takes_values() || argument.is_hide_default_value_set() {
        prose(written)
    } else {
        format!("`{}`", values.join(","))
    };
    (format!("{}.{}", prose(help.trim_end_matches('.')), possible_values(argument)), default)
}

fn possible_values(argument: &Arg) -> String {
    let mut shown = String::new();
    if argument.is_hide_possible_values_set() {
        return shown;
    }
    for value in argument.get_possible_values().iter().filter(|value| !value.is_hide_set()) {
        shown.push_str(if shown.is_empty() { " Values: " } else { ", " });
        let _ = write!(shown, "`{}`", value.get_name());
        if let Some(help) = value.get_help() {
            let _ = write!(shown, " ({})", prose(help.to_string().trim_end_matches('.')));
        }
    }
    if !shown.is_empty() {
        shown.push('.');
    }
    shown
}

/// Returns the text as one line of Markdown that is safe in a table.
fn prose(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.replace('|', "\\|").replace('<', "&lt;")
}
