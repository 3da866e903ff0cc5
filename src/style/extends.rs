//! Style files that extend a preset: `extends = "ink"`, and then only what differs from it.
//!
//! Sections of the file are merged with those of the preset, key by key; a list is replaced as a whole. The first
//! `[[layers]]` of a kind changes the first layer of that kind, the second one the second, and so on; a layer that the
//! preset lacks is added, at its place in the order of kinds. `without` lists keys of layers, sections and values that
//! the style does not have, and `order` all layers from the bottom to the top, if the order differs.
//!
//! The preset is merged into the parsed table, whose values keep their positions in the file, so that errors have the
//! line and column of the file. Values of the preset have the position of the key `extends`.
//!
//! Why: `docs/decisions/style-differences.md`.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::layers::rank;
use super::{Style, StyleError, names, preset_text};
use crate::file::message::{did_you_mean, quoted};
use crate::file::toml_text::{Misplaced, described};

/// The key that names the preset.
pub(crate) const EXTENDS: &str = "extends";
/// The key that lists what the style does not have.
pub(crate) const WITHOUT: &str = "without";
/// The key that lists the layers in their order.
pub(crate) const ORDER: &str = "order";

/// Returns the preset that the text of a style file extends, if it does.
pub(crate) fn extended(text: &str) -> Option<String> {
    let document: toml_edit::DocumentMut = text.parse().ok()?;
    document.get(EXTENDS)?.as_str().map(str::to_owned)
}

/// Returns the text of a style file with every parameter, if it extends a preset; otherwise the text itself.
///
/// # Errors
/// The text is not a valid style.
pub(crate) fn whole(name: &str, text: &str) -> Result<String, StyleError> {
    match extended(text) {
        Some(_) => Ok(Style::read_values(name, text)?.text()),
        None => Ok(text.to_owned()),
    }
}

/// Merges the preset that a style file extends, if it does, into the table of the file.
///
/// # Errors
/// An unknown preset, and lists of keys that are not valid.
pub(super) fn merge(table: &mut DeTable<'_>) -> Result<(), Misplaced> {
    let Some(extends) = table.remove(EXTENDS) else { return Ok(()) };
    let at = extends.span();
    let text = preset(&extends)?;
    let Ok(parsed) = DeTable::parse(text) else { return Ok(()) };
    let mut preset = DeTable::new();
    for (key, value) in parsed.into_inner() {
        preset.insert(Spanned::new(at.clone(), key.into_inner()), at_span(&value, &at));
    }
    if let Some(without) = table.remove(WITHOUT) {
        leave_out(&mut preset, &without)?;
    }
    let order = table.remove(ORDER);
    merge_tables(table, preset, true);
    if let Some(order) = order {
        sort_layers(table, &order)?;
    }
    Ok(())
}

/// Returns the text of the preset that a value names.
fn preset(extends: &Spanned<DeValue<'_>>) -> Result<&'static str, Misplaced> {
    let at = extends.span();
    let DeValue::String(name) = extends.get_ref() else {
        let words = format!("extends must be the name of a preset, but {}", described(extends.get_ref()));
        return Err(Misplaced { at, words });
    };
    preset_text(name).ok_or_else(|| {
        let meant = did_you_mean(name, names());
        let meant = if meant.is_empty() { "; hachure styles lists them".to_owned() } else { meant };
        Misplaced { at, words: format!("extends: there is no preset {}{meant}", quoted(name)) }
    })
}

/// Returns a value whose parts all have the same position.
fn at_span<'a>(value: &Spanned<DeValue<'a>>, at: &Range<usize>) -> Spanned<DeValue<'a>> {
    let inner = match value.get_ref() {
        DeValue::Table(table) => {
            let mut moved = DeTable::new();
            for (key, value) in table {
                moved.insert(Spanned::new(at.clone(), key.get_ref().clone()), at_span(value, at));
            }
            DeValue::Table(moved)
        }
        DeValue::Array(list) => {
            let mut moved = DeArray::new();
            list.iter().for_each(|value| moved.push(at_span(value, at)));
            DeValue::Array(moved)
        }
        other => other.clone(),
    };
    Spanned::new(at.clone(), inner)
}

/// Adds to a table of the file what only the preset has.
fn merge_tables<'a>(file: &mut DeTable<'a>, preset: DeTable<'a>, is_style: bool) {
    for (key, of_preset) in preset {
        let Some(of_file) = file.get_mut(key.get_ref().as_ref()) else {
            file.insert(key, of_preset);
            continue;
        };
        match (of_file.get_mut(), of_preset.into_inner()) {
            (DeValue::Table(file), DeValue::Table(preset)) => merge_tables(file, preset, false),
            (DeValue::Array(file), DeValue::Array(preset)) if is_style && key.get_ref() == "layers" => {
                merge_layers(file, &preset);
            }
            _ => {}
        }
    }
}

/// Replaces the layers of the file by those of the preset, changed by those of the file.
fn merge_layers<'a>(file: &mut DeArray<'a>, preset: &DeArray<'a>) {
    let mut merged: Vec<Spanned<DeValue<'a>>> = preset.iter().cloned().collect();
    let mut seen: Vec<String> = Vec::new();
    let of_file: Vec<Spanned<DeValue<'a>>> = file.iter().cloned().collect();
    for mut layer in of_file {
        let kind = kind_of(&layer).unwrap_or_default().to_owned();
        let number = seen.iter().filter(|known| **known == kind).count();
        seen.push(kind.clone());
        let places = (0..merged.len()).filter(|place| kind_of(&merged[*place]) == Some(kind.as_str()));
        match places.clone().nth(number) {
            Some(place) => {
                if let (DeValue::Table(file), DeValue::Table(preset)) = (layer.get_mut(), merged[place].get_ref()) {
                    merge_tables(file, preset.clone(), false);
                }
                merged[place] = layer;
            }
            None => {
                let is_below = |below: &Spanned<DeValue<'_>>| kind_of(below).and_then(rank) <= rank(&kind);
                let place = merged.iter().rposition(is_below).map_or(0, |below| below + 1);
                merged.insert(place, layer);
            }
        }
    }
    let mut list = DeArray::new();
    merged.into_iter().for_each(|layer| list.push(layer));
    *file = list;
}

/// Returns the kind of a layer, if it is a table that has one.
fn kind_of<'b>(layer: &'b Spanned<DeValue<'_>>) -> Option<&'b str> {
    match layer.get_ref().get("kind")?.get_ref() {
        DeValue::String(kind) => Some(kind),
        _ => None,
    }
}

/// Returns the texts of a list with their positions.
fn texts<'b>(list: &'b Spanned<DeValue<'_>>, key: &str) -> Result<Vec<(&'b str, Range<usize>)>, Misplaced> {
    let wrong = |value: &Spanned<DeValue<'_>>| Misplaced {
        at: value.span(),
        words: format!("{key} must be a list of keys, but {}", described(value.get_ref())),
    };
    let DeValue::Array(values) = list.get_ref() else { return Err(wrong(list)) };
    let text = |value: &'b Spanned<DeValue<'_>>| match value.get_ref() {
        DeValue::String(text) => Ok((text.as_ref(), value.span())),
        _ => Err(wrong(value)),
    };
    values.iter().map(text).collect()
}

/// Removes keys from the preset.
fn leave_out(preset: &mut DeTable<'_>, without: &Spanned<DeValue<'_>>) -> Result<(), Misplaced> {
    let keys = texts(without, WITHOUT)?;
    // Layers are removed last, so that their numbers are those of the preset.
    let mut removed_layers = Vec::new();
    for (key, at) in keys {
        let lacking = || Misplaced { at: at.clone(), words: format!("without: the preset has no {}", quoted(key)) };
        let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
        match (layer_place(preset, first), rest) {
            (Some(place), None) => removed_layers.push(place),
            (Some(place), Some(rest)) => {
                let layer = layers_of(preset).and_then(|layers| layers.get_mut(place));
                let DeValue::Table(layer) = layer.ok_or_else(lacking)?.get_mut() else { continue };
                remove(layer, rest).ok_or_else(lacking)?;
            }
            (None, _) => remove(preset, key).ok_or_else(lacking)?,
        }
    }
    if let Some(layers) = layers_of(preset) {
        let mut kept = DeArray::new();
        let is_kept = |(place, _): &(usize, &Spanned<DeValue<'_>>)| !removed_layers.contains(place);
        layers.iter().enumerate().filter(is_kept).for_each(|(_, layer)| kept.push(layer.clone()));
        *layers = kept;
    }
    Ok(())
}

fn layers_of<'b, 'a>(table: &'b mut DeTable<'a>) -> Option<&'b mut DeArray<'a>> {
    match table.get_mut("layers")?.get_mut() {
        DeValue::Array(layers) => Some(layers),
        _ => None,
    }
}

/// Returns the index of the layer with a key such as `cuts[1]`.
fn layer_place(table: &mut DeTable<'_>, key: &str) -> Option<usize> {
    let (kind, number) = match key.strip_suffix(']').and_then(|key| key.split_once('[')) {
        Some((kind, number)) => (kind, number.parse().ok()?),
        None => (key, 0),
    };
    let layers = layers_of(table)?;
    layers.iter().enumerate().filter(|(_, layer)| kind_of(layer) == Some(kind)).map(|(place, _)| place).nth(number)
}

fn remove(table: &mut DeTable<'_>, key: &str) -> Option<()> {
    match key.split_once('.') {
        None => table.remove(key).map(|_| ()),
        Some((first, rest)) => match table.get_mut(first)?.get_mut() {
            DeValue::Table(within) => remove(within, rest),
            _ => None,
        },
    }
}

/// Puts the layers into the order that a list of their keys has.
fn sort_layers<'a>(table: &mut DeTable<'a>, order: &Spanned<DeValue<'a>>) -> Result<(), Misplaced> {
    let keys = texts(order, ORDER)?;
    // Every style has rims, although most files do not list them.
    if keys.iter().any(|(key, _)| *key == "rims") && layer_place(table, "rims").is_none() {
        let at = order.span();
        let mut rims = DeTable::new();
        let kind = DeValue::String(Cow::Borrowed("rims"));
        rims.insert(Spanned::new(at.clone(), Cow::Borrowed("kind")), Spanned::new(at.clone(), kind));
        if let Some(layers) = layers_of(table) {
            layers.push(Spanned::new(at, DeValue::Table(rims)));
        }
    }
    let mut places = Vec::new();
    for (key, at) in keys {
        let lacking = || Misplaced { at: at.clone(), words: format!("order: there is no layer {}", quoted(key)) };
        let place = layer_place(table, key).ok_or_else(lacking)?;
        if places.contains(&place) {
            return Err(Misplaced { at, words: format!("order lists the layer {} twice", quoted(key)) });
        }
        places.push(place);
    }
    let Some(layers) = layers_of(table) else { return Ok(()) };
    if let Some(left_out) = (0..layers.len()).find(|place| !places.contains(place)) {
        let kind = layers.get(left_out).and_then(kind_of).unwrap_or_default();
        let words = format!("order must list all layers; a layer of the kind {} is not in it", quoted(kind));
        return Err(Misplaced { at: order.span(), words });
    }
    let mut sorted = DeArray::new();
    places.into_iter().filter_map(|place| layers.get(place)).for_each(|layer| sorted.push(layer.clone()));
    *layers = sorted;
    Ok(())
}
