//! Splits a condition into tokens.

use super::super::model::Value;
use super::{Comparison, WhenError};
use crate::file::message::brief;

/// A token and the column where it begins, counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) kind: Kind,
    pub(super) column: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// The name of an attribute.
    Name(String),
    Literal(Value),
    Comparison(Comparison),
    Open,
    Close,
    Comma,
    And,
    Or,
    Not,
    In,
    Is,
    NoValue,
    End,
}

impl Kind {
    /// Returns how the token is written, for messages.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Name(name) => brief(name),
            Self::Literal(Value::Text(text)) => format!("'{}'", brief(text)),
            Self::Literal(value) => value.key().unwrap_or_default().into_owned(),
            Self::Comparison(Comparison::Equal) => "==".to_owned(),
            Self::Comparison(Comparison::NotEqual) => "!=".to_owned(),
            Self::Comparison(Comparison::Less) => "<".to_owned(),
            Self::Comparison(Comparison::LessOrEqual) => "<=".to_owned(),
            Self::Comparison(Comparison::Greater) => ">".to_owned(),
            Self::Comparison(Comparison::GreaterOrEqual) => ">=".to_owned(),
            Self::Open => "(".to_owned(),
            Self::Close => ")".to_owned(),
            Self::Comma => ",".to_owned(),
            Self::And => "and".to_owned(),
            Self::Or => "or".to_owned(),
            Self::Not => "not".to_owned(),
            Self::In => "in".to_owned(),
            Self::Is => "is".to_owned(),
            Self::NoValue => "none".to_owned(),
            Self::End => "the end".to_owned(),
        }
    }
}

/// Signs with their tokens; longer ones first.
const SIGNS: [(&str, Kind); 9] = [
    ("==", Kind::Comparison(Comparison::Equal)),
    ("!=", Kind::Comparison(Comparison::NotEqual)),
    ("<=", Kind::Comparison(Comparison::LessOrEqual)),
    (">=", Kind::Comparison(Comparison::GreaterOrEqual)),
    ("<", Kind::Comparison(Comparison::Less)),
    (">", Kind::Comparison(Comparison::Greater)),
    ("(", Kind::Open),
    (")", Kind::Close),
    (",", Kind::Comma),
];

/// Signs of other languages, with what to use instead.
const FOREIGN: [(&str, &str); 10] = [
    ("&&", "&& is not known; use and"),
    ("||", "|| is not known; use or"),
    ("<>", "<> is not a comparison; use !="),
    ("=<", "=< is not a comparison; use <="),
    ("=>", "=> is not a comparison; use >="),
    ("!", "! is not known; use not, or != to compare"),
    ("=", "= is not a comparison; use =="),
    ("‘", "‘ is not a quotation mark for text; use '"),
    ("“", "“ is not a quotation mark for names; use \""),
    ("`", "` is not a quotation mark; use ' for text and \" for names"),
];

/// Splits a text; the last token is [`Kind::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, WhenError> {
    let mut tokens = Vec::new();
    let mut rest = text;
    let mut column = 1;
    loop {
        let begin = rest.trim_start();
        column += count(rest) - count(begin);
        rest = begin;
        let Some(first) = rest.chars().next() else { break };
        let (kind, after) = token(rest, first).map_err(|cause| WhenError { column, cause })?;
        tokens.push(Token { kind, column });
        column += count(rest) - count(after);
        rest = after;
    }
    tokens.push(Token { kind: Kind::End, column });
    Ok(tokens)
}

fn count(text: &str) -> usize {
    text.chars().count()
}

/// Returns the token at the beginning of a text, and the text after it.
fn token(text: &str, first: char) -> Result<(Kind, &str), String> {
    match first {
        '\'' => {
            let (content, after) = between(text, '\'').ok_or("the text has no closing '")?;
            return Ok((Kind::Literal(Value::Text(content)), after));
        }
        '"' => {
            let (name, after) = between(text, '"').ok_or("the name has no closing \"")?;
            return Ok((Kind::Name(name), after));
        }
        _ => {}
    }
    let is_foreign =
        |sign: &str| text.starts_with(sign) && !(sign.len() == 1 && SIGNS.iter().any(|it| text.starts_with(it.0)));
    if let Some((_, cause)) = FOREIGN.iter().find(|(sign, _)| is_foreign(sign)) {
        return Err((*cause).to_owned());
    }
    if let Some((kind, after)) = SIGNS.iter().find_map(|(sign, kind)| Some((kind, text.strip_prefix(sign)?))) {
        return Ok((kind.clone(), after));
    }
    let is_number = first.is_ascii_digit() || matches!(first, '-' | '+' | '.');
    let is_part =
        |c: char| c.is_alphanumeric() || matches!(c, '_' | ':' | '.' | '@') || (is_number && matches!(c, '-' | '+'));
    let end = text.find(|c| !is_part(c)).unwrap_or(text.len());
    match text.split_at_checked(end) {
        Some((word, after)) if !word.is_empty() => match is_number {
            true => Ok((Kind::Literal(Value::Number(number(word)?)), after)),
            false => Ok((word_kind(word), after)),
        },
        _ => Err(format!("{} has no meaning here", brief(&first.to_string()))),
    }
}

fn number(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("{} is not a number", brief(word)))
}

fn word_kind(word: &str) -> Kind {
    match word.to_ascii_lowercase().as_str() {
        "and" => Kind::And,
        "or" => Kind::Or,
        "not" => Kind::Not,
        "in" => Kind::In,
        "is" => Kind::Is,
        "none" => Kind::NoValue,
        "true" => Kind::Literal(Value::Bool(true)),
        "false" => Kind::Literal(Value::Bool(false)),
        _ => Kind::Name(word.to_owned()),
    }
}

/// Returns the content between quotation marks, and the text after them. Two marks within stand for one.
fn between(text: &str, mark: char) -> Option<(String, &str)> {
    let mut rest = text.strip_prefix(mark)?;
    let mut content = String::new();
    loop {
        let (before, after) = rest.split_once(mark)?;
        content.push_str(before);
        match after.strip_prefix(mark) {
            Some(after) => {
                content.push(mark);
                rest = after;
            }
            None => return Some((content, after)),
        }
    }
}
