//! Writes a style as its differences from a preset ([`extends`](super::extends)).
//!
//! A file that is written again changes only where the style has changed since: its other text stays as it is, with its
//! comments and the form of its numbers.

use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, TableLike, Value, value};

use super::extends::{EXTENDS, ORDER, WITHOUT};
use super::layers::number_headers;
use super::parameters::{Setting, Tree, find};
use super::{Style, StyleError, names, preset_text};

/// Returns the preset from which a style differs least: that whose differences have the shortest text.
pub(crate) fn nearest_preset(name: &str, text: &str) -> Option<&'static str> {
    let length = |preset: &&str| written(name, preset, text, None).map_or(usize::MAX, |text| text.len());
    names().into_iter().min_by_key(length)
}

/// One table in three versions: that of the preset, that of the file's earlier style, and that of the current style.
#[derive(Clone, Copy)]
struct Tables<'a> {
    preset: Option<&'a Table>,
    before: Option<&'a Table>,
    now: &'a Table,
}

/// Returns the text of a file that extends a preset and describes the style of `text`. `file` is the current text of
/// the file, which extends the same preset, if there is one.
///
/// # Errors
/// A text that is not a valid style; a preset that does not exist.
pub(crate) fn written(name: &str, preset: &str, text: &str, file: Option<&str>) -> Result<String, StyleError> {
    let unknown = || StyleError::Unknown { name: preset.to_owned() };
    let of_preset = Style::read_values(preset, preset_text(preset).ok_or_else(unknown)?)?;
    let style = Style::read_values(name, text)?;
    let before = file.map(|file| Style::read_values(name, file)).transpose()?;
    let [Some(preset_item), Some(now)] = [table(&of_preset), table(&style)] else { return Err(unknown()) };
    let before_item = before.as_ref().map_or_else(|| Some(preset_item.clone()), table);
    // A text that is a valid style is TOML.
    let mut document: DocumentMut = file.unwrap_or_default().parse().unwrap_or_default();
    if file.is_none() {
        document.insert(EXTENDS, value(preset));
    }
    let mut gone = Vec::new();
    let tables = Tables { preset: Some(&preset_item), before: before_item.as_ref(), now: &now };
    update(document.as_table_mut(), tables, "", &mut gone);
    update_layers(&mut document, [&of_preset, before.as_ref().unwrap_or(&of_preset), &style], &mut gone);
    // Values that the preset has only by default are not in its text, and need no mention.
    let whole: DocumentMut = preset_text(preset).unwrap_or_default().parse().unwrap_or_default();
    gone.retain(|key| find(whole.as_item(), key).is_some());
    set_list(&mut document, WITHOUT, &gone);
    number_headers(&mut document);
    let same_order = |document: &DocumentMut| {
        Style::read_values(name, &document.to_string()).is_ok_and(|read| keys(&read) == keys(&style))
    };
    if !same_order(&document) {
        document.remove(ORDER);
        if !same_order(&document) {
            set_list(&mut document, ORDER, &keys(&style));
        }
    }
    Ok(document.to_string())
}

fn table(style: &Style) -> Option<Table> {
    style.item()?.into_table().ok()
}

/// Returns the keys of the layers, from the bottom to the top.
fn keys(style: &Style) -> Vec<String> {
    (0..style.layers.len()).map(|index| style.layers.key(index)).collect()
}

/// Sets a list of keys, or removes it if it is empty. A list with the same keys stays as it is.
fn set_list(document: &mut DocumentMut, key: &str, list: &[String]) {
    let present = document.get(key).and_then(Item::as_array);
    let mut present: Vec<&str> = present.into_iter().flatten().filter_map(Value::as_str).collect();
    let mut wanted: Vec<&str> = list.iter().map(String::as_str).collect();
    if key == WITHOUT {
        present.sort_unstable();
        wanted.sort_unstable();
    }
    if present == wanted {
        return;
    }
    if list.is_empty() {
        document.remove(key);
    } else {
        set(document.as_table_mut(), key, Item::Value(list.iter().map(String::as_str).collect::<Array>().into()));
    }
}

fn is_same(a: Option<&Item>, b: &Item) -> bool {
    // The text of a table leaves out lists of sections in it.
    let whole = |item: &Item| serde_json::to_string(&Tree(Some(item))).unwrap_or_default();
    a.is_some_and(|a| whole(a) == whole(b))
}

/// Writes into a table of the file what has changed since the file was read. Keys that the preset has and the style has
/// not are added to `gone`.
fn update(file: &mut dyn TableLike, tables: Tables<'_>, section: &str, gone: &mut Vec<String>) {
    let Tables { preset, before, now } = tables;
    let key_of = |key: &str| if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") };
    let is_layers = |key: &str| section.is_empty() && key == "layers";
    for (key, item) in now.iter().filter(|(key, _)| !is_layers(key)) {
        let of_preset = preset.and_then(|preset| preset.get(key));
        let of_before = before.and_then(|before| before.get(key));
        if let Item::Table(now) = item {
            let within =
                Tables { preset: of_preset.and_then(Item::as_table), before: of_before.and_then(Item::as_table), now };
            match file.get_mut(key).and_then(Item::as_table_like_mut) {
                Some(there) => update(there, within, &key_of(key), gone),
                None => {
                    let mut new = Table::new();
                    update(&mut new, within, &key_of(key), gone);
                    if !new.is_empty() || of_preset.is_none() {
                        file.insert(key, Item::Table(new));
                    }
                }
            }
            continue;
        }
        if is_same(of_before, item) {
            continue;
        }
        if is_same(of_preset, item) && !has_comment(file, key) {
            file.remove(key);
        } else if !is_same(of_preset, item) || file.contains_key(key) {
            set(file, key, item.clone());
        }
    }
    for (key, _) in preset.into_iter().flat_map(Table::iter) {
        if !now.contains_key(key) {
            gone.push(key_of(key));
        }
    }
    let special = |key: &str| section.is_empty() && [EXTENDS, WITHOUT, ORDER, "layers"].contains(&key);
    let strange = |key: &&str| !now.contains_key(key) && !special(key);
    let strange: Vec<String> = file.iter().map(|(key, _)| key).filter(strange).map(str::to_owned).collect();
    strange.iter().for_each(|key| _ = file.remove(key));
}

/// Adds the keys that a table of the preset has and that of the style has not to `gone`.
fn lacking(preset: &Table, now: &Table, section: &str, gone: &mut Vec<String>) {
    for (key, item) in preset {
        match (item, now.get(key)) {
            (_, None) => gone.push(format!("{section}.{key}")),
            (Item::Table(preset), Some(Item::Table(now))) => lacking(preset, now, &format!("{section}.{key}"), gone),
            _ => {}
        }
    }
}

fn has_comment(file: &dyn TableLike, key: &str) -> bool {
    let is_comment = |raw: Option<&toml_edit::RawString>| {
        raw.and_then(toml_edit::RawString::as_str).is_some_and(|text| text.contains('#'))
    };
    let above = file.key(key).is_some_and(|key| is_comment(key.leaf_decor().prefix()));
    let behind = file.get(key).and_then(Item::as_value).is_some_and(|value| is_comment(value.decor().suffix()));
    above || behind
}

/// Sets a value or a list of sections. A comment after a value is kept.
fn set(file: &mut dyn TableLike, key: &str, mut item: Item) {
    if let (Some(there), Some(value)) = (file.get(key).and_then(Item::as_value), item.as_value_mut()) {
        *value.decor_mut() = there.decor().clone();
    }
    match file.get_mut(key) {
        Some(there) => *there = item,
        None => _ = file.insert(key, item),
    }
}

/// Writes the layers of a style that have changed since the file was read. The styles are the preset, the style as the
/// file described it, and the style as it is now.
fn update_layers(document: &mut DocumentMut, styles: [&Style; 3], gone: &mut Vec<String>) {
    let [preset, before, now] = styles.map(layers);
    let find =
        |all: &[(String, Table)], key: &str| all.iter().find(|(known, _)| known == key).map(|(_, table)| table.clone());
    let mut file = match document.remove("layers") {
        Some(Item::ArrayOfTables(tables)) => tables,
        Some(Item::Value(Value::Array(list))) => {
            list.iter().filter_map(|layer| Some(layer.as_inline_table()?.clone().into_table())).collect()
        }
        _ => ArrayOfTables::new(),
    };
    for (key, table) in &now {
        let [of_preset, of_before] = [&preset, &before].map(|all| find(all, key));
        if is_same(of_before.clone().map(Item::Table).as_ref(), &Item::Table(table.clone())) {
            if let Some(preset) = &of_preset {
                lacking(preset, table, key, gone);
            }
            continue;
        }
        let kind = key.split('[').next().unwrap_or_default();
        let number = key.split(['[', ']']).nth(1).and_then(|number| number.parse().ok()).unwrap_or(0);
        let place = loop {
            if let Some(place) = nth_of_kind(&file, kind, number) {
                break place;
            }
            let mut added = Table::new();
            added.insert("kind", value(kind));
            added.decor_mut().set_prefix("\n");
            file.push(added);
        };
        let tables = Tables { preset: of_preset.as_ref(), before: of_before.as_ref(), now: table };
        if let Some(layer) = file.get_mut(place) {
            update(layer, tables, key, gone);
            layer.entry("kind").or_insert_with(|| value(kind));
        }
    }
    // The file must not describe layers that are gone.
    let mut counts: Vec<(String, usize)> = Vec::new();
    let mut kept = ArrayOfTables::new();
    for layer in file.iter() {
        let kind = layer.get("kind").and_then(Item::as_str).unwrap_or_default();
        let number = counts.iter().filter(|(known, _)| known == kind).count();
        counts.push((kind.to_owned(), number));
        let key = if number == 0 { kind.to_owned() } else { format!("{kind}[{number}]") };
        if now.iter().any(|(known, _)| *known == key) {
            kept.push(layer.clone());
        }
    }
    gone.extend(preset.iter().map(|(key, _)| key).filter(|key| find(&now, key).is_none()).cloned());
    if !kept.is_empty() {
        document.insert("layers", Item::ArrayOfTables(kept));
    }
}

/// Returns the layers of a style with their keys.
fn layers(style: &Style) -> Vec<(String, Table)> {
    let tables = style.layers.item().and_then(|item| match item {
        Item::ArrayOfTables(tables) => Some(tables),
        _ => None,
    });
    keys(style).into_iter().zip(tables.into_iter().flat_map(ArrayOfTables::into_iter)).collect()
}

/// Returns the index of the layer with this number among those of its kind.
fn nth_of_kind(layers: &ArrayOfTables, kind: &str, number: usize) -> Option<usize> {
    let is_kind = |(_, layer): &(usize, &Table)| layer.get("kind").and_then(Item::as_str) == Some(kind);
    layers.iter().enumerate().filter(is_kind).map(|(place, _)| place).nth(number)
}
