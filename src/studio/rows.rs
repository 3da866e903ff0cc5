//! What an inspector shows of a style: its sections with their parameters and values, from the definitions.

use std::sync::OnceLock;

use toml_edit::{Item, Value};

use crate::style::Style;
use crate::style::layers::most_of_kind;
use crate::style::parameters::{Definition, Parameter, Setting, ValueKind, capitalised, find, parameters_of};
use crate::style::set::SetValue;

/// A section of a style with its parameters.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    /// Key of the section, for example `hatching.sets[0]`; empty for the keys before the first section.
    pub key: String,
    /// Name for people, for example `Hatching, set 1`.
    pub title: String,
    /// One sentence of help.
    pub help: &'static str,
    /// Role of the section in the style.
    pub place: Place,
    /// The parameters that are values. Sections within the section follow it in the list of sections.
    pub rows: Vec<Row>,
}

/// The role of a section in the style.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A section that every style has.
    Always,
    /// An ink layer: its index from the bottom, and whether the style may have another one of its kind.
    Layer { index: usize, may_repeat: bool },
    /// A part of the layer or section before it.
    Within,
    /// An optional section that the style has.
    Optional,
    /// An optional section that the style lacks; it has no rows.
    Absent,
    /// An entry of a list: the key of the list, and the index in it.
    Entry { list: String, index: usize },
}

/// A parameter that is a value, with its value.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// Full key, for example `hatching.sets[0].from`.
    pub key: String,
    /// Name for people, from the definition.
    pub label: String,
    /// Key, help, unit, range and default of the parameter.
    pub definition: Definition,
    /// The current value; `None` if an optional one is not given.
    pub value: Option<Value>,
    /// The reason why the parameter has no effect in this style, if it has none.
    pub without_effect: Option<&'static str>,
}

impl Row {
    /// Returns the key and the value as the option `--set` takes them, if there is a value.
    pub(crate) fn set_value(&self) -> Option<SetValue> {
        Some(SetValue { key: self.key.clone(), text: bare(self.value.as_ref()?) })
    }
}

/// Returns a value as text in one line, without the space and the comments around it.
pub(super) fn bare(value: &Value) -> String {
    let mut value = value.clone();
    if let Some(list) = value.as_array_mut() {
        list.fmt();
    }
    value.decor_mut().clear();
    match value.as_str().filter(|text| !text.is_empty() && text.parse::<Value>().is_err()) {
        Some(text) => text.to_owned(),
        None => value.to_string(),
    }
}

/// Returns the sections of a style, in the order of its text.
pub(crate) fn sections(style: &Style) -> Vec<Section> {
    let Some(item) = style.item() else { return Vec::new() };
    let layer_keys: Vec<String> = (0..style.layers.len()).map(|index| style.layers.key(index)).collect();
    let layer_of = |key: &str| {
        let first = key.split('.').next().unwrap_or_default();
        layer_keys.iter().position(|known| known == first)
    };
    let kinds = layer_kinds();
    let is_lacking_layer = |key: &str| {
        let first = key.split(['.', '[']).next().unwrap_or_default();
        kinds.contains(&first) && layer_of(key).is_none()
    };
    let top = Section {
        key: String::new(),
        title: "Style".to_owned(),
        help: "Name and description of the style.",
        place: Place::Always,
        rows: Vec::new(),
    };
    let mut all = vec![top];
    let mut absent: Vec<String> = Vec::new();
    for Parameter { key, definition } in parameters_of(&Style::kind(), Some(&item)) {
        let is_within_absent = absent.iter().any(|section| key.starts_with(&format!("{section}.")));
        if is_lacking_layer(&key) || is_within_absent || key.contains("[]") {
            continue;
        }
        if definition.section().is_some() {
            let place = place(&key, &definition, &item, layer_of(&key));
            if place == Place::Absent {
                absent.push(key.clone());
            }
            // The kind of tone decides whether there can be a ramp.
            if place == Place::Absent && without_effect(style, &key).is_some() {
                continue;
            }
            all.push(Section { title: title(&key), key, help: definition.help, place, rows: Vec::new() });
            continue;
        }
        if let Some(section) = all.last_mut() {
            let value = find(&item, &key).and_then(Item::as_value).cloned();
            let without_effect = without_effect(style, &key);
            section.rows.push(Row { label: definition.label(), key, definition, value, without_effect });
        }
    }
    all
}

/// Returns the definitions of a style, which are collected once.
fn all_definitions() -> &'static [Definition] {
    static ALL: OnceLock<Vec<Definition>> = OnceLock::new();
    ALL.get_or_init(|| match Style::kind() {
        ValueKind::Section(definitions) => definitions,
        _ => Vec::new(),
    })
}

/// Returns the kinds of layers that a style may have, with their help, from the bottom to the top.
pub(crate) fn layer_definitions() -> &'static [Definition] {
    let kinds = |definition: &'static Definition| match &definition.kind {
        ValueKind::Layers(kinds) => Some(kinds.as_slice()),
        _ => None,
    };
    all_definitions().iter().find_map(kinds).unwrap_or_default()
}

fn layer_kinds() -> Vec<&'static str> {
    layer_definitions().iter().map(|definition| definition.key).collect()
}

fn place(key: &str, definition: &Definition, item: &Item, layer: Option<usize>) -> Place {
    if let Some(index) = layer
        && !key.contains('.')
    {
        return Place::Layer { index, may_repeat: most_of_kind(definition.key) > 1 };
    }
    if let Some((list, number)) = key.strip_suffix(']').and_then(|key| key.rsplit_once('['))
        && let Ok(index) = number.parse()
    {
        return Place::Entry { list: list.to_owned(), index };
    }
    if definition.is_required || definition.default.is_some() {
        return if key.contains('.') { Place::Within } else { Place::Always };
    }
    if find(item, key).is_some() { Place::Optional } else { Place::Absent }
}

/// Returns why a parameter or section has no effect in a style.
fn without_effect(style: &Style, key: &str) -> Option<&'static str> {
    let first = key.split(['.', '[']).next().unwrap_or_default();
    let is_plain = !style.tone.uses_light();
    let uses_curvature = style.lines().is_some_and(|lines| lines.detector == crate::style::Detector::Curvature);
    match first {
        "tone" if is_plain && key != "tone.kind" && key != "tone.local_color" => {
            Some("Only tones of the kind toon have this.")
        }
        "light" | "relief" if is_plain => Some("Only tones of the kind toon use this light."),
        "curvature" if !uses_curvature => Some("Only lines with the detector curvature use this."),
        _ => None,
    }
}

/// Returns the name of a section for people, from the labels of the definitions: `hatching.sets[0]` is "Hatching, set 1".
pub(crate) fn title(key: &str) -> String {
    let mut within: &[Definition] = all_definitions();
    let mut parts = Vec::new();
    for (place, step) in key.split('.').enumerate() {
        let (name, number) = match step.strip_suffix(']').and_then(|step| step.split_once('[')) {
            Some((name, number)) => (name, number.parse::<usize>().ok()),
            None => (step, None),
        };
        let layer = layer_definitions().iter().find(|kind| place == 0 && kind.key == name);
        let definition = layer.or_else(|| within.iter().find(|definition| definition.key == name));
        let words = definition.map_or_else(|| name.replace('_', " "), |definition| definition.label().to_lowercase());
        within = definition.and_then(Definition::section).unwrap_or_default();
        parts.push(match number {
            // The first layer of a kind has no number.
            Some(number) if layer.is_some() => format!("{words} {}", number + 1),
            Some(number) => format!("{} {}", singular(&words), number + 1),
            None => words,
        });
    }
    capitalised(&parts.join(", "))
}

fn singular(words: &str) -> String {
    match words.strip_suffix("ies") {
        Some(stem) => format!("{stem}y"),
        None => words.strip_suffix('s').unwrap_or(words).to_owned(),
    }
}

impl Row {
    /// Returns the unit: that of the definition, or metres if the key says so.
    pub(crate) fn unit(&self) -> Option<&'static str> {
        self.definition.unit.or_else(|| self.definition.key.ends_with("_m").then_some("m"))
    }

    /// Returns the key and the help in words, with unit, range and default.
    pub(crate) fn help(&self) -> String {
        let definition = &self.definition;
        let default = match &definition.default {
            Some(item) => item.to_string().trim().to_owned(),
            None if definition.is_required => "none, it is required".to_owned(),
            None => "not given".to_owned(),
        };
        let unit = self.unit().map_or(String::new(), |unit| format!(", in {unit}"));
        let mut text = format!("{}\n{}{unit}\nDefault: {default}", definition.help, definition.allowed());
        if let ValueKind::Choice(choices) = &definition.kind {
            for choice in choices {
                text += &format!("\n{}: {}", choice.name, choice.help);
            }
        }
        if let Some(why) = self.without_effect {
            text += &format!("\nWithout effect here: {why}");
        }
        text + "\n" + &self.key
    }

    /// Returns the value in words, with its unit.
    pub(crate) fn shown(&self) -> String {
        let unit = self.unit().map_or(String::new(), |unit| format!(" {unit}"));
        match &self.value {
            Some(_) if let Some(word) = self.zero_word() => word.to_owned(),
            Some(Value::String(text)) => text.value().clone(),
            Some(value) => format!("{}{unit}", value.to_string().trim()),
            None => "not given".to_owned(),
        }
    }

    /// Returns the word that is shown instead of the value, if the value is 0 and 0 has one.
    fn zero_word(&self) -> Option<&'static str> {
        let value = self.value.as_ref()?;
        let is_zero = value.as_float() == Some(0.0) || value.as_integer() == Some(0);
        self.definition.zero_word.filter(|_| is_zero)
    }

    /// Returns whether the parameter has its default value.
    pub(crate) fn is_default(&self) -> bool {
        let default = self.definition.default.as_ref().and_then(Item::as_value);
        let text = |value: &Value| value.to_string().trim().to_owned();
        self.value.as_ref().map(text) == default.map(text)
    }

    /// Returns whether a search for `words` finds the parameter, by its label, its key or its help.
    pub(crate) fn is_found(&self, words: &str) -> bool {
        let all = format!("{} {} {}", self.label, self.key, self.definition.help).to_lowercase();
        words.to_lowercase().split_whitespace().all(|word| all.contains(word))
    }
}
