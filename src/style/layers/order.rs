//! Edits of the list of layers in the text of a style: a layer is added, removed, duplicated or moved, and optional
//! sections and entries of lists are added and removed. A comment stays with the layer or section below it.

use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, Value, value};

use super::form::{add_missing_layer, first_header_of, key_in_document, migrated, renumber};
use crate::file::message::shown;
use crate::file::toml_text::{self, TomlError, Wrong};
use crate::style::{names, preset_text};

/// An edit of the layers or sections of a style. Layers are numbered from the bottom, from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LayerEdit {
    /// Adds a layer of a kind, with the values that the first preset with such a layer has.
    Add(&'static str),
    /// Removes a layer.
    Remove(usize),
    /// Inserts a copy of a layer above it.
    Duplicate(usize),
    /// Moves a layer to another place.
    Move(usize, usize),
    /// Adds the section with this key, with the values that the first preset with such a section has.
    AddSection(String),
    /// Removes the section with this key.
    RemoveSection(String),
    /// Adds an entry at the end of the list of sections with this key, as a copy of the last one.
    AddEntry(String),
    /// Removes an entry of a list of sections.
    RemoveEntry(String, usize),
}

/// Returns the text of a style after an edit of its layers or sections. Sections of the older form become layers first.
/// The result may be no valid style: that shows when it is read.
///
/// # Errors
/// Invalid TOML; a layer, section or entry that does not exist. Errors begin with `name`.
pub(crate) fn with_layer_edit(name: &str, text: &str, edit: &LayerEdit) -> Result<String, TomlError> {
    toml_text::keys(name, text)?;
    let wrong = |key: &str, message: &str| Wrong::with_message(key, message).in_text(name, text);
    let layered = migrated(text).map_err(|error| wrong("", error.message()))?;
    let mut document: DocumentMut =
        layered.parse().map_err(|error: toml_edit::TomlError| wrong("", error.message()))?;
    list_layers(&mut document);
    let done = match edit {
        LayerEdit::Add(kind) => add_layer(&mut document, kind),
        LayerEdit::Remove(_) | LayerEdit::Duplicate(_) | LayerEdit::Move(..) => order_layers(&mut document, edit),
        LayerEdit::AddSection(key) => add_section(&mut document, key),
        LayerEdit::RemoveSection(key) => remove_section(&mut document, key),
        LayerEdit::AddEntry(key) => edit_entries(&mut document, key, None),
        LayerEdit::RemoveEntry(key, number) => edit_entries(&mut document, key, Some(*number)),
    };
    done.ok_or_else(|| match edit {
        LayerEdit::AddSection(key) | LayerEdit::RemoveSection(key) => {
            wrong(key, &format!("{}: there is no such section", shown(key)))
        }
        LayerEdit::AddEntry(key) | LayerEdit::RemoveEntry(key, _) => {
            wrong(key, &format!("{}: the list has no such entry", shown(key)))
        }
        _ => wrong("layers", "layers: there is no such layer"),
    })?;
    number_headers(&mut document);
    Ok(document.to_string())
}

/// Makes the document list all layers as `[[layers]]`, those that it has without listing them included.
fn list_layers(document: &mut DocumentMut) {
    let tables = match document.remove("layers") {
        Some(Item::ArrayOfTables(tables)) => tables,
        Some(Item::Value(Value::Array(list))) => list.iter().filter_map(table_of).collect(),
        _ => ArrayOfTables::new(),
    };
    document.insert("layers", Item::ArrayOfTables(tables));
    add_missing_layer(document, "rims");
}

fn table_of(value: &Value) -> Option<Table> {
    value.as_inline_table().map(|table| table.clone().into_table())
}

fn layers_of(document: &mut DocumentMut) -> Option<&mut ArrayOfTables> {
    document.get_mut("layers")?.as_array_of_tables_mut()
}

fn kind_of(layer: &Table) -> Option<&str> {
    layer.get("kind")?.as_str()
}

fn add_layer(document: &mut DocumentMut, kind: &'static str) -> Option<()> {
    let mut added = layer_of_a_preset(kind).unwrap_or_else(|| {
        let mut table = Table::new();
        table.insert("kind", value(kind));
        table
    });
    added.decor_mut().set_prefix("\n");
    let layers = layers_of(document)?;
    let mut tables: Vec<Table> = layers.iter().cloned().collect();
    let is_below = |layer: &Table| kind_of(layer).and_then(super::rank) <= super::rank(kind);
    let index = tables.iter().rposition(is_below).map_or(0, |below| below + 1);
    tables.insert(index, added);
    *layers = tables.into_iter().collect();
    Some(())
}

/// Returns the presets as documents.
fn presets() -> impl Iterator<Item = DocumentMut> {
    names().into_iter().filter_map(|name| preset_text(name)?.parse().ok())
}

/// Returns the layer of a kind in the first preset that has one, without comments.
fn layer_of_a_preset(kind: &str) -> Option<Table> {
    presets().find_map(|preset| {
        let layers = preset.get("layers")?.as_array_of_tables()?;
        let mut layer = layers.iter().find(|layer| kind_of(layer) == Some(kind))?.clone();
        remove_comments(&mut layer);
        Some(layer)
    })
}

fn remove_comments(table: &mut Table) {
    table.decor_mut().clear();
    for (mut key, item) in table.iter_mut() {
        key.leaf_decor_mut().clear();
        match item {
            Item::Table(table) => remove_comments(table),
            Item::ArrayOfTables(tables) => tables.iter_mut().for_each(remove_comments),
            Item::Value(value) => value.decor_mut().clear(),
            Item::None => {}
        }
    }
}

fn order_layers(document: &mut DocumentMut, edit: &LayerEdit) -> Option<()> {
    let layers = layers_of(document)?;
    let mut tables: Vec<Table> = layers.iter().cloned().collect();
    match *edit {
        LayerEdit::Remove(index) if index < tables.len() => {
            tables.remove(index);
        }
        LayerEdit::Duplicate(index) => {
            let mut copy = tables.get(index)?.clone();
            remove_comments(&mut copy);
            tables.insert(index + 1, copy);
        }
        LayerEdit::Move(from, to) if from < tables.len() && to < tables.len() => {
            let moved = tables.remove(from);
            tables.insert(to, moved);
        }
        _ => return None,
    }
    // A header that was the first line of the file has no blank line above it.
    for table in &mut tables {
        let prefix = table.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().to_owned();
        if !prefix.starts_with(['\n', '\r']) {
            table.decor_mut().set_prefix(format!("\n{prefix}"));
        }
    }
    *layers = tables.into_iter().collect();
    Some(())
}

/// Returns the item at a key of the document, such as `layers[2].sets`; the document itself for an empty key.
fn at<'a>(document: &'a mut DocumentMut, key: &str) -> Option<&'a mut Item> {
    let mut item = document.as_item_mut();
    for step in key.split('.').filter(|step| !step.is_empty()) {
        let (name, number) = match step.strip_suffix(']').and_then(|step| step.split_once('[')) {
            Some((name, number)) => (name, number.parse::<usize>().ok()),
            None => (step, None),
        };
        item = item.as_table_like_mut()?.get_mut(name)?;
        if let Some(number) = number {
            item = item.get_mut(number)?;
        }
    }
    Some(item)
}

/// Returns the key of the section that contains a parameter, and the name of the parameter in it.
fn parent_and_name(document: &mut DocumentMut, key: &str) -> (String, String) {
    let key = key_in_document(document.as_item(), key);
    let (parent, name) = key.rsplit_once('.').unwrap_or(("", &key));
    (parent.to_owned(), name.to_owned())
}

fn add_section(document: &mut DocumentMut, key: &str) -> Option<()> {
    let (parent, name) = parent_and_name(document, key);
    let mut section = presets().find_map(|mut preset| at(&mut preset, key)?.as_table().cloned()).unwrap_or_default();
    remove_comments(&mut section);
    section.set_implicit(false);
    if parent.is_empty() {
        section.decor_mut().set_prefix("\n");
    }
    at(document, &parent)?.as_table_like_mut()?.insert(&name, Item::Table(section));
    Some(())
}

fn remove_section(document: &mut DocumentMut, key: &str) -> Option<()> {
    let (parent, name) = parent_and_name(document, key);
    at(document, &parent)?.as_table_like_mut()?.remove(&name).map(|_| ())
}

/// Removes an entry of a list of sections, or adds one at its end.
fn edit_entries(document: &mut DocumentMut, key: &str, removed: Option<usize>) -> Option<()> {
    let key = key_in_document(document.as_item(), key);
    match (at(document, &key)?, removed) {
        (Item::ArrayOfTables(tables), Some(number)) if number < tables.len() => {
            tables.remove(number);
        }
        (Item::ArrayOfTables(tables), None) => {
            let mut copy = tables.iter().last()?.clone();
            remove_comments(&mut copy);
            spread_apart(&mut copy);
            tables.push(copy);
        }
        (Item::Value(Value::Array(list)), Some(number)) if number < list.len() => {
            list.remove(number);
        }
        (Item::Value(Value::Array(list)), None) => push_copy(list)?,
        _ => return None,
    }
    Some(())
}

fn push_copy(list: &mut Array) -> Option<()> {
    let copy = list.iter().last()?.clone();
    list.push_formatted(copy);
    Some(())
}

/// Makes the copy of the last stop of a ramp come after it: stops must rise.
fn spread_apart(stop: &mut Table) {
    if let Some(at) = stop.get("at").and_then(Item::as_float) {
        stop.insert("at", value(at + (0.1 * at.abs()).max(0.1)));
    }
}

/// Numbers the headers of all tables in the order in which they are written: a new one after those that were there, and
/// layers where the first of them was.
pub(in crate::style) fn number_headers(document: &mut DocumentMut) {
    let mut order: Vec<(usize, String)> =
        document.iter().filter_map(|(key, item)| Some((first_header_of(item)?, key.to_owned()))).collect();
    order.sort();
    let mut next = 0;
    for (_, key) in order {
        if let Some(item) = document.get_mut(&key) {
            renumber(item, &mut next);
        }
    }
}
