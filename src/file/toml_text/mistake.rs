//! Describes what is wrong with a value: serde's errors in words for users, without Rust type names.

use std::fmt::Display;
use std::ops::Range;

use serde::de::{Error, Expected, Unexpected};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::super::message::{brief, did_you_mean, named, quoted, shown};

/// Largest total number of characters of a list of known names in a message.
const LISTED: usize = 120;

/// A mistake and its position.
#[derive(Clone, Debug)]
pub(super) struct Mistake {
    pub kind: Kind,
    /// Byte range of the value or key.
    pub at: Option<Range<usize>>,
    /// The keys that lead to the value, from the outermost on. The index of a list entry is a step of its own, `[2]`.
    pub path: Vec<String>,
}

#[derive(Clone, Debug)]
pub(super) enum Kind {
    UnknownKey {
        key: String,
        known: &'static [&'static str],
    },
    UnknownName {
        name: String,
        known: &'static [&'static str],
    },
    MissingKey(&'static str),
    /// The expected kind ("a number"), and what was found ("\"thin\" is text").
    Wanted {
        wanted: String,
        found: String,
    },
    /// A message of hachure, or of a type that is parsed from a text.
    Other(String),
}

impl From<Kind> for Mistake {
    fn from(kind: Kind) -> Self {
        Self { kind, at: None, path: Vec::new() }
    }
}

impl Mistake {
    /// Builds the mistake of a value that is not of the expected kind.
    pub(super) fn wanted(wanted: impl Into<String>, found: impl Into<String>) -> Self {
        Kind::Wanted { wanted: wanted.into(), found: found.into() }.into()
    }

    /// Adds `key` to the path of a mistake in its value.
    pub(super) fn within(mut self, key: &str, value: &DeValue<'_>, at: Range<usize>) -> Self {
        self.path.insert(0, key.to_owned());
        if self.at.is_none() {
            // The mistake was made in serde's copy of the value, which has no positions.
            let found = match value {
                DeValue::Table(table) => self.search(table),
                _ => None,
            };
            let (keys, place) = found.unwrap_or((Vec::new(), at));
            self.path.extend(keys);
            self.at = Some(place);
        }
        self
    }

    /// Returns the keys below `table` that lead to the mistake, and the position of the mistake.
    fn search(&self, table: &DeTable<'_>) -> Option<(Vec<String>, Range<usize>)> {
        if let Kind::UnknownKey { key, .. } = &self.kind
            && let Some((key, _)) = table.get_key_value(key.as_str())
        {
            return Some((Vec::new(), key.span()));
        }
        for (key, value) in table {
            if let Some((mut keys, place)) = self.search_value(value) {
                keys.insert(0, key.get_ref().to_string());
                return Some((keys, place));
            }
        }
        None
    }

    /// Does the same as [`Mistake::search`] in a value.
    fn search_value(&self, value: &Spanned<DeValue<'_>>) -> Option<(Vec<String>, Range<usize>)> {
        let is_it = match &self.kind {
            Kind::Wanted { found, .. } => *found == described(value.get_ref()),
            Kind::UnknownName { name, .. } => value.get_ref().as_str() == Some(name),
            // A message about the meaning of a text begins with that text.
            Kind::Other(words) => value.get_ref().as_str().is_some_and(|text| words.starts_with(&quoted(text))),
            _ => false,
        };
        match value.get_ref() {
            _ if is_it => Some((Vec::new(), value.span())),
            DeValue::Table(table) => self.search(table),
            DeValue::Array(list) => list.iter().find_map(|entry| self.search_value(entry)),
            _ => None,
        }
    }

    /// Returns whether the message says that a key is unknown, but not which ones are known.
    pub(super) fn is_unknown_without_hint(&self) -> bool {
        matches!(&self.kind, Kind::UnknownKey { key, known } if meant(key, known).is_empty())
    }

    /// Returns the message.
    pub(super) fn cause(&self) -> String {
        let section =
            self.path.iter().filter(|step| !step.starts_with('[')).map(String::as_str).collect::<Vec<_>>().join(".");
        let key = |key: &str| if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") };
        let it = if section.is_empty() { "it".to_owned() } else { named(&section) };
        match &self.kind {
            Kind::UnknownKey { key: unknown, known } => {
                format!("unknown key \"{}\"{}", brief(&key(unknown)), meant(unknown, known))
            }
            Kind::UnknownName { name, known } => {
                format!("{it} cannot be \"{}\"{}", brief(name), meant(name, known))
            }
            Kind::MissingKey(missing) => format!("the key {} is missing", quoted(&key(missing))),
            Kind::Wanted { wanted, found } => format!("{it} must be {wanted}, but {found}"),
            Kind::Other(words) if section.is_empty() => words.clone(),
            Kind::Other(words) => format!("{it}: {words}"),
        }
    }
}

/// Longest name, in bytes, with which the known names are listed.
const LONGEST_NAME: usize = 40;

/// Suggests the nearest name, or lists the known names if they are few.
fn meant(name: &str, known: &[&'static str]) -> String {
    let meant = did_you_mean(name, known.iter().copied());
    let all = known.join(", ");
    // Nobody means a known name by a very long one, and the message would be longer than a line.
    match meant.is_empty() && !known.is_empty() && all.len() <= LISTED && name.len() <= LONGEST_NAME {
        true => format!("; available: {all}"),
        false => meant,
    }
}

/// Describes a value as a subject with a verb: `"thin" is text`.
pub(crate) fn described(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{} is text", quoted(text)),
        DeValue::Integer(number) => format!("{} is a number", shown(&number.to_string())),
        DeValue::Float(number) => format!("{} is a number", shown(number.as_str())),
        DeValue::Boolean(value) => format!("it is {value}"),
        DeValue::Datetime(_) => "it is a date".to_owned(),
        DeValue::Array(_) => "it is a list".to_owned(),
        DeValue::Table(_) => "it is a table".to_owned(),
    }
}

/// Returns the kind that serde expected, by the name of its Rust type.
fn wanted(expected: &dyn Expected) -> String {
    let words = expected.to_string();
    let first = words.split_whitespace().next().unwrap_or_default();
    match words.as_str() {
        "f32" | "f64" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more".to_owned(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "a boolean" | "bool" => "true or false".to_owned(),
        "a string" | "string" | "str" | "a borrowed string" | "path string" => "text".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        _ if first == "struct" => "a table".to_owned(),
        _ if words.starts_with("an array of length ") => words.replace("an array of length", "a list of"),
        _ if words.starts_with("a tuple of size ") => words.replace("a tuple of size", "a list of"),
        _ => "of another kind".to_owned(),
    }
}

fn found(unexpected: &Unexpected<'_>) -> String {
    match unexpected {
        Unexpected::Bool(value) => format!("it is {value}"),
        Unexpected::Unsigned(number) => format!("{number} is a number"),
        Unexpected::Signed(number) => format!("{number} is a number"),
        // The display form of a large number may have 300 digits, because it has no exponent.
        Unexpected::Float(number) => format!("{} is a number", shown(&number.to_string())),
        Unexpected::Str(text) => format!("{} is text", quoted(text)),
        Unexpected::Seq => "it is a list".to_owned(),
        Unexpected::Map | Unexpected::StructVariant => "it is a table".to_owned(),
        _ => "it is not".to_owned(),
    }
}

impl std::error::Error for Mistake {}

impl Display for Mistake {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.cause())
    }
}

impl Error for Mistake {
    fn custom<T: Display>(words: T) -> Self {
        Kind::Other(super::printable(&words.to_string(), 160)).into()
    }

    fn invalid_type(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::wanted(wanted(expected), found(&unexpected))
    }

    fn invalid_value(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::wanted(wanted(expected), found(&unexpected))
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::wanted(wanted(expected), format!("it has {length}"))
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Kind::UnknownName { name: name.to_owned(), known }.into()
    }

    fn unknown_field(key: &str, known: &'static [&'static str]) -> Self {
        Kind::UnknownKey { key: key.to_owned(), known }.into()
    }

    fn missing_field(key: &'static str) -> Self {
        Kind::MissingKey(key).into()
    }

    fn duplicate_field(key: &'static str) -> Self {
        Kind::Other(format!("the key {} is used twice", quoted(key))).into()
    }
}
