//! Definitions of parameters as data.

use toml_edit::{ArrayOfTables, Item};

use super::{Range, Setting, find};

/// A parameter, or a section of parameters, as it is defined.
#[derive(Clone, Debug)]
pub struct Definition {
    /// In its section.
    pub key: &'static str,
    /// What it does, in a line.
    pub help: &'static str,
    /// Of a number that has one.
    pub unit: Option<&'static str>,
    /// What the value may be.
    pub range: Range,
    /// What kind of value it is.
    pub kind: ValueKind,
    /// Whether it must be given where its section is.
    pub is_required: bool,
    /// What it is where it is not given; none where nothing takes its place.
    pub default: Option<Item>,
}

/// What kind of value a parameter has.
#[derive(Clone, Debug)]
pub enum ValueKind {
    /// A number.
    Number,
    /// A whole number, 0 or more.
    Whole,
    /// True or false.
    Flag,
    /// A text.
    Text,
    /// A colour.
    Color,
    /// Two numbers.
    Pair,
    /// One of several names.
    Choice(Vec<Choice>),
    /// A list.
    List(Box<ValueKind>),
    /// A section with parameters of its own.
    Section(Vec<Definition>),
}

/// A name that a parameter may have.
#[derive(Clone, Debug)]
pub struct Choice {
    /// As a style file has it.
    pub name: String,
    /// What it means, in a line.
    pub help: &'static str,
}

/// A parameter with its place.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// With its sections: `hatching.layers[0].from`.
    pub key: String,
    /// What holds for it.
    pub definition: Definition,
}

impl Definition {
    pub(crate) fn of<T: Setting>(
        key: &'static str,
        help: &'static str,
        unit: &[&'static str],
        range: Range,
        absent: Option<T>,
    ) -> Self {
        let unit = unit.first().copied().or_else(|| unit_of(key));
        let is_required = absent.is_none();
        let default = absent.and_then(|value| value.item());
        Self { key, help: help.trim_ascii(), unit, range, kind: T::kind(), is_required, default }
    }

    /// What the value may be, in words for a table.
    pub fn allowed(&self) -> String {
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

    /// The parameters within, where it is a section or a list of sections.
    pub fn section(&self) -> Option<&[Self]> {
        match &self.kind {
            ValueKind::Section(definitions) => Some(definitions),
            ValueKind::List(kind) => match &**kind {
                ValueKind::Section(definitions) => Some(definitions),
                _ => None,
            },
            _ => None,
        }
    }
}

impl ValueKind {
    /// In a word or two.
    pub fn name(&self) -> &'static str {
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
        }
    }

    fn plural(&self) -> &'static str {
        match self {
            Self::Color => "colours",
            Self::Text => "texts",
            Self::Section(_) => "sections",
            _ => "values",
        }
    }
}

/// The unit that a key ends with.
fn unit_of(key: &str) -> Option<&'static str> {
    match key.rsplit_once('_')?.1 {
        "px" => Some("px"),
        "deg" => Some("°"),
        "s" => Some("s"),
        _ => None,
    }
}

/// All parameters below a section, in the order of the definitions, but its own values before the sections within it,
/// as a text has them; a section itself comes before what is in it. A list of sections has as many as `item`, which
/// stands for the whole, has entries there; without entries it has one, `[]`.
pub fn parameters_of(kind: &ValueKind, item: Option<&Item>) -> Vec<Parameter> {
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
