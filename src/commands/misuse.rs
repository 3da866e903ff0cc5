//! Errors in the arguments, each reported in one line; the exit status is 2.

use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::file::message::{did_you_mean, nearest, printable, quoted, shown};

/// The names of all commands.
pub const COMMANDS: [&str; 8] = ["fly", "render", "bench", "bake", "info", "styles", "completions", "man"];

/// The commands of `hachure styles`.
const STYLES_COMMANDS: [&str; 4] = ["list", "show", "check", "migrate"];

/// Options that `fly` does not have, and the command that the user probably meant.
const OF_COMMANDS: [(&str, &str); 15] = [
    ("-o", "render"),
    ("--output", "render"),
    ("--set", "render"),
    ("--like", "render"),
    ("--map", "render"),
    ("--fps", "render"),
    ("--aov", "render"),
    ("--show", "render"),
    ("--paper", "render"),
    ("--margin", "render"),
    ("--tolerance-px", "render"),
    ("--json", "info"),
    ("--styles", "bench"),
    ("--max-error", "bake"),
    ("--resume", "bake"),
];

/// Options that only `bake` has, and the alternatives in the other commands.
const BAKE_ONLY: [(&str, &str); 3] = [
    ("--spacing", "set spacing_m in NAME.ext.toml"),
    ("--raw-size", "set width and height in NAME.ext.toml"),
    ("--raw-big-endian", "set endian in NAME.ext.toml"),
];

/// Arguments that contradict each other, or that name something unknown. Nothing has been started.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Misuse(pub String);

impl Misuse {
    /// Converts an error, with its chain of causes, into misuse.
    pub fn of(error: impl std::error::Error + 'static) -> Self {
        Self(crate::file::message::chain(&error))
    }
}

/// Converts an error of the argument parser into one line; `words` are the arguments without the name of `program`.
pub fn describe(error: &clap::Error, words: &[String], program: &clap::Command) -> String {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(texts)) => texts.join(", "),
        Some(ContextValue::StyledStr(text)) => text.to_string(),
        _ => String::new(),
    };
    let (argument, value) = (text(ContextKind::InvalidArg), text(ContextKind::InvalidValue));
    // The name without its `<VALUE>`.
    let name = argument.split([' ', '=']).next().unwrap_or_default();
    let known = words.iter().find(|word| COMMANDS.contains(&word.as_str()));
    match error.kind() {
        ErrorKind::ValueValidation if name == "--map" && is_name(&value) => {
            format!("--map took {} as its value; put the DEM before --map", quoted(&value))
        }
        ErrorKind::ValueValidation => {
            let cause = std::error::Error::source(error).map_or_else(String::new, ToString::to_string);
            format!("{name} {}: {cause}{}", quoted(&value), did_you_mean(&value, choices(&cause)))
        }
        ErrorKind::InvalidValue if value.is_empty() => format!("{argument} needs a value"),
        ErrorKind::InvalidValue => {
            let valid = text(ContextKind::ValidValue);
            let meant = did_you_mean(&value, valid.split(", "));
            format!("{name} {}: it must be one of {valid}{meant}", quoted(&value))
        }
        ErrorKind::UnknownArgument => {
            if known.is_none()
                && let Some(mistyped) = first_free(words).and_then(mistyped_command)
            {
                return mistyped;
            }
            // clap suggests options that begin and end alike, so a slip of the finger would become another option.
            let of = known.and_then(|known| program.find_subcommand(known)).unwrap_or(program);
            let options = of.get_arguments().filter_map(|argument| argument.get_long());
            // clap also knows the options of all commands, and of those below this one.
            let of_clap = text(ContextKind::SuggestedArg);
            let of_clap = of_clap.split([' ', '=']).next().unwrap_or_default().trim_start_matches('-');
            let meant =
                nearest(name.trim_start_matches('-'), options.chain([of_clap])).filter(|meant| !meant.is_empty());
            let is_option = argument.starts_with('-');
            let instead = BAKE_ONLY.iter().find(|(option, _)| *option == name);
            if let (Some((_, instead)), Some(known)) = (instead, known.filter(|known| *known != "bake")) {
                return format!("{name} is an option of hachure bake; for hachure {known} {instead}");
            }
            match OF_COMMANDS.iter().find(|(option, _)| *option == name) {
                Some((_, command)) if known.is_none() => {
                    format!("{name} is an option of a command: hachure {command} …")
                }
                _ if is_option => match meant {
                    Some(meant) => format!("unknown option {}; did you mean --{meant}?", quoted(name)),
                    None => format!("unknown option {}; see {} --help", quoted(name), command(known)),
                },
                _ => format!("unexpected argument {}; see {} --help", quoted(&argument), command(known)),
            }
        }
        ErrorKind::InvalidSubcommand if known.is_none() => {
            let given = text(ContextKind::InvalidSubcommand);
            first_free(words)
                .and_then(mistyped_command)
                .or_else(|| mistyped_command(&given))
                .unwrap_or_else(|| format!("unexpected argument {}; see hachure --help", quoted(&given)))
        }
        ErrorKind::InvalidSubcommand => {
            let given = text(ContextKind::InvalidSubcommand);
            let meant = did_you_mean(&given, STYLES_COMMANDS);
            format!("{} has no {}{meant}", command(known), quoted(&given))
        }
        ErrorKind::MissingRequiredArgument => {
            let (missing, verb) = match error.get(ContextKind::InvalidArg) {
                Some(ContextValue::Strings(all)) if all.len() > 1 => (all.join(" and "), "are"),
                _ => (argument, "is"),
            };
            let has = |option: &str| words.iter().any(|word| word.split('=').next() == Some(option));
            match missing.split([' ', '[', '<', '=']).next() {
                Some("--map") if has("--at") => "--at is the centre of a map; add --map".to_owned(),
                Some("--look-at") if has("--from") => "--from is where --look-at looks from; add --look-at".to_owned(),
                _ => format!("{missing} {verb} missing; see {} --help", command(known)),
            }
        }
        ErrorKind::ArgumentConflict => match text(ContextKind::PriorArg) {
            prior if prior.is_empty() || prior == argument => format!("{name} is given twice"),
            prior => {
                let prior = prior.split([' ', '=']).next().unwrap_or_default();
                format!("{name} and {prior} cannot be used together")
            }
        },
        _ => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            printable(first.strip_prefix("error: ").unwrap_or(first), 160)
        }
    }
}

/// Returns whether a value cannot be a number or a list of numbers, and so was meant as a name.
fn is_name(value: &str) -> bool {
    !value.contains(',') && value.parse::<f64>().is_err()
}

fn command(known: Option<&String>) -> String {
    known.map_or_else(|| "hachure".to_owned(), |known| format!("hachure {known}"))
}

/// Returns the first argument that is neither an option nor an option's value.
fn first_free(words: &[String]) -> Option<&str> {
    let is_value = |before: &String| before.starts_with("--") && !before.contains('=') && before != "--verbose";
    words
        .iter()
        .enumerate()
        .find(|(at, word)| !word.starts_with('-') && (*at == 0 || !is_value(&words[at - 1])))
        .map(|(_, word)| word.as_str())
}

/// Returns a message if `word` is nearly a command and cannot be a world.
pub fn mistyped_command(word: &str) -> Option<String> {
    if word.contains(['.', '/', '\\']) || Path::new(word).exists() {
        return None;
    }
    let all = COMMANDS.into_iter().chain(STYLES_COMMANDS).chain(PLURALS.map(|(plural, _)| plural));
    let meant = nearest(word, all)?;
    let meant = PLURALS.into_iter().find(|(plural, _)| *plural == meant).map_or(meant, |(_, command)| command);
    let of_styles = if STYLES_COMMANDS.contains(&meant) { "hachure styles " } else { "" };
    Some(format!("{0} is neither a command nor a world; did you mean \"{of_styles}{meant}\"?", quoted(word)))
}

/// Words that are nearly commands.
const PLURALS: [(&str, &str); 3] = [("style", "styles"), ("draw", "render"), ("describe", "info")];

/// Returns the names that a cause lists as possible values: "it must be none or temporal".
fn choices(cause: &str) -> impl Iterator<Item = &str> {
    let listed = cause.split_once("must be ").map(|(_, listed)| listed).filter(|listed| listed.contains(" or "));
    // The text that follows is an example, not a choice.
    let listed = listed.unwrap_or_default().split(" like ").next().unwrap_or_default();
    let words = listed.split(|c: char| !c.is_ascii_alphanumeric() && c != '-');
    const NO_CHOICES: [&str; 8] = ["one", "number", "like", "above", "between", "and", "metres", "degrees"];
    let is_name = |word: &&str| word.len() > 2 && word.starts_with(|first: char| first.is_ascii_alphabetic());
    words.filter(is_name).filter(|word| !NO_CHOICES.contains(word))
}

/// Creates the error that `argument` is before the command.
pub fn before_command(argument: &str, command: &str) -> Misuse {
    Misuse(format!("{} must come after the command: hachure {command} …", shown(argument)))
}
