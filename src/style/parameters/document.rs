//! Generates `docs/style-parameters.md` from the definitions.

use std::fmt::Write as _;

use super::{Definition, Parameter, Setting, ValueKind, parameters_of};
use crate::style::{Style, marks, texture};

const HEAD: &str = "\
# Parameters of styles and recipes

This page is generated from the definitions in `src/style` by `cargo run --release --example style_parameters`. \
`hachure styles show NAME --all` prints the same parameters with the values of a style.

A key without a default is required where its section is present. A dash marks an optional key without a default. \
Colours are sRGB.
";

/// The chapter about one kind of file: its title, an introduction, and the parameters.
struct Part {
    title: &'static str,
    about: &'static str,
    /// Names of the built-in recipes of this kind.
    names: Vec<&'static str>,
    kind: ValueKind,
}

/// Returns the text of `docs/style-parameters.md`.
pub fn document() -> String {
    let parts = [
        Part {
            title: "Styles",
            about: "The keys of the first table are written before the first section. A section that is left out has its \
                    default values, or does nothing. `[[layers]]` are the inks, from the bottom to the top; each has a \
                    `kind`. Files with a section for each kind (`[strokes]`) are still read; `hachure styles migrate` \
                    rewrites them.",
            names: Vec::new(),
            kind: Style::kind(),
        },
        Part {
            title: "Recipes of marks",
            about: "`marks` of a set of hatching names a recipe. Values without a unit are fractions. *Mid tone* \
                    is the darkness at which marks are `width_px` wide and `spacing_px` apart; the width is at most \
                    90 % of the spacing.",
            names: marks::names(),
            kind: marks::Recipe::kind(),
        },
        Part {
            title: "Recipes of stroke textures",
            about: "`texture` of a layer of strokes names a recipe. Values without a unit are fractions. A texel is a \
                    pixel.",
            names: texture::names(),
            kind: texture::Recipe::kind(),
        },
    ];
    let mut text = HEAD.to_owned();
    for Part { title, about, names, kind } in parts {
        let layers = kinds_of_layers(&kind);
        // Writing into a string cannot fail.
        let _ = write!(text, "\n## {title}\n\n{about}");
        text += &match names.is_empty() {
            true => "\n".to_owned(),
            false => format!(" Built-in recipes: {}.\n", names.join(", ")),
        };
        let mut rows: Vec<Definition> = Vec::new();
        for Parameter { key, definition } in parameters_of(&kind, None) {
            if definition.section().is_none() {
                rows.push(definition);
                continue;
            }
            table(&mut text, &rows);
            rows.clear();
            let is_list = key.ends_with("[]");
            if layers.contains(&key.as_str()) {
                let _ = write!(text, "\n### `[[layers]]` with `kind = \"{key}\"`\n\n{}\n", definition.help);
                continue;
            }
            let key = match layers.iter().find_map(|kind| key.strip_prefix(*kind)?.strip_prefix('.')) {
                Some(within) => format!("layers.{within}"),
                None => key,
            };
            let shown = if is_list { format!("[[{}]]", key.replace("[]", "")) } else { format!("[{key}]") };
            let count =
                if is_list { format!(" There may be {} of this name.", definition.allowed()) } else { String::new() };
            let _ = write!(text, "\n### `{shown}`\n\n{}{count}\n", definition.help);
        }
        table(&mut text, &rows);
    }
    text
}

/// Returns the kinds of layers of a style.
fn kinds_of_layers(kind: &ValueKind) -> Vec<&'static str> {
    let ValueKind::Section(definitions) = kind else { return Vec::new() };
    let of_layers = |definition: &Definition| match &definition.kind {
        ValueKind::Layers(kinds) => kinds.iter().map(|kind| kind.key).collect(),
        _ => Vec::new(),
    };
    definitions.iter().flat_map(of_layers).collect()
}

/// Appends the table of a section's parameters, and the meaning of each name that a parameter accepts.
fn table(text: &mut String, rows: &[Definition]) {
    if rows.is_empty() {
        return;
    }
    text.push_str("\n| key | | unit | range | default |\n| --- | --- | --- | --- | --- |\n");
    for row in rows {
        let default = match &row.default {
            Some(item) => format!("`{}`", item.to_string().trim()),
            None if row.is_required => String::new(),
            None => "–".to_owned(),
        };
        let (unit, allowed) = (row.unit.unwrap_or_default(), row.allowed());
        let _ = writeln!(text, "| `{}` | {} | {unit} | {allowed} | {default} |", row.key, row.help);
    }
    for row in rows {
        if let ValueKind::Choice(choices) = &row.kind {
            let _ = write!(text, "\n`{}`:\n\n", row.key);
            for choice in choices {
                let _ = writeln!(text, "- `{}`: {}", choice.name, choice.help);
            }
        }
    }
}
