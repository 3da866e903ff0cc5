//! Styles that differ from a drawing in one value that switches something on or off. Their pipelines are compiled while
//! no other work needs the compiler, so that an edit that switches a pass need not wait for a compiler.

use toml_edit::Value;

use super::document::StyleDocument;
use super::rows::Row;
use crate::style::Style;
use crate::style::parameters::{Range, ValueKind, set};

/// The parameters that switch something, with their positions: each choice, each flag, whether a number that may be 0 is
/// 0, and whether an optional value is given. As long as they are the same, a style has neighbours of the same passes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Switches(Vec<(String, String)>);

impl Switches {
    /// Returns the switches of a drawing.
    pub(crate) fn of(document: &StyleDocument) -> Self {
        let rows = document.sections().iter().flat_map(|section| &section.rows);
        Self(rows.filter_map(|row| Some((row.key.clone(), position(row)?))).collect())
    }
}

/// Returns the position of a parameter that switches something; `None` for any other parameter.
fn position(row: &Row) -> Option<String> {
    let Some(value) = present(row) else { return may_be_given(row).then(|| "not given".to_owned()) };
    match &row.definition.kind {
        ValueKind::Number | ValueKind::Whole if may_be_zero(row) => Some((number(&value)? == 0.0).to_string()),
        ValueKind::Flag => value.as_bool().map(|flag| flag.to_string()),
        ValueKind::Choice(_) => value.as_str().map(str::to_owned),
        _ => None,
    }
}

fn present(row: &Row) -> Option<Value> {
    row.value.clone().or_else(|| row.definition.default.as_ref()?.as_value().cloned())
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn may_be_zero(row: &Row) -> bool {
    let [low, high] = row.definition.range.ends();
    !matches!(row.definition.range, Range::Above(_))
        && low.is_some_and(|low| low <= 0.0)
        && high.is_none_or(|high| high >= 0.0)
}

/// Returns whether a parameter without a value switches something when it has one.
fn may_be_given(row: &Row) -> bool {
    matches!(row.definition.kind, ValueKind::Number | ValueKind::Whole | ValueKind::Color)
}

/// Returns the values of a parameter that would switch something.
fn other_positions(row: &Row) -> Vec<Value> {
    let number_of = |value: f32| match row.definition.kind {
        ValueKind::Whole => Value::from(value as i64),
        _ => Value::from(f64::from(value)),
    };
    let [_, high] = row.definition.range.ends();
    let on = row.definition.soft_end.or(high).unwrap_or(1.0);
    match (&row.definition.kind, present(row)) {
        (ValueKind::Number | ValueKind::Whole, None) => vec![number_of(on)],
        (ValueKind::Color, None) => vec![Value::from("#808080")],
        (ValueKind::Number | ValueKind::Whole, Some(value)) if may_be_zero(row) => {
            vec![number_of(if number(&value) == Some(0.0) { on } else { 0.0 })]
        }
        (ValueKind::Flag, Some(value)) => value.as_bool().map(|flag| Value::from(!flag)).into_iter().collect(),
        (ValueKind::Choice(choices), Some(value)) => {
            let others = choices.iter().filter(|choice| value.as_str() != Some(&choice.name));
            others.map(|choice| Value::from(choice.name.as_str())).collect()
        }
        _ => Vec::new(),
    }
}

impl StyleDocument {
    /// Returns the parameters whose values can be switched, each with one other value.
    pub(crate) fn switchable(&self) -> Vec<(String, Value)> {
        let rows = self.sections().iter().flat_map(|section| &section.rows);
        rows.flat_map(|row| other_positions(row).into_iter().map(|value| (row.key.clone(), value))).collect()
    }

    /// Returns the style with another value of a parameter; `None` if the value is not allowed there. The drawing stays
    /// as it is.
    pub(crate) fn neighbour(&self, key: &str, value: Value) -> Option<Style> {
        let text = set::<Style>(self.name(), self.text(), key, value).ok()?;
        self.parsed_edit(&text).ok()
    }
}
