//! The two forms of a style file: an ordered list `[[layers]]`, and the form of version 0.1.0, with a section for each
//! kind of layer.
//!
//! Sections are read as layers in the order of kinds; [`migrated`] rewrites them and keeps comments.

use std::borrow::Cow;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use super::{is_kind, keyed, layer_names, rank};
use crate::file::message::{nearest, quoted};
use crate::file::toml_text::{Misplaced, described};

/// Sections of the older form that are layers, from the bottom to the top. Later kinds exist only as `[[layers]]`.
const SECTIONS: [&str; 9] =
    ["tone_lines", "height_lines", "hatching", "cuts", "rows", "water", "rims", "lines", "strokes"];
/// Lists whose names differ between the forms: the section, the name in the older form, and the current name.
const RENAMED: [(&str, &str, &str); 2] = [("hatching", "layers", "sets"), ("cuts", "layers", "families")];

/// Rewrites the table of a style file so that serde reads either form: each layer becomes `{ KIND = { ... } }`. Values
/// keep their positions in the text. `known` are the top-level keys of the file, which may also be a recipe.
///
/// # Errors
/// A layer without a kind; a section next to a list of layers; an unknown section whose name resembles a kind.
pub(in crate::style) fn with_layers(table: &mut DeTable<'_>, known: &[&'static str]) -> Result<(), Misplaced> {
    if known.contains(&"layers") {
        check_sections(table, known)?;
    }
    let section = SECTIONS.iter().find_map(|name| table.get_key_value(*name));
    let section = section.map(|(key, _)| (key.span(), key.get_ref().to_string()));
    let list = match (table.remove_entry("layers"), section) {
        (Some(_), Some((at, name))) => {
            let words = format!(
                "[{name}] cannot be used with [[layers]]; write it as one of the [[layers]], with kind = \"{name}\""
            );
            return Err(Misplaced { at, words });
        }
        (None, None) => return Ok(()),
        (None, Some((at, _))) => {
            let key = Spanned::new(at, Cow::Borrowed("layers"));
            let mut list = DeArray::new();
            for name in SECTIONS {
                let Some((kind, mut section)) = table.remove_entry(name) else { continue };
                if let DeValue::Table(section) = section.get_mut() {
                    rename(section, name)?;
                }
                list.push(table_with_one_entry(kind, section));
            }
            (key, Spanned::new(first_span(&list), DeValue::Array(list)))
        }
        (Some((key, given)), None) => {
            let DeValue::Array(tables) = given.get_ref() else {
                let words = format!("layers must be a list, but {}; write [[layers]]", described(given.get_ref()));
                return Err(Misplaced { at: given.span(), words });
            };
            let mut list = DeArray::new();
            for layer in tables.iter() {
                list.push(by_kind(layer)?);
            }
            (key, Spanned::new(given.span(), DeValue::Array(list)))
        }
    };
    table.insert(list.0, list.1);
    Ok(())
}

/// Returns a layer with its `kind` as the only key.
fn by_kind<'a>(layer: &Spanned<DeValue<'a>>) -> Result<Spanned<DeValue<'a>>, Misplaced> {
    let kinds = layer_names().collect::<Vec<_>>().join(", ");
    let DeValue::Table(mut table) = layer.get_ref().clone() else {
        let words = format!("a layer must be a table, but {}; write [[layers]]", described(layer.get_ref()));
        return Err(Misplaced { at: layer.span(), words });
    };
    let Some(kind) = table.remove("kind") else {
        let words = format!("the key \"layers.kind\" is missing; available: {kinds}");
        return Err(Misplaced { at: layer.span(), words });
    };
    let at = kind.span();
    match kind.into_inner() {
        DeValue::String(name) => {
            let values = Spanned::new(layer.span(), DeValue::Table(table));
            Ok(table_with_one_entry(Spanned::new(at, name), values))
        }
        other => {
            let words = format!("layers.kind must be text, but {}; available: {kinds}", described(&other));
            Err(Misplaced { at, words })
        }
    }
}

/// Refuses a section that is neither known nor a kind of layer, if its name resembles a kind.
fn check_sections(table: &DeTable<'_>, known: &[&'static str]) -> Result<(), Misplaced> {
    let is_unknown = |name: &str| !known.contains(&name) && !SECTIONS.contains(&name);
    let unknown = table.keys().filter(|key| is_unknown(key.get_ref()));
    for key in unknown {
        let all = known.iter().copied().chain(layer_names());
        if let Some(kind) = nearest(key.get_ref(), all).filter(|name| !known.contains(name)) {
            let words = format!("unknown key {}; did you mean a layer with kind = \"{kind}\"?", quoted(key.get_ref()));
            return Err(Misplaced { at: key.span(), words });
        }
    }
    Ok(())
}

fn table_with_one_entry<'a>(key: Spanned<Cow<'a, str>>, value: Spanned<DeValue<'a>>) -> Spanned<DeValue<'a>> {
    let span = value.span();
    let mut table = DeTable::new();
    table.insert(key, value);
    Spanned::new(span, DeValue::Table(table))
}

fn first_span(list: &DeArray<'_>) -> std::ops::Range<usize> {
    list.iter().next().map_or(0..0, Spanned::span)
}

/// Renames the lists of a section of the older form to their current names.
fn rename(section: &mut DeTable<'_>, name: &str) -> Result<(), Misplaced> {
    for (_, old, new) in RENAMED.iter().filter(|(section, ..)| *section == name) {
        if let Some((key, _)) = section.get_key_value(*new) {
            let words = format!("unknown key \"{name}.{new}\"; in a section [{name}] the list is called \"{old}\"");
            return Err(Misplaced { at: key.span(), words });
        }
        if let Some((key, list)) = section.remove_entry(*old) {
            section.insert(Spanned::new(key.span(), Cow::Borrowed(*new)), list);
        }
    }
    Ok(())
}

/// Returns the key of a parameter in a document of either form: `cuts[1].form_px` may be
/// `layers[4].form_px` in a list of layers, and `cuts.families[0].from` is `cuts.layers[0].from` in a document with
/// sections. Keys of parameters outside of layers are unchanged.
pub(crate) fn key_in_document(document: &Item, key: &str) -> String {
    let (first, rest) = key.split_once('.').map_or((key, ""), |(first, rest)| (first, rest));
    let (name, number) = match first.strip_suffix(']').and_then(|first| first.split_once('[')) {
        Some((name, number)) => (name, number.parse().unwrap_or(0)),
        None => (first, 0),
    };
    if !is_kind(name) {
        return key.to_owned();
    }
    if let Some(index) = layer_index(document, name, number) {
        return if rest.is_empty() { format!("layers[{index}]") } else { format!("layers[{index}].{rest}") };
    }
    // The list of a section, without the index of its entry.
    let list = rest.split(['.', '[']).next().unwrap_or_default();
    let renamed = RENAMED.iter().find(|(section, _, new)| *section == name && *new == list);
    match (document.get(name), renamed) {
        (Some(_), Some((_, old, new))) => format!("{name}.{old}{}", &rest[new.len()..]),
        _ => key.to_owned(),
    }
}

/// Returns the index in the document's list of layers of the layer of a kind that has this number among layers of its
/// kind. Returns `None` if the document lists no such layer.
fn layer_index(document: &Item, name: &str, number: usize) -> Option<usize> {
    let layers = document.get("layers")?;
    let kinds = (0..).map_while(|index| layers.get(index));
    let of_kind = kinds.enumerate().filter(|(_, layer)| layer.get("kind").and_then(Item::as_str) == Some(name));
    of_kind.map(|(index, _)| index).nth(number)
}

/// Adds a layer of the kind that `key` begins with to a document that lists layers and lacks the kind. The layer is
/// inserted according to the order of kinds. A list that is written in one line, `layers = [...]`, is not changed.
pub(in crate::style) fn add_missing_layer(document: &mut DocumentMut, key: &str) {
    let kind = key.split(['.', '[']).next().unwrap_or_default();
    let Some(rank) = rank(kind) else { return };
    if layer_index(document.as_item(), kind, 0).is_some() {
        return;
    }
    let Some(layers) = document.get_mut("layers").and_then(Item::as_array_of_tables_mut) else { return };
    let is_above = |layer: &Table| layer.get("kind").and_then(Item::as_str).and_then(super::rank) > Some(rank);
    let mut tables: Vec<Table> = layers.iter().cloned().collect();
    let index = tables.iter().position(is_above).unwrap_or(tables.len());
    let mut added = Table::new();
    added.insert("kind", value(kind));
    tables.insert(index, added);
    *layers = tables.into_iter().collect();
}

/// Returns the keys of the layers that a document lists, from the bottom to the top, as in `cuts` and `cuts[1]`.
pub(in crate::style) fn keys_of_layers(document: &Item) -> Vec<String> {
    let layers = document.get("layers").into_iter().flat_map(|layers| (0..).map_while(|index| layers.get(index)));
    let names: Vec<&str> = layers.filter_map(|layer| layer.get("kind")?.as_str()).collect();
    let number = |index: usize| names[..index].iter().filter(|name| **name == names[index]).count();
    (0..names.len()).map(|index| keyed(names[index], number(index))).collect()
}

/// Returns the text of a style with its sections rewritten as `[[layers]]`. All values, comments and the order within
/// sections are kept, except that a renamed list moves to the end of its layer; a comment stays above what follows it.
/// A text without such sections, or with `[[layers]]`, is returned unchanged. The text must be a valid style: a section
/// that is not a table would be lost.
///
/// # Errors
/// The error of the parser, if the text is not valid TOML.
pub(in crate::style) fn migrated(text: &str) -> Result<String, toml_edit::TomlError> {
    let mut document: DocumentMut = text.parse()?;
    if document.contains_key("layers") || !SECTIONS.iter().any(|name| document.contains_key(name)) {
        return Ok(text.to_owned());
    }
    let mut layers = ArrayOfTables::new();
    let mut first = usize::MAX;
    for name in SECTIONS {
        let Some(section) = document.remove(name) else { continue };
        // A comment behind an inline table belongs to its line, which becomes several lines.
        let comment = section.as_value().and_then(|value| value.decor().suffix()?.as_str().map(str::to_owned));
        let comment = comment.filter(|comment| comment.contains('#'));
        let Ok(mut table) = section.into_table() else { continue };
        if let Some(comment) = comment {
            table.decor_mut().set_prefix(format!("\n{}\n", comment.trim()));
        }
        first = first.min(first_header(&table));
        for (_, old, new) in RENAMED.iter().filter(|(section, ..)| *section == name) {
            if let Some(list) = table.remove(old) {
                table.insert(new, list);
            }
        }
        // The header of a section may be implied by those of its lists; a layer needs a header of its own.
        table.set_implicit(false);
        table.set_dotted(false);
        layers.push(layer_of_kind(table, name));
    }
    // The layers are written where the first of their sections was.
    let mut order: Vec<(usize, String)> =
        document.iter().filter_map(|(key, item)| Some((first_header_of(item)?, key.to_owned()))).collect();
    order.push((first, "layers".to_owned()));
    order.sort();
    document.insert("layers", Item::ArrayOfTables(layers));
    let mut next = 0;
    for (_, key) in order {
        if let Some(item) = document.get_mut(&key) {
            renumber(item, &mut next);
        }
    }
    let migrated = document.to_string();
    Ok(if text.contains("\r\n") { migrated.replace("\r\n", "\n").replace('\n', "\r\n") } else { migrated })
}

/// Returns the table of a section as that of a layer, whose first key is `kind`.
fn layer_of_kind(table: Table, name: &str) -> Table {
    let mut layer = Table::new();
    *layer.decor_mut() = table.decor().clone();
    layer.insert("kind", value(name));
    for key in table.iter().map(|(key, _)| key.to_owned()).collect::<Vec<_>>() {
        if let Some((key, item)) = table.get_key_value(&key) {
            layer.insert_formatted(key, item.clone());
        }
    }
    layer
}

/// Returns the position, among all headers of the document, of the first header of a table and of the tables in it.
fn first_header(table: &Table) -> usize {
    let below = table.iter().filter_map(|(_, item)| first_header_of(item)).min().unwrap_or(usize::MAX);
    table.position().map_or(usize::MAX, |at| at.max(0) as usize).min(below)
}

/// Returns the same for an item; `None` if it has no headers.
pub(super) fn first_header_of(item: &Item) -> Option<usize> {
    match item {
        Item::Table(table) => Some(first_header(table)),
        Item::ArrayOfTables(tables) => tables.iter().map(first_header).min(),
        _ => None,
    }
}

/// Numbers the headers of an item from `next` on, in the order in which they are to be written.
pub(super) fn renumber(item: &mut Item, next: &mut isize) {
    let mut of_table = |table: &mut Table| {
        table.set_position(Some(*next));
        *next += 1;
        let mut below: Vec<(usize, String)> =
            table.iter().filter_map(|(key, item)| Some((first_header_of(item)?, key.to_owned()))).collect();
        below.sort();
        for (_, key) in below {
            if let Some(item) = table.get_mut(&key) {
                renumber(item, next);
            }
        }
    };
    match item {
        Item::Table(table) => of_table(table),
        Item::ArrayOfTables(tables) => tables.iter_mut().for_each(of_table),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::style::Style;

    const OLD: &str = "# A style of mine\nname = \"x\"\ndescription = \"y\"\n\n# a pen\n[strokes] # thin\nwidth_px = 2.0  # was 3\n\n\
        [tone] # grey\nkind = \"plain\"\n\n# Crossed\n[cuts]\nform_px = 7.0\n# level\n[[cuts.layers]]\nspacing_px = 4.0\n\
        [[cuts.layers]]\ntilt_deg = 70.0 # steep\nfrom = 0.5\n\n[paper]\ngrain = 0.1\n";

    #[test]
    fn migration_keeps_comments_and_the_style() {
        let new = migrated(OLD).unwrap();
        let [old_style, new_style] = [OLD, new.as_str()].map(|text| Style::parse("x.toml", text).unwrap());
        assert_eq!(old_style, new_style);
        for comment in
            ["# A style of mine", "# a pen", "# thin", "# was 3", "# grey", "# Crossed", "# level", "# steep"]
        {
            assert_eq!(new.matches(comment).count(), 1, "{comment} in {new}");
        }
        // Cut lines are below strokes, whatever the order of sections.
        let place = |words: &str| new.find(words).unwrap_or_else(|| panic!("{words} in {new}"));
        assert!(place("kind = \"cuts\"") < place("kind = \"strokes\""));
        assert!(place("# Crossed") < place("kind = \"cuts\"") && place("# a pen") > place("tilt_deg"));
        assert!(new.contains("[[layers.families]]") && !new.contains("[cuts]"));
        // A comment behind an inline table, and line ends of Windows.
        let inline =
            "name = \"x\"\r\ndescription = \"\"\r\nrims = { width_px = 2.0 } # thick\r\n[tone]\r\nkind = \"plain\"\r\n";
        let inline = migrated(inline).unwrap();
        assert!(inline.contains("# thick\r\n[[layers]]\r\nkind = \"rims\"\r\n"), "{inline:?}");
        assert!(!inline.replace("\r\n", "").contains('\n'), "{inline:?}");
        assert_eq!(Style::parse("x.toml", &inline).unwrap().rims().unwrap().width_px, 2.0);
        // A text in the current form is unchanged.
        assert_eq!(migrated(&new).unwrap(), new);
    }

    #[test]
    fn keys_are_found_in_either_form() {
        let new = migrated(OLD).unwrap();
        for (text, written) in [(OLD, "cuts.layers[1].from"), (new.as_str(), "layers[0].families[1].from")] {
            let document: DocumentMut = text.parse().unwrap();
            assert_eq!(key_in_document(document.as_item(), "cuts.families[1].from"), written);
            assert_eq!(key_in_document(document.as_item(), "paper.grain"), "paper.grain");
            // Another key that begins with the name of a list is not a list.
            let other = key_in_document(document.as_item(), "cuts.families_px");
            assert!(["cuts.families_px", "layers[0].families_px"].contains(&other.as_str()), "{other}");
        }
        let document: DocumentMut = new.parse().unwrap();
        assert_eq!(keys_of_layers(document.as_item()), ["cuts", "strokes"]);
    }

    #[test]
    fn mistakes_name_the_layer_and_its_place() {
        let head = "name = \"x\"\ndescription = \"y\"\n[tone]\nkind = \"plain\"\n";
        for (layers, words) in [
            ("[[layers]]\n", "x.toml:5:1: the key \"layers.kind\" is missing; available: tone_lines, height_lines, "),
            ("[[layers]]\nkind = \"cut\"\n", "x.toml:6:8: layers.kind cannot be \"cut\"; did you mean \"cuts\"?"),
            (
                "[[layers]]\nkind = \"contours\"\n",
                "x.toml:6:8: layers.kind cannot be \"contours\"; available: tone_lines, height_lines, ",
            ),
            (
                "[[layers]]\nkind = 3\n",
                "x.toml:6:8: layers.kind must be text, but 3 is a number; available: tone_lines",
            ),
            (
                "[[layers]]\nkind = \"cuts\"\nform = 3\n",
                "x.toml:7:1: unknown key \"cuts.form\"; did you mean \"form_px\"?",
            ),
            (
                "[[layers]]\nkind = \"strokes\"\nwidth_px = \"thin\"\n",
                "x.toml:7:12: strokes.width_px must be a number, but \"thin\" is text",
            ),
            (
                "[[layers]]\nkind = \"height_lines\"\n[[layers]]\nkind = \"height_lines\"\nline_px = 99\n",
                "x.toml:9:11: height_lines[1].line_px is 99, not between 0.1 and 8",
            ),
            (
                "[[layers]]\nkind = \"cuts\"\nfamilies = [{}]\n[[layers]]\nkind = \"rims\"\n\
                 [[layers]]\nkind = \"cuts\"\n[[layers.families]]\ntilt = 3\n",
                "x.toml:13:1: unknown key \"cuts[1].families.tilt\"; did you mean \"tilt_deg\"?",
            ),
            (
                "[[layers]]\nkind = \"cuts\"\nfamilies = [{}]\n[[layers]]\nkind = \"cuts\"\nfamilies = [{ tilt_deg = 99 }]\n",
                "x.toml:10:26: cuts[1].families.tilt_deg is 99, not between 0 and 90",
            ),
            (
                "[[layers]]\nkind = \"rims\"\n[[layers]]\nkind = \"rims\"\n",
                "x.toml:7:1: rims[1]: a style has at most one layer of this kind",
            ),
            ("[cuts]\nform_px = 1\n[[layers]]\nkind = \"rims\"\n", "x.toml:5:2: [cuts] cannot be used with [[layers]]"),
            (
                "[cuts]\n[[cuts.layers]]\n[[cuts.families]]\n",
                "x.toml:7:8: unknown key \"cuts.families\"; in a section [cuts] the list is called \"layers\"",
            ),
            ("[stroke]\n", "x.toml:5:2: unknown key \"stroke\"; did you mean a layer with kind = \"strokes\"?"),
            ("[papper]\n", "x.toml:5:2: unknown key \"papper\"; did you mean \"paper\"?"),
            ("[layers]\nkind = \"cuts\"\n", "x.toml:5:1: layers must be a list, but it is a table; write [[layers]]"),
        ] {
            let error = Style::parse("x.toml", &format!("{head}{layers}")).unwrap_err().to_string();
            assert!(error.starts_with(words), "{error}\n{words}");
        }
        // Two kinds may be there four times, and then there is no room for all others.
        let four = |kind: &str, rest: &str| format!("[[layers]]\nkind = \"{kind}\"\n{rest}").repeat(4);
        let cuts = four("cuts", "[[layers.families]]\n");
        let rest = "[[layers]]\nkind = \"features\"\n[[layers]]\nkind = \"strokes\"\nwidth_px = 2\n";
        let many = format!("{head}{cuts}{}{rest}", four("height_lines", ""));
        Style::parse("x.toml", &many).unwrap();
        let more = format!("{many}[[layers]]\nkind = \"tone_lines\"\n");
        let error = Style::parse("x.toml", &more).unwrap_err().to_string();
        assert!(error.contains("layers have 14 inks; at most 13 are allowed"), "{error}");
        let error = Style::parse("x.toml", "").unwrap_err().to_string();
        assert_eq!(error, "x.toml:1:1: the keys \"name\", \"description\", \"tone\" are missing");
        let error = Style::parse("x.toml", &format!("{head}[lines]\n")).unwrap_err().to_string();
        assert_eq!(error, "x.toml:5:1: lines: the keys \"detector\", \"ramp\" are missing");
        let error = Style::parse("x.toml", &format!("layers = 3\n{head}")).unwrap_err().to_string();
        assert!(error.starts_with("x.toml:1:10: layers must be a list, but 3 is a number"), "{error}");
    }
}
