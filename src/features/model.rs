//! Features, their geometries and their attributes.

use std::borrow::Cow;
use std::sync::Arc;

/// x, y and z; z is NaN if there is none. x and y are finite.
pub(crate) type Position = [f64; 3];

/// Largest integer up to which every integer is an f64.
const LARGEST_EXACT: u64 = 1 << 53;

/// A geometry with attributes.
#[derive(Clone, Debug)]
pub(crate) struct Feature {
    /// Parts of one kind. A collection of several kinds in the file is passed as several features.
    pub geometry: Geometry,
    pub attributes: Attributes,
    /// Index into [`Summary::layers`](super::Summary::layers).
    pub layer: usize,
    #[cfg_attr(
        not(test),
        expect(dead_code, reason = "what is left out is counted, and its first record named, in the summary")
    )]
    /// Number in the file, for messages: see [`Summary::record_noun`](super::Summary::record_noun).
    pub record: u64,
}

/// One or more parts of one kind.
#[derive(Clone, Debug)]
pub(crate) enum Geometry {
    Points(Vec<Position>),
    /// Lines of at least two positions each.
    Lines(Vec<Vec<Position>>),
    Areas(Vec<Area>),
}

/// A polygon. Its rings have at least three positions each, and the last does not repeat the first. The direction of
/// the rings is that of the file.
#[derive(Clone, Debug)]
pub(crate) struct Area {
    pub outer: Vec<Position>,
    pub holes: Vec<Vec<Position>>,
}

impl Geometry {
    /// Returns all positions.
    pub(crate) fn positions(&self) -> impl Iterator<Item = &Position> {
        let (points, lines, areas): (&[Position], &[Vec<Position>], &[Area]) = match self {
            Self::Points(points) => (points, &[], &[]),
            Self::Lines(lines) => (&[], lines, &[]),
            Self::Areas(areas) => (&[], &[], areas),
        };
        let rings = areas.iter().flat_map(|area| std::iter::once(&area.outer).chain(&area.holes)).flatten();
        points.iter().chain(lines.iter().flatten()).chain(rings)
    }
}

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Text(String),
    /// A finite number.
    Number(f64),
    Bool(bool),
    None,
}

impl Value {
    /// Returns an integer as a number, or as text if an f64 cannot represent it, as with hashes of 64 bits.
    pub(super) fn integer(integer: impl Into<i128>) -> Self {
        let integer = integer.into();
        if integer.unsigned_abs() <= u128::from(LARGEST_EXACT) {
            Self::Number(integer as f64)
        } else {
            Self::Text(integer.to_string())
        }
    }

    /// Returns a number; `None` for NaN and infinities.
    pub(super) fn number(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::None }
    }

    /// Creates a text value; empty text becomes [`Value::None`].
    pub(super) fn text(text: &str) -> Self {
        if text.is_empty() { Self::None } else { Self::Text(text.to_owned()) }
    }

    /// Returns the value of a field of a text format, which does not say whether it is a number. Digits after a leading
    /// zero, such as those of a postcode, are text.
    pub(super) fn guessed(field: &str, has_decimal_commas: bool) -> Self {
        let field = field.trim();
        match field {
            "true" | "True" | "TRUE" => return Self::Bool(true),
            "false" | "False" | "FALSE" => return Self::Bool(false),
            _ => {}
        }
        match plain_number(field, has_decimal_commas) {
            Some(number) if number.abs() < LARGEST_EXACT as f64 || field.contains(['.', ',', 'e', 'E']) => {
                Self::Number(number)
            }
            _ => Self::text(field),
        }
    }

    /// Returns the value as a key of a table: `2` for the number 2.0, `true` for a Boolean. There is none without a
    /// value.
    pub(crate) fn key(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Text(text) => Some(Cow::Borrowed(text)),
            Self::Number(number) => Some(Cow::Owned(number.to_string())),
            Self::Bool(value) => Some(Cow::Borrowed(if *value { "true" } else { "false" })),
            Self::None => None,
        }
    }
}

/// Returns the number that a text consists of, unless it has a leading zero or no digit at its beginning.
fn plain_number(text: &str, has_decimal_commas: bool) -> Option<f64> {
    let unsigned = text.strip_prefix(['-', '+']).unwrap_or(text);
    let mut bytes = unsigned.bytes();
    let (first, second) = (bytes.next()?, bytes.next());
    let has_leading_zero = first == b'0' && second.is_some_and(|byte| byte.is_ascii_digit());
    if has_leading_zero || !(first.is_ascii_digit() || first == b'.') {
        return None;
    }
    coordinate(text, has_decimal_commas)
}

/// Returns the finite number that a text consists of.
pub(super) fn coordinate(text: &str, has_decimal_commas: bool) -> Option<f64> {
    let text = text.trim();
    let number: f64 = match text.split_once(',') {
        // A point in addition to the comma would separate thousands.
        Some((_, fraction)) if has_decimal_commas && !text.contains('.') && !fraction.contains(',') => {
            text.replace(',', ".").parse().ok()?
        }
        _ => text.parse().ok()?,
    };
    number.is_finite().then_some(number)
}

/// Names and values in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Attributes(Vec<(Arc<str>, Value)>);

impl Attributes {
    /// Returns the value of an attribute; [`Value::None`] if the feature lacks the attribute.
    pub(crate) fn get(&self, name: &str) -> &Value {
        self.0.iter().find(|(own, _)| &**own == name).map_or(&Value::None, |(_, value)| value)
    }

    /// Returns all names and values.
    #[cfg(test)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&Arc<str>, &Value)> {
        self.0.iter().map(|(name, value)| (name, value))
    }

    /// Returns the memory that the values take, about, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let text = |value: &Value| if let Value::Text(text) = value { text.capacity() } else { 0 };
        self.0.iter().map(|(_, value)| size_of::<(Arc<str>, Value)>() + text(value)).sum()
    }

    /// Adds an attribute.
    pub(crate) fn push(&mut self, name: Arc<str>, value: Value) {
        self.0.push((name, value));
    }

    /// Removes an attribute.
    #[cfg(test)]
    pub(super) fn remove(&mut self, name: &str) {
        self.0.retain(|(own, _)| &**own != name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_numbers_only_if_nothing_is_lost() {
        for (field, expected) in [
            ("12", Value::Number(12.0)),
            (" -0.5 ", Value::Number(-0.5)),
            ("1e3", Value::Number(1000.0)),
            ("0", Value::Number(0.0)),
            ("01234", Value::Text("01234".into())),
            ("9007199254740993", Value::Text("9007199254740993".into())),
            ("nan", Value::Text("nan".into())),
            ("infinity", Value::Text("infinity".into())),
            ("1e999", Value::Text("1e999".into())),
            ("1,5", Value::Text("1,5".into())),
            ("TRUE", Value::Bool(true)),
            ("", Value::None),
        ] {
            assert_eq!(Value::guessed(field, false), expected, "{field}");
        }
        assert_eq!(Value::guessed("1,5", true), Value::Number(1.5));
        assert_eq!(coordinate("1.234,5", true), None);
        assert_eq!(coordinate("47.5", true), Some(47.5));
        assert_eq!(Value::integer(u64::MAX), Value::Text("18446744073709551615".into()));
        assert_eq!(Value::Number(2.0).key().as_deref(), Some("2"));
    }
}
