//! TOML that people write: scenes, styles, recipes of marks and stroke textures, sidecar files.
//!
//! All of these are read by [`read`], so that every mistake is reported in the same form: the file, the line and the
//! column, the key, and what would be right, in the terms of the file format rather than of the program's types. `toml`
//! parses the text; `values` passes its values to serde and knows the position of each of them.

mod mistake;
mod values;

use std::fmt::Display;
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use self::mistake::Mistake;
pub(crate) use self::mistake::described;
use super::message::{named, printable};

/// The reason why a text is not TOML, or not of the expected form. One line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{}: {cause}", named(name), at.map_or(String::new(), |[line, column]| format!(":{line}:{column}")))]
pub struct TomlError {
    pub name: String,
    /// Line and column in characters, counted from 1, if they are known.
    pub at: Option<[usize; 2]>,
    /// The key, what is wrong with it, and what would be right.
    pub cause: String,
}

/// Reads a text; `name` is the name of the file in errors.
///
/// # Errors
/// Fails if the text is not TOML, if a key is unknown or missing, or if a value has the wrong type.
pub(crate) fn read<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, TomlError> {
    let table = parse(name, text)?;
    T::deserialize(values::Root(&table)).map_err(|mistake| toml_error(name, text, &mistake))
}

/// A mistake that is found while the table of a text is rewritten.
pub(crate) struct Misplaced {
    /// Byte range of the key or value.
    pub at: Range<usize>,
    /// The message, without the file's name and the position.
    pub words: String,
}

/// Does the same as [`read`] with a table that `rewrite` has changed. Layers of a style are called by their kinds in
/// errors: `cuts.form_px`, and `cuts[1].form_px` in the second layer of cuts.
///
/// # Errors
/// The errors of [`read`], and those of `rewrite`.
pub(crate) fn read_rewritten<T: DeserializeOwned>(
    name: &str,
    text: &str,
    rewrite: impl FnOnce(&mut DeTable<'_>) -> Result<(), Misplaced>,
) -> Result<T, TomlError> {
    let mut table = parse(name, text)?;
    if let Err(Misplaced { at, words }) = rewrite(table.get_mut()) {
        return Err(TomlError { name: name.to_owned(), at: Some(position(text, at.start)), cause: words });
    }
    T::deserialize(values::Root(&table)).map_err(|mut mistake| {
        if let [first, index, kind, ..] = mistake.path.as_slice()
            && first == "layers"
            && kind != "kind"
        {
            let index = index.trim_matches(['[', ']']).parse().unwrap_or(0);
            let key = match layers_below(table.get_ref(), kind, index) {
                0 => kind.clone(),
                below => format!("{kind}[{below}]"),
            };
            mistake.path.splice(..3, [key]);
        }
        let mut error = toml_error(name, text, &mistake);
        // Only styles have tones; the command does not list the keys of recipes.
        if mistake.is_unknown_without_hint() && table.get_ref().contains_key("tone") {
            error.cause.push_str("; hachure styles show NAME --all lists the keys of a style");
        }
        error
    })
}

/// Returns how many of the first `index` layers are of a kind.
fn layers_below(table: &DeTable<'_>, kind: &str, index: usize) -> usize {
    let layers = table.get("layers").and_then(|layers| layers.get_ref().as_array());
    let is_kind =
        |layer: &&Spanned<DeValue<'_>>| layer.get_ref().as_table().is_some_and(|layer| layer.contains_key(kind));
    layers.map_or(0, |layers| layers.iter().take(index).filter(is_kind).count())
}

/// Returns the top-level keys of a TOML text.
///
/// # Errors
/// Fails if the text is not TOML.
pub(crate) fn keys(name: &str, text: &str) -> Result<Vec<String>, TomlError> {
    Ok(parse(name, text)?.get_ref().keys().map(|key| key.get_ref().to_string()).collect())
}

/// A value of the right type that is not acceptable. Scenes, styles and recipes are checked as values, and
/// [`Wrong::in_text`] turns the findings into errors with a position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Wrong {
    /// The key with its sections; an index `[2]` selects the third entry of a list: `hatching.sets[2].from`.
    pub key: String,
    /// The error message, without the file's name and the position.
    pub message: String,
}

impl Wrong {
    /// Builds the message from the key, without indices, and `words`, which follow it: ` is 3, not between 0 and 1`.
    /// The position in the text shows which entry of a list is meant.
    pub(crate) fn new(key: impl Into<String>, words: impl Display) -> Self {
        let key = key.into();
        let parts = key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest));
        let message = format!("{}{words}", parts.collect::<String>());
        Self { key, message }
    }

    /// Builds a message that need not begin with the key.
    pub(crate) fn with_message(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into() }
    }

    /// Returns the error with the position of the value in the text. For a key that is missing this is the position of
    /// its section, if that exists. `name` is the name of the file.
    pub(crate) fn in_text(&self, name: &str, text: &str) -> TomlError {
        let table = parse(name, text).ok();
        let at = table.and_then(|table| place_of(table.get_ref(), &self.key)).map(|at| position(text, at.start));
        TomlError { name: name.to_owned(), at, cause: self.message.clone() }
    }
}

fn parse<'a>(name: &str, text: &'a str) -> Result<Spanned<DeTable<'a>>, TomlError> {
    DeTable::parse(text).map_err(|error| {
        let at = error.span().map(|span| position(text, span.start));
        TomlError { name: name.to_owned(), at, cause: printable(&plain(error.message()), 120) }
    })
}

/// Replaces the parser's words for a text without a closing quotation mark.
fn plain(message: &str) -> String {
    let unclosed = ["invalid basic string, expected `\"`", "invalid literal string, expected `'`"];
    match unclosed.contains(&message) {
        true => "the text is not closed with a quotation mark on its line".to_owned(),
        false => message.to_owned(),
    }
}

fn toml_error(name: &str, text: &str, mistake: &Mistake) -> TomlError {
    let at = mistake.at.as_ref().map_or(0, |span| span.start);
    TomlError { name: name.to_owned(), at: Some(position(text, at)), cause: mistake.cause() }
}

/// Returns the line and column of a byte offset, counted from 1.
fn position(text: &str, byte: usize) -> [usize; 2] {
    let before = &text[..text.floor_char_boundary(byte)];
    let line = before.rsplit('\n').next().unwrap_or(before);
    [before.matches('\n').count() + 1, line.trim_start_matches('\u{feff}').chars().count() + 1]
}

/// Returns the byte range of a key's value.
fn place_of(table: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    let (first, index) = match first.strip_suffix(']').and_then(|first| first.split_once('[')) {
        Some((first, index)) => (first, index.parse().ok()),
        None => (first, None),
    };
    let mut value = table.get(first)?;
    if let (Some(index), DeValue::Array(list)) = (index, value.get_ref()) {
        value = list.get::<usize>(index).unwrap_or(value);
    }
    let below = match (rest, value.get_ref()) {
        (Some(rest), DeValue::Table(table)) => place_of(table, rest),
        _ => None,
    };
    below.or_else(|| Some(value.span()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only their types count")]
    struct Sheet {
        title: String,
        #[serde(default)]
        copies: u32,
        frame: Option<Frame>,
        #[serde(default)]
        dots: Vec<Dot>,
        fold: Option<Fold>,
        ink: Option<Ink>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only their types count")]
    struct Frame {
        width_px: f32,
        #[serde(default)]
        rounded: bool,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Dot {
        at: [f64; 2],
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Fold {
        Half,
        Letter,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields, rename_all = "lowercase", tag = "kind")]
    #[expect(dead_code, reason = "only their types count")]
    enum Ink {
        Plain,
        Mixed {
            parts: f32,
            #[serde(default)]
            tints: Vec<Tint>,
        },
    }

    /// A text with a meaning.
    #[derive(Debug)]
    struct Tint;

    impl<'de> Deserialize<'de> for Tint {
        fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let text = String::deserialize(deserializer)?;
            let cause = || serde::de::Error::custom(format!("{} is not a tint", super::super::message::quoted(&text)));
            (text == "red").then_some(Self).ok_or_else(cause)
        }
    }

    fn mistake(text: &str) -> String {
        read::<Sheet>("sheet.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn valid_texts_are_read() {
        let text = "title = \"a\"\ncopies = 3\nfold = \"half\"\ndots = [{ at = [1, 2.5] }]\n\
                    [frame]\nwidth_px = 2\n[ink]\nkind = \"mixed\"\nparts = 1\n";
        let sheet: Sheet = read("sheet.toml", text).unwrap();
        assert!(sheet.copies == 3 && sheet.dots[0].at == [1.0, 2.5] && sheet.frame.unwrap().width_px == 2.0);
        assert!(matches!((sheet.fold, sheet.ink), (Some(Fold::Half), Some(Ink::Mixed { parts: 1.0, .. }))));
    }

    #[test]
    fn mistakes_have_a_place_and_what_would_be_right() {
        for (text, expected) in [
            ("titel = \"a\"", "sheet.toml:1:1: unknown key \"titel\"; did you mean \"title\"?"),
            ("", "sheet.toml:1:1: the key \"title\" is missing"),
            ("title = \"a\"\n[frame]\n", "sheet.toml:2:1: the key \"frame.width_px\" is missing"),
            ("title = 3", "sheet.toml:1:9: title must be text, but 3 is a number"),
            (
                "title = \"a\"\n\n[frame]\n  width_px = \"thin\"",
                "sheet.toml:4:14: frame.width_px must be a number, but \"thin\" is text",
            ),
            (
                "title = \"a\"\n[frame]\nwidth_px = 1\nrounded = 1",
                "sheet.toml:4:11: frame.rounded must be true or false, but 1 is a number",
            ),
            ("title = \"ä\"\nframe = 3", "sheet.toml:2:9: frame must be a table, but 3 is a number"),
            (
                "title = \"\"\ncopies = -1",
                "sheet.toml:2:10: copies must be a whole number from 0 to 4294967295, but it is -1",
            ),
            (
                "title = \"\"\ncopies = 1.5",
                "sheet.toml:2:10: copies must be a whole number from 0 to 4294967295, but it is 1.5",
            ),
            ("title = \"\"\ndots = 3", "sheet.toml:2:8: dots must be a list, but 3 is a number"),
            ("title = \"\"\ndots = [{ at = [1] }]", "sheet.toml:2:16: dots.at must be a list of 2, but it has 1"),
            ("title = \"\"\n[[dots]]\nat = [1, true]", "sheet.toml:3:10: dots.at must be a number, but it is true"),
            ("title = \"\"\nfold = \"leter\"", "sheet.toml:2:8: fold cannot be \"leter\"; did you mean \"letter\"?"),
            ("title = \"\"\nfold = \"thrice\"", "sheet.toml:2:8: fold cannot be \"thrice\"; available: half, letter"),
            ("title = \"\"\nfold = 2", "sheet.toml:2:8: fold must be one of half, letter, but 2 is a number"),
            // serde loses the positions in a table that is one of several kinds; they are searched for again.
            (
                "title = \"\"\n[ink]\nkind = \"mixed\"\npart = 3",
                "sheet.toml:4:1: unknown key \"ink.part\"; did you mean \"parts\"?",
            ),
            (
                "title = \"\"\n[ink]\nkind = \"mixed\"\nparts = \"all\"",
                "sheet.toml:4:9: ink.parts must be a number, but \"all\" is text",
            ),
            (
                "title = \"\"\n[ink]\nkind = \"mixed\"\nparts = 1\ntints = [\"red\", \"loud\"]",
                "sheet.toml:5:17: ink.tints: \"loud\" is not a tint",
            ),
            ("title = \"a\"\ntitle = \"b\"", "sheet.toml:2:1: duplicate key"),
            ("title = \"a\"\n[frame\n", "sheet.toml:2:"),
        ] {
            let error = mistake(text);
            assert!(error.starts_with(expected), "{error}\n{expected}");
            assert!(!error.contains('\n') && error.chars().count() < 200, "{error}");
        }
    }

    #[test]
    fn foreign_texts_are_harmless() {
        for text in [
            format!("title = [\"{}\"]", "x".repeat(9999)),
            format!("title = \"\"\nfold = \"{}\"", "\\u001b".repeat(9999)),
            format!("title = \"\"\n\"\\u001b{}\" = 3", "k".repeat(9999)),
            format!("title = \"\"\n\"{}\".\"{}\" = 3", "a".repeat(9999), "b".repeat(9999)),
            format!("title = {}", "9".repeat(9999)),
            format!("title = {}", "[".repeat(9999)),
        ] {
            let error = mistake(&text);
            assert!(!error.chars().any(char::is_control) && error.chars().count() < 300, "{error}");
        }
    }

    #[test]
    fn invalid_values_are_reported_with_their_key() {
        let text = "[[d]]\ne = 1\n[[d]]\ne = 2\n";
        let error = |wrong: Wrong| wrong.in_text("x.toml", text).to_string();
        assert_eq!(error(Wrong::new("d[1].e", " is 2, not 1")), "x.toml:4:5: d.e is 2, not 1");
        assert_eq!(error(Wrong::new("d[1].e[3].f", ": odd")), "x.toml:4:5: d.e.f: odd");
        assert_eq!(error(Wrong::with_message("d[0].e", "it is odd")), "x.toml:2:5: it is odd");
        assert_eq!(error(Wrong::new("f", " is missing")), "x.toml: f is missing");
    }

    #[test]
    fn values_have_their_places() {
        let text = "a = 1\n[b]\nc = [1, 2]\n[[d]]\ne = 1\n[[d]]\ne = 2\n";
        for (key, at) in [
            ("a", Some([1, 5])),
            ("b.c", Some([3, 5])),
            ("b.c[1]", Some([3, 9])),
            ("d[1].e", Some([7, 5])),
            ("b.f", Some([2, 1])),
            ("f.g", None),
            ("", None),
        ] {
            assert_eq!(Wrong::new(key, "").in_text("x", text).at, at, "{key}");
        }
    }
}
