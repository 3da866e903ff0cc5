//! `hachure styles show NAME --all`: lists every parameter with its value in a style.

use std::path::Path;

use anyhow::Context;
use serde::{Serialize, Serializer};
use toml_edit::{DocumentMut, Item};

use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::message::shown;
use crate::style::layers::layer_names;
use crate::style::parameters::{Definition, Parameter, Setting, Tree, ValueKind, find, parameters_of};
use crate::style::{Style, preset_text};

/// Longest value in the table, in characters.
const LONGEST_VALUE: usize = 24;

/// A parameter of a style.
#[derive(Serialize)]
pub(super) struct Row {
    /// Key with its sections.
    key: String,
    /// Value in the style; `None` if the style lacks the section, or if no value is given and there is no default.
    #[serde(serialize_with = "as_json")]
    value: Option<Item>,
    /// Whether the style's text sets the value.
    is_set: bool,
    kind: &'static str,
    unit: Option<&'static str>,
    /// Allowed values, in words.
    range: String,
    least: Option<f32>,
    most: Option<f32>,
    /// Allowed values of a name.
    choices: Option<Vec<String>>,
    is_required: bool,
    #[serde(serialize_with = "as_json")]
    default: Option<Item>,
    help: &'static str,
    #[serde(skip)]
    is_section: bool,
}

fn as_json<S: Serializer>(item: &Option<Item>, serializer: S) -> Result<S::Ok, S::Error> {
    Tree(item.as_ref()).serialize(serializer)
}

/// Returns the rows of a style, each section before its parameters; `text` is the TOML from which the style was read.
pub(super) fn rows(style: &Style, text: &str) -> anyhow::Result<Vec<Row>> {
    let whole = style.item().context("a style is a table")?;
    let document: DocumentMut = text.parse().context("the text of a style is TOML")?;
    let row = |Parameter { key, definition }: Parameter| {
        let Definition { help, unit, range, is_required, .. } = definition;
        let is_section = definition.section().is_some();
        let choices = match &definition.kind {
            ValueKind::Choice(all) => Some(all.iter().map(|choice| choice.name.clone()).collect()),
            _ => None,
        };
        let [least, most] = range.ends();
        Row {
            value: find(&whole, &key).cloned(),
            is_set: find(document.as_item(), &as_written(&key, document.as_item())).is_some(),
            kind: definition.kind.name(),
            range: definition.allowed(),
            default: definition.default.filter(|_| !is_section),
            key,
            unit,
            least,
            most,
            choices,
            is_required,
            help,
            is_section,
        }
    };
    Ok(parameters_of(&Style::kind(), Some(&whole)).into_iter().map(row).collect())
}

/// Converts a key of the style to the key of the same value in its text: the style sorts sets of hatching marks and
/// families of cut lines by `from`.
fn as_written(key: &str, document: &Item) -> String {
    let Some((list, number, rest)) = ["sets[", "families["].iter().find_map(|name| {
        let (before, after) = key.split_once(name)?;
        let (number, rest) = after.split_once(']')?;
        Some((format!("{before}{}", name.trim_end_matches('[')), number.parse::<usize>().ok()?, rest))
    }) else {
        return key.to_owned();
    };
    let from = |number: usize| {
        let from = find(document, &format!("{list}[{number}].from"));
        from.and_then(|from| from.as_float().or_else(|| from.as_integer().map(|whole| whole as f64))).unwrap_or(0.0)
    };
    let mut entries: Vec<usize> =
        (0..).take_while(|number| find(document, &format!("{list}[{number}]")).is_some()).collect();
    entries.sort_by(|a, b| from(*a).total_cmp(&from(*b)));
    entries.get(number).map_or_else(|| key.to_owned(), |written| format!("{list}[{written}]{rest}"))
}

/// Loads a preset or a style file, with its text.
pub(super) fn load(name: &str) -> anyhow::Result<(Style, String)> {
    if let Some(text) = preset_text(name) {
        return Ok((Style::parse(name, text)?, text.to_owned()));
    }
    let style = crate::commands::arguments::style(name)?;
    let text = read_text(Path::new(name), LARGEST_STYLE_BYTES).with_context(|| shown(name))?;
    Ok((style, text))
}

/// Formats the rows as a table, with a heading for each section.
pub(super) fn table(style: &Style, rows: &[Row]) -> String {
    let parameters: Vec<&Row> = rows.iter().filter(|row| !row.is_section).collect();
    let width = |of: &dyn Fn(&Row) -> String| parameters.iter().map(|row| of(row).chars().count()).max().unwrap_or(0);
    let columns: [&dyn Fn(&Row) -> String; 5] =
        [&Row::name, &Row::shown_value, &Row::shown_unit, &Row::shown_range, &Row::shown_default];
    let widths = columns.map(|column| width(column));
    let mut lines = vec![
        format!("{}: {}", shown(&style.name), style.description),
        "A * marks values that the style sets; a dash means no value. Layers are listed from the bottom to the top, and \
         then the kinds of layers that the style does not have."
            .to_owned(),
        String::new(),
        line(" ", &["", "value", "unit", "range", "default"].map(str::to_owned), &widths, ""),
    ];
    for row in rows {
        if row.is_section {
            let state = if row.value.is_none() { ", not in this style" } else { "" };
            lines.extend([String::new(), format!("{}{state}: {}", row.heading(), row.help)]);
            continue;
        }
        let mark = if row.is_set { "*" } else { " " };
        lines.push(line(mark, &columns.map(|column| column(row)), &widths, row.help));
    }
    lines.join("\n")
}

/// Joins the cells of a line; all columns, also those of numbers, are left-aligned.
fn line(mark: &str, cells: &[String; 5], widths: &[usize; 5], help: &str) -> String {
    let cells = cells.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
    let line = format!("{mark} {}  {help}", cells.collect::<Vec<_>>().join("  "));
    line.trim_end().to_owned()
}

impl Row {
    /// Returns the heading of a section: `[paper]`, `layer cuts[1]`, `layer hatching, sets[0]`.
    fn heading(&self) -> String {
        let (layer, within) = self.key.split_once('.').map_or((self.key.as_str(), None), |(a, b)| (a, Some(b)));
        let kind = layer.split('[').next().unwrap_or_default();
        match within {
            _ if !layer_names().any(|name| name == kind) => format!("[{}]", self.key),
            None => format!("layer {layer}"),
            Some(within) => format!("layer {layer}, {within}"),
        }
    }

    fn name(&self) -> String {
        self.key.rsplit_once('.').map_or(self.key.as_str(), |(_, name)| name).to_owned()
    }

    fn shown_value(&self) -> String {
        let value = self.value.as_ref().map_or("–".to_owned(), |value| value.to_string().trim().to_owned());
        let count = value.chars().count();
        if count <= LONGEST_VALUE {
            return value;
        }
        value.chars().take(LONGEST_VALUE - 1).chain(['…']).collect()
    }

    fn shown_unit(&self) -> String {
        self.unit.unwrap_or_default().to_owned()
    }

    fn shown_range(&self) -> String {
        self.range.clone()
    }

    fn shown_default(&self) -> String {
        match &self.default {
            Some(default) => default.to_string().trim().to_owned(),
            None if self.is_required => "required".to_owned(),
            None => "–".to_owned(),
        }
    }
}
