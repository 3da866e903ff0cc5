//! Definitions of parameters as data.

use toml_edit::{ArrayOfTables, Item};

use super::{Range, Setting, find};
use crate::style::layers::keys_of_layers;

/// The definition of a parameter, or of a section of parameters.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    /// Key within its section.
    pub key: &'static str,
    /// Name in the inspector, if the key in words does not say what the parameter is.
    pub label: Option<&'static str>,
    /// One sentence of help.
    pub help: &'static str,
    /// Unit of a number, if it has one.
    pub unit: Option<&'static str>,
    /// Allowed values of a number, pair or list.
    pub range: Range,
    /// Upper end of a slider, if useful values are below the largest allowed one.
    pub soft_end: Option<f32>,
    /// Word that is shown for the value 0, if 0 means "none" or "automatic".
    pub zero_word: Option<&'static str>,
    /// Kind of value.
    pub kind: ValueKind,
    /// Whether the key is required where its section is present.
    pub is_required: bool,
    /// Value if the key is not given; `None` if there is no default.
    pub default: Option<Item>,
}

/// The kind of value that a parameter has.
#[derive(Clone, Debug)]
pub(crate) enum ValueKind {
    /// A 32-bit floating-point number.
    Number,
    /// A whole number, 0 or greater.
    Whole,
    /// `true` or `false`.
    Flag,
    Text,
    /// An sRGB colour, `#rrggbb`.
    Color,
    /// A pair of numbers.
    Pair,
    /// One of several names.
    Choice(Vec<Choice>),
    /// A list of values of one kind.
    List(Box<ValueKind>),
    /// A section with parameters of its own.
    Section(Vec<Definition>),
    /// An ordered list of layers, each of one of these kinds.
    Layers(Vec<Definition>),
}

/// One of the names that a parameter accepts.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    /// The name, as written in a style file.
    pub name: String,
    /// One sentence of help.
    pub help: &'static str,
}

/// A parameter with its full key.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    /// Key with its sections, for example `hatching.sets[0].from`.
    pub key: String,
    /// The definition of the parameter.
    pub definition: Definition,
}

/// The ends of a slider for a number. Values outside of them may still be typed, if the range of the parameter allows
/// them.
#[cfg(any(feature = "window", feature = "headset"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SliderEnds {
    pub low: f32,
    pub high: f32,
    /// Whether equal distances on the slider are equal ratios.
    pub is_logarithmic: bool,
}

/// Widest range for which a slider is useful.
#[cfg(any(feature = "window", feature = "headset"))]
const WIDEST_SLIDER: f32 = 1e6;

impl Definition {
    pub(crate) fn of<T: Setting>(
        key: &'static str,
        help: &'static str,
        unit: &[&'static str],
        range: Range,
        absent: Option<T>,
    ) -> Self {
        let unit = self::unit(unit, key);
        let is_required = absent.is_none();
        let default = absent.and_then(|value| value.item());
        Self {
            key,
            label: None,
            help: help.trim_ascii(),
            unit,
            range,
            soft_end: None,
            zero_word: None,
            kind: T::kind(),
            is_required,
            default,
        }
    }

    /// Returns the definition with a name for the inspector, if there is one.
    pub(crate) fn with_label(self, label: &[&'static str]) -> Self {
        Self { label: label.first().copied(), ..self }
    }

    /// Returns the definition with a word for the value 0, if there is one.
    pub(crate) fn with_zero_word(self, zero_word: &[&'static str]) -> Self {
        Self { zero_word: zero_word.first().copied(), ..self }
    }

    /// Returns the name of the parameter or section for people: its label, or the key in words without the unit.
    #[cfg(any(feature = "window", feature = "headset"))]
    pub(crate) fn label(&self) -> String {
        let without_unit = || ["_px", "_deg", "_m", "_s"].into_iter().find_map(|unit| self.key.strip_suffix(unit));
        let words = || without_unit().unwrap_or(self.key).replace('_', " ");
        capitalised(&self.label.map_or_else(words, str::to_owned))
    }

    /// Returns the definition with the upper end of a slider, if there is one.
    pub(crate) fn with_soft_end(self, soft_end: &[f32]) -> Self {
        Self { soft_end: soft_end.first().copied(), ..self }
    }

    /// Returns the ends of a slider for a number; `None` if the range is too wide for a slider.
    #[cfg(any(feature = "window", feature = "headset"))]
    pub(crate) fn slider(&self) -> Option<SliderEnds> {
        let [low, high] = self.range.ends();
        let low = low?;
        let high = self.soft_end.or(high)?;
        if !matches!(self.kind, ValueKind::Number | ValueKind::Whole) || high - low > WIDEST_SLIDER {
            return None;
        }
        // A range over several orders of magnitude is one in which the difference between 1 and 2 is as large as that
        // between 100 and 200.
        let is_logarithmic = low >= 0.0 && (high > 99.0 || (low > 0.0 && high >= 100.0 * low));
        Some(SliderEnds { low, high, is_logarithmic })
    }

    /// Returns the allowed values in words, for a table.
    pub(crate) fn allowed(&self) -> String {
        match (&self.kind, self.range) {
            (ValueKind::List(kind), Range::Any) => format!("list of {}", kind.plural()),
            (ValueKind::List(kind), range) => range.to_string().replace("entries", kind.plural()),
            (ValueKind::Choice(choices), Range::Any) => {
                choices.iter().map(|choice| choice.name.as_str()).collect::<Vec<_>>().join(", ")
            }
            (ValueKind::Flag, Range::Any) => "true, false".to_owned(),
            (ValueKind::Color, Range::Any) => "#rrggbb".to_owned(),
            (ValueKind::Whole, Range::Any) => "0 or more".to_owned(),
            (kind, Range::Any) => kind.name().to_owned(),
            (_, range) => range.to_string(),
        }
    }

    /// Returns the definitions inside a section or a list of sections; `None` for a value.
    pub(crate) fn section(&self) -> Option<&[Self]> {
        match &self.kind {
            ValueKind::Section(definitions) | ValueKind::Layers(definitions) => Some(definitions),
            ValueKind::List(kind) => match &**kind {
                ValueKind::Section(definitions) => Some(definitions),
                _ => None,
            },
            _ => None,
        }
    }
}

/// Returns words that begin with a capital letter.
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Returns a label as it is written within a sentence; an abbreviation keeps its capital letters.
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) fn uncapitalised(label: &str) -> String {
    let mut letters = label.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if second.is_lowercase() => first.to_lowercase().chain(letters).collect(),
        _ => label.to_owned(),
    }
}

impl ValueKind {
    /// Returns the kind in one to three words, for messages and tables.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Whole => "whole number",
            Self::Flag => "true or false",
            Self::Text => "text",
            Self::Color => "colour",
            Self::Pair => "two numbers",
            Self::Choice(_) => "name",
            Self::List(_) => "list",
            Self::Section(_) => "section",
            Self::Layers(_) => "layers",
        }
    }

    fn plural(&self) -> &'static str {
        match self {
            Self::Color => "colours",
            Self::Text => "texts",
            Self::Section(_) | Self::Layers(_) => "sections",
            _ => "values",
        }
    }
}

/// Returns the unit of a parameter: the one given, if there is one, or the one that the key ends with.
pub(crate) fn unit(given: &[&'static str], key: &str) -> Option<&'static str> {
    given.first().copied().or_else(|| unit_of(key))
}

/// Returns the unit that the suffix of a key stands for.
fn unit_of(key: &str) -> Option<&'static str> {
    match key.rsplit_once('_')?.1 {
        "px" => Some("px"),
        "deg" => Some("°"),
        "s" => Some("s"),
        _ => None,
    }
}

/// Returns all parameters below a section, in the order of a TOML text: its own values first, then each section
/// followed by the section's parameters. `item` is the whole document: a list of sections is repeated for each of its
/// entries there. A list without entries appears once, with the key `[]`.
pub(crate) fn parameters_of(kind: &ValueKind, item: Option<&Item>) -> Vec<Parameter> {
    let mut all = Vec::new();
    if let ValueKind::Section(definitions) = kind {
        collect(definitions, "", item, &mut all);
    }
    all
}

fn collect(definitions: &[Definition], section: &str, item: Option<&Item>, all: &mut Vec<Parameter>) {
    let key_of = |definition: &Definition| match section {
        "" => definition.key.to_owned(),
        _ => format!("{section}.{}", definition.key),
    };
    for definition in definitions.iter().filter(|definition| definition.section().is_none()) {
        all.push(Parameter { key: key_of(definition), definition: definition.clone() });
    }
    for definition in definitions {
        let Some(within) = definition.section() else { continue };
        if let ValueKind::Layers(kinds) = &definition.kind {
            collect_layers(kinds, item, all);
            continue;
        }
        let key = key_of(definition);
        let places = match &definition.kind {
            ValueKind::List(_) => {
                let list = item.and_then(|item| find(item, &key)).and_then(Item::as_array_of_tables);
                match list.map_or(0, ArrayOfTables::len) {
                    0 => vec![format!("{key}[]")],
                    count => (0..count).map(|number| format!("{key}[{number}]")).collect(),
                }
            }
            _ => vec![key],
        };
        for place in places {
            all.push(Parameter { key: place.clone(), definition: definition.clone() });
            collect(within, &place, item, all);
        }
    }
}

/// Adds the parameters of layers: those that the document has, from the bottom to the top, and then the kinds that it
/// lacks.
fn collect_layers(kinds: &[Definition], item: Option<&Item>, all: &mut Vec<Parameter>) {
    let held = item.map(keys_of_layers).unwrap_or_default();
    let of_key = |key: &String| {
        let name = key.split('[').next().unwrap_or_default();
        Some((key.clone(), kinds.iter().find(|kind| kind.key == name)?))
    };
    let lacking = kinds.iter().filter(|kind| !held.iter().any(|key| key == kind.key));
    let lacking = lacking.map(|kind| (kind.key.to_owned(), kind));
    for (key, kind) in held.iter().filter_map(of_key).chain(lacking) {
        all.push(Parameter { key: key.clone(), definition: kind.clone() });
        collect(kind.section().unwrap_or_default(), &key, item, all);
    }
}
