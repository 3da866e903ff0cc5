//! Styles and recipes as TOML text: written completely, or edited by one value with comments and order preserved.

use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};
use toml_edit::{DocumentMut, Item, Table, Value};

use super::{Definition, Setting, parameters_of};
use crate::file::message::{did_you_mean, shown};
use crate::file::toml_text::{self, TomlError, Wrong};
use crate::style::layers::{add_missing_layer, key_in_document};

/// Returns a style or recipe as TOML text with every parameter that has a value, defaults included.
pub(crate) fn text(of: &impl Setting) -> String {
    let table = of.item().and_then(|item| item.into_table().ok()).unwrap_or_default();
    DocumentMut::from(table).to_string()
}

/// Splits a key into its names, each with the index of a list entry if it has one.
fn steps(key: &str) -> impl Iterator<Item = (&str, Option<usize>)> {
    key.split('.').map(|step| match step.strip_suffix(']').and_then(|step| step.split_once('[')) {
        Some((name, number)) => (name, number.parse().ok()),
        None => (step, None),
    })
}

/// Returns the item at a key, for example `hatching.sets[0].from`. `item` is the whole document; it may have either form
/// of a style file.
pub(crate) fn find<'a>(item: &'a Item, key: &str) -> Option<&'a Item> {
    let key = key_in_document(item, key);
    steps(&key).try_fold(item, |item, (name, number)| {
        let named = item.as_table_like()?.get(name)?;
        number.map_or(Some(named), |number| named.get(number))
    })
}

/// Returns the text of a style or recipe (`T`) with another value at a key. Comments, order and all other values are
/// preserved; a missing section or key is added at the end. Errors begin with `name`, the name of the file.
///
/// # Errors
/// Invalid TOML; a key that no parameter has; the index of a list entry that does not exist. The value itself is only
/// checked when the text is read.
pub(crate) fn set<T: Setting>(name: &str, text: &str, key: &str, value: impl Into<Value>) -> Result<String, TomlError> {
    set_all::<T>(name, text, vec![(key.to_owned(), value.into())])
}

/// Does the same as [`set`] for several keys.
///
/// # Errors
/// The errors of [`set`].
pub(crate) fn set_all<T: Setting>(name: &str, text: &str, values: Vec<(String, Value)>) -> Result<String, TomlError> {
    // The parser of files has the better messages.
    toml_text::keys(name, text)?;
    let document = text.parse().map_err(|error: toml_edit::TomlError| Wrong::with_message("", error.message()));
    let mut document: DocumentMut = document.map_err(|wrong| wrong.in_text(name, text))?;
    for (key, value) in values {
        let wrong = |message: String| Wrong::with_message(key.as_str(), message).in_text(name, text);
        known::<T>(&key).map_err(wrong)?;
        set_in(&mut document, &key, value).map_err(wrong)?;
    }
    Ok(document.to_string())
}

/// Sets a value in a document.
fn set_in(document: &mut DocumentMut, key: &str, mut value: Value) -> Result<(), String> {
    add_missing_layer(document, key);
    let key = key_in_document(document.as_item(), key);
    let key = key.as_str();
    let no_table = || format!("{}: it must be a table", shown(key));
    let (sections, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut item = document.as_item_mut();
    for (step, number) in steps(sections).filter(|(step, _)| !step.is_empty()) {
        let table = item.as_table_like_mut().ok_or_else(no_table)?;
        item = table.entry(step).or_insert_with(|| Item::Table(Table::new()));
        if let Some(number) = number {
            let entry = item.get_mut(number);
            item = entry.ok_or_else(|| format!("{}: the list has no such entry", shown(key)))?;
        }
    }
    let table = item.as_table_like_mut().ok_or_else(no_table)?;
    match table.get_mut(last).and_then(Item::as_value_mut) {
        Some(there) => {
            // A comment after the value belongs to its line and is kept.
            *value.decor_mut() = there.decor().clone();
            *there = value;
        }
        None => {
            table.insert(last, Item::Value(value));
        }
    }
    Ok(())
}

/// Returns the text of a style or recipe (`T`) without the value at a key, so that the parameter has its default. If a
/// comment belongs to the value, the default is written instead, and the comment stays.
///
/// # Errors
/// The errors of [`set`]; a value without a default cannot be left out, which shows when the text is read.
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) fn restore<T: Setting>(
    name: &str,
    text: &str,
    key: &str,
    default: Option<Value>,
) -> Result<String, TomlError> {
    toml_text::keys(name, text)?;
    let wrong = |message: String| Wrong::with_message(key, message).in_text(name, text);
    known::<T>(key).map_err(&wrong)?;
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| wrong(error.message().into()))?;
    let place = key_in_document(document.as_item(), key);
    let (sections, last) = place.rsplit_once('.').unwrap_or(("", &place));
    let mut item = Some(document.as_item_mut());
    for (step, number) in steps(sections).filter(|(step, _)| !step.is_empty()) {
        item = item.and_then(|item| item.as_table_like_mut()?.get_mut(step));
        if let Some(number) = number {
            item = item.and_then(|item| item.get_mut(number));
        }
    }
    // Values that are not given have their defaults.
    let Some(table) = item.and_then(Item::as_table_like_mut) else { return Ok(text.to_owned()) };
    let is_comment = |raw: Option<&toml_edit::RawString>| {
        raw.and_then(toml_edit::RawString::as_str).is_some_and(|text| text.contains('#'))
    };
    let above = table.key(last).is_some_and(|key| is_comment(key.leaf_decor().prefix()));
    let behind = table.get(last).and_then(Item::as_value).is_some_and(|value| is_comment(value.decor().suffix()));
    match default {
        Some(default) if above || behind => set::<T>(name, text, key, default),
        _ => {
            table.remove(last);
            Ok(document.to_string())
        }
    }
}

/// Checks that a parameter has this key, whatever its list index.
fn known<T: Setting>(key: &str) -> Result<(), String> {
    let bare = |key: &str| steps(key).map(|(name, _)| name).collect::<Vec<_>>().join(".");
    let all = parameters_of(&T::kind(), None);
    let is_value = |definition: &Definition| definition.section().is_none();
    let keys: Vec<String> =
        all.iter().filter(|parameter| is_value(&parameter.definition)).map(|parameter| bare(&parameter.key)).collect();
    if keys.contains(&bare(key)) {
        return Ok(());
    }
    let mut meant = did_you_mean(&bare(key), keys.iter().map(String::as_str));
    if meant.is_empty() {
        meant = "; hachure styles show NAME --all lists the keys of a style".to_owned();
    }
    Err(format!("there is no parameter {}{meant}", shown(key)))
}

/// A TOML item that serde can serialise, with the keys of the file.
pub(crate) struct Tree<'a>(pub Option<&'a Item>);

impl Serialize for Tree<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            None | Some(Item::None) => serializer.serialize_none(),
            Some(Item::Value(value)) => Leaf(value).serialize(serializer),
            Some(Item::Table(table)) => {
                let mut map = serializer.serialize_map(Some(table.len()))?;
                for (key, item) in table {
                    map.serialize_entry(key, &Tree(Some(item)))?;
                }
                map.end()
            }
            Some(Item::ArrayOfTables(tables)) => {
                let mut list = serializer.serialize_seq(Some(tables.len()))?;
                for table in tables {
                    list.serialize_element(&Tree(Some(&Item::Table(table.clone()))))?;
                }
                list.end()
            }
        }
    }
}

/// A TOML value that serde can serialise.
struct Leaf<'a>(&'a Value);

impl Serialize for Leaf<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::String(text) => serializer.serialize_str(text.value()),
            Value::Integer(number) => serializer.serialize_i64(*number.value()),
            Value::Float(number) => serializer.serialize_f64(*number.value()),
            Value::Boolean(flag) => serializer.serialize_bool(*flag.value()),
            Value::Datetime(time) => serializer.collect_str(time.value()),
            Value::Array(list) => serializer.collect_seq(list.iter().map(Leaf)),
            Value::InlineTable(table) => serializer.collect_map(table.iter().map(|(key, value)| (key, Leaf(value)))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::parameters::ValueKind;
    use crate::style::{Style, preset_text};

    #[test]
    fn a_value_is_set_and_all_else_stays() {
        let text = "# mine\nname = \"x\"  # short\ndescription = \"y\"\n\n[strokes]  # a pen\n# thin\nwidth_px = 2.0  # was 3\n\
                    [tone]\nkind = \"plain\"\n[[hatching.layers]]\nmarks = \"line\"\n[[hatching.layers]]\nmarks = \"dash\"\n";
        let set = |key: &str, value: Value| set::<Style>("x.toml", text, key, value).map_err(|error| error.to_string());
        assert_eq!(set("strokes.width_px", 2.5.into()).unwrap(), text.replace("2.0  # was", "2.5  # was"));
        assert_eq!(set("name", "z".into()).unwrap(), text.replacen("\"x\"", "\"z\"", 1));
        let second = text.replace("marks = \"dash\"\n", "marks = \"dash\"\nfrom = 0.5\n");
        assert_eq!(set("hatching.sets[1].from", 0.5.into()).unwrap(), second);
        // A missing key is added.
        let added = text.replace("# was 3\n", "# was 3\ntaper_px = 9.0\n");
        assert_eq!(set("strokes.taper_px", 9.0.into()).unwrap(), added);
        assert_eq!(set("paper.grain", 0.5.into()).unwrap(), format!("{text}\n[paper]\ngrain = 0.5\n"));
        // The text has `[[hatching.layers]]` but no `[hatching]`. A text with layers gets a new one.
        let new = crate::style::layers::migrated(text).unwrap();
        let lined = crate::style::parameters::set::<Style>("x.toml", &new, "height_lines.line_px", 1.5).unwrap();
        assert_eq!(Style::parse("x.toml", &lined).unwrap().lowest_height_lines().unwrap().line_px, 1.5);
        // The new layer has its place in the order of kinds, not on top.
        let kinds = Style::parse("x.toml", &lined).unwrap();
        let kinds: Vec<&str> = kinds.layers.iter().map(crate::style::Layer::kind).collect();
        assert_eq!(kinds, ["height_lines", "hatching", "rims", "strokes"]);
        let wider = crate::style::parameters::set::<Style>("x.toml", &new, "strokes.width_px", 2.5).unwrap();
        assert_eq!(Style::parse("x.toml", &wider).unwrap().strokes().unwrap().width_px, 2.5);
        let soft = set("hatching.softness", 0.25.into()).unwrap();
        let [soft, hard] = [&soft, text].map(|text| Style::parse("x.toml", text).unwrap().hatching().cloned().unwrap());
        assert_eq!((soft.softness, hard.softness, soft.sets), (0.25, 0.0, hard.sets));
        for (key, words) in [
            ("strokes.width", "x.toml:5:1: there is no parameter strokes.width; did you mean \"strokes.width_px\"?"),
            ("strokes", "x.toml:5:1: there is no parameter strokes"),
            ("hatching.sets[2].from", "x.toml:10:3: hatching.layers[2].from: the list has no such entry"),
            ("", "x.toml: there is no parameter "),
            ("qqqq", "x.toml: there is no parameter qqqq; hachure styles show NAME --all lists the keys of a style"),
        ] {
            let error = set(key, 1.into()).unwrap_err();
            assert!(error.starts_with(words), "{error}");
        }
    }

    #[test]
    fn what_serde_has_are_the_keys_of_the_file() {
        let style = Style::parse("wash", preset_text("wash").unwrap()).unwrap();
        let json = serde_json::to_value(&style).unwrap();
        let layers = json["layers"].as_array().unwrap();
        let strokes = layers.iter().find(|layer| layer["kind"] == "strokes").unwrap();
        assert_eq!((&strokes["texture"], &json["tone"]["kind"]), (&"brush".into(), &"toon".into()));
        assert_eq!(json["tone"]["ramp"]["stops"][1]["at"], 0.35);
        assert_eq!(json["tone"]["ramp"]["stops"][3]["colors"][3], "#ffffff");
        assert!(!layers.iter().any(|layer| layer["kind"] == "hatching") && json.get("files").is_none(), "{json}");
        let ValueKind::Section(all) = Style::kind() else { panic!("a style has sections") };
        let keys: Vec<&str> = all.iter().map(|definition| definition.key).collect();
        assert!(json.as_object().unwrap().keys().all(|key| keys.contains(&key.as_str())));
    }
}
