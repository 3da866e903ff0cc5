//! Values that are set over a style by their keys, as the option `--set` does.

use std::fmt;
use std::str::FromStr;

use toml_edit::{Array, Item, Value};

use super::parameters::{self, Setting, ValueKind, parameters_of};
use super::{Style, StyleError, extends};

/// A parameter of a style and the value that it is given, such as `strokes.width_px=2`.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct SetValue {
    /// The full key of the parameter.
    pub key: String,
    /// The value: TOML, or the bare text of a name, a colour or a text.
    pub text: String,
}

/// The key of the values that differ on maps.
pub(crate) const ON_MAPS: &str = "on_maps";

impl FromStr for SetValue {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text
            .split_once('=')
            .filter(|(key, _)| !key.trim().is_empty())
            .ok_or("it must be KEY=VALUE, such as strokes.width_px=2")?;
        // The first layer of a kind has no number.
        let key = key.trim();
        let key = match key.split_once('.') {
            Some((layer, within)) => format!("{}.{within}", layer.strip_suffix("[0]").unwrap_or(layer)),
            None => key.to_owned(),
        };
        Ok(Self { key, text: value.trim().to_owned() })
    }
}

impl TryFrom<String> for SetValue {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for SetValue {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}={}", self.key, self.text)
    }
}

/// Returns the value that a text means for a parameter of this kind; `None` is an unknown parameter.
pub(crate) fn value_of(kind: Option<&ValueKind>, text: &str) -> Value {
    let takes_text = matches!(kind, Some(ValueKind::Text | ValueKind::Color | ValueKind::Choice(_)));
    match text.trim().parse::<Value>() {
        Ok(value) if !takes_text || value.is_str() => value,
        _ => text.trim().into(),
    }
}

/// Returns the text of a style file with other values at some keys. `style` is the style that the text describes. A value
/// that is set counts on maps too, unless the list of values that differ on maps is also set.
///
/// # Errors
/// A key that no parameter has, or the index of a list entry that does not exist. Values are only checked when the text
/// is read.
pub(crate) fn with_values(name: &str, text: &str, style: &Style, values: &[SetValue]) -> Result<String, StyleError> {
    let item: Option<Item> = style.item();
    let parameters = parameters_of(&Style::kind(), item.as_ref());
    let kind_of = |key: &str| parameters.iter().find(|known| known.key == key).map(|known| &known.definition.kind);
    let mut pairs: Vec<(String, Value)> =
        values.iter().map(|set| (set.key.clone(), value_of(kind_of(&set.key), &set.text))).collect();
    let is_set = |key: &str| values.iter().any(|set| set.key == key);
    if style.on_maps.iter().any(|on_maps| is_set(&on_maps.key)) && !is_set(ON_MAPS) {
        let kept = style.on_maps.iter().filter(|on_maps| !is_set(&on_maps.key));
        pairs.push((ON_MAPS.to_owned(), kept.map(SetValue::to_string).collect::<Array>().into()));
    }
    Ok(parameters::set_all::<Style>(name, &extends::whole(name, text)?, pairs)?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::style::preset_text;

    #[test]
    fn a_pair_has_a_key_and_a_value() {
        let pair: SetValue = " strokes.width_px = 2 ".parse().unwrap();
        assert_eq!(pair, SetValue { key: "strokes.width_px".to_owned(), text: "2".to_owned() });
        assert_eq!("paper.color=a=b".parse::<SetValue>().unwrap().text, "a=b");
        for wrong in ["strokes", "=2", "", " = 2"] {
            let error = wrong.parse::<SetValue>().unwrap_err();
            assert!(error.starts_with("it must be KEY=VALUE"), "{error}");
        }
    }

    #[test]
    fn a_value_that_is_set_counts_on_maps() {
        let text = preset_text("crosshatch").unwrap();
        let style = Style::parse("crosshatch", text).unwrap();
        let of_map = |pairs: &[&str]| {
            let values: Vec<SetValue> = pairs.iter().map(|pair| pair.parse().unwrap()).collect();
            let text = with_values("crosshatch", text, &style, &values).unwrap();
            Style::parse("crosshatch", &text).unwrap().for_map(10.0).unwrap().light
        };
        let light = of_map(&["light.shadow=0.5"]);
        assert_eq!((light.shadow, light.crests), (0.5, 0.0), "only this value");
        // Planted: both are set, and maps have their own.
        assert_eq!(of_map(&["light.shadow=0.5", "on_maps=[\"light.shadow=0.25\"]"]).shadow, 0.25);
    }

    #[test]
    fn values_of_every_kind_are_set() {
        let text = preset_text("strokes").unwrap();
        let style = Style::parse("strokes", text).unwrap();
        let set = |pairs: &[&str]| {
            let values: Vec<SetValue> = pairs.iter().map(|pair| pair.parse().unwrap()).collect();
            Style::parse("strokes", &with_values("strokes", text, &style, &values)?)
        };
        let changed = set(&["strokes.width_px=3.5", "description=1", "paper.color=#ffeedd"]).unwrap();
        assert_eq!(changed.description, "1", "a text that looks like a number");
        let strokes = changed.layers.iter().find_map(|layer| match layer {
            crate::style::Layer::Strokes(strokes) => Some(strokes.width_px),
            _ => None,
        });
        assert_eq!(strokes, Some(3.5));
        assert_ne!(changed.paper, style.paper);
        // Planted: a parameter that is not set stays.
        assert_eq!(set(&[]).unwrap(), style);
        let error = set(&["strokes.widht_px=3"]).unwrap_err().to_string();
        assert!(error.contains("widht_px") && error.contains("width_px"), "{error}");
        assert!(set(&["strokes.width_px=wide"]).is_err());
    }
}
