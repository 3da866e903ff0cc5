//! `docs/style-parameters.md`, made from the definitions.

use std::fmt::Write as _;

use super::{Definition, Parameter, Setting, ValueKind, parameters_of};
use crate::style::{Style, marks, texture};

const HEAD: &str = "\
# Parameters of styles and recipes

This page is made from the definitions in `src/style`; `cargo run --release --example style_parameters` writes it anew. \
`hachure styles show NAME --all` tells the same with the values of a style.

A key without a default must be given where its section is; a dash stands for those that may be left out and have none. \
Colours are sRGB.
";

/// A kind of file: its title, what is said of it, and its parameters.
struct Part {
    title: &'static str,
    about: &'static str,
    /// The recipes of this kind that come with the program.
    names: Vec<&'static str>,
    kind: ValueKind,
}

/// The text of `docs/style-parameters.md`.
pub fn document() -> String {
    let parts = [
        Part {
            title: "Styles",
            about: "The keys at the top stand before the first section. A section that is left out draws nothing, or has \
                    its defaults where all of its keys have one.",
            names: Vec::new(),
            kind: Style::kind(),
        },
        Part {
            title: "Recipes of marks",
            about: "`hatching.layers.marks` of a style names one. Everything that has no unit is a part of something. \
                    *Mid tone* is the darkness at which marks of `width_px` stand `spacing_px` apart; the width is 9 \
                    tenths of the spacing at most.",
            names: marks::names(),
            kind: marks::Recipe::kind(),
        },
        Part {
            title: "Recipes of stroke textures",
            about: "`strokes.texture` of a style names one. Everything that has no unit is a part of something. A texel is \
                    a pixel.",
            names: texture::names(),
            kind: texture::Recipe::kind(),
        },
    ];
    let mut text = HEAD.to_owned();
    for Part { title, about, names, kind } in parts {
        // Writing into a string does not fail.
        let _ = write!(text, "\n## {title}\n\n{about}");
        text += &match names.is_empty() {
            true => "\n".to_owned(),
            false => format!(" The program has {}.\n", names.join(", ")),
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
            let shown = if is_list { format!("[[{}]]", key.replace("[]", "")) } else { format!("[{key}]") };
            let count =
                if is_list { format!(" It may stand there for {}.", definition.allowed()) } else { String::new() };
            let _ = write!(text, "\n### `{shown}`\n\n{}{count}\n", definition.help);
        }
        table(&mut text, &rows);
    }
    text
}

/// The parameters of a section, and what the names mean that some of them may have.
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
