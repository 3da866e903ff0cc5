//! Tests the parameters of styles and recipes by their definitions: what is written reads back the same, every range is
//! checked, and the documentation agrees with the definitions.
#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

#[cfg(any(feature = "window", feature = "headset"))]
mod labels;
pub(super) mod random;

use std::collections::BTreeSet;
use std::fmt::Debug;
use std::fs;
use std::path::Path;

use hachure::style::layers::key_in_document;
use hachure::style::parameters::{
    Parameter, Range, Setting, Tree, ValueKind, document, find, parameters_of, read, set, text,
};
use hachure::style::{Style, marks, names, preset_text, texture};
use serde::Serialize;
use serde_json::Value;
use toml_edit::{DocumentMut, Item};

use crate::tests::common::full;
use random::Random;

/// Common interface of styles and recipes.
trait Kind: Setting + Serialize + PartialEq + Debug {
    fn parse(text: &str) -> Result<Self, String>;
}

impl Kind for Style {
    fn parse(text: &str) -> Result<Self, String> {
        Self::parse("x.toml", text).map_err(|error| error.to_string())
    }
}

impl Kind for marks::Recipe {
    fn parse(text: &str) -> Result<Self, String> {
        Self::parse("x.toml", text).map_err(|error| error.to_string())
    }
}

impl Kind for texture::Recipe {
    fn parse(text: &str) -> Result<Self, String> {
        Self::parse("x.toml", text).map_err(|error| error.to_string())
    }
}

fn json(item: &Item) -> Value {
    serde_json::to_value(Tree(Some(item))).unwrap()
}

/// Returns the JSON value at a key such as `hatching.sets[0].from`.
fn at<'a>(whole: &'a Value, key: &str) -> &'a Value {
    let steps = key.split(['.', '[']).map(|step| step.trim_end_matches(']'));
    steps.fold(whole, |value, step| step.parse::<usize>().map_or_else(|_| &value[step], |number| &value[number]))
}

/// Returns whether two values are the same to a parameter's precision.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            a.as_f64().map(|a| (a as f32).to_bits()) == b.as_f64().map(|b| (b as f32).to_bits())
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        _ => a == b,
    }
}

/// Returns the parameters that have values, without the sections that contain them.
fn leaves<T: Setting>(item: Option<&Item>) -> Vec<Parameter> {
    parameters_of(&T::kind(), item).into_iter().filter(|parameter| parameter.definition.section().is_none()).collect()
}

/// Returns the text without the value at a key.
fn without(text: &str, key: &str) -> String {
    let mut document: DocumentMut = text.parse().unwrap();
    let key = &key_in_document(document.as_item(), key);
    let mut item = document.as_item_mut();
    let (sections, last) = key.rsplit_once('.').unwrap_or(("", key));
    for step in sections.split(['.', '[']).map(|step| step.trim_end_matches(']')).filter(|step| !step.is_empty()) {
        item = match step.parse::<usize>() {
            Ok(number) => &mut item[number],
            Err(_) => &mut item[step],
        };
    }
    assert!(item.as_table_like_mut().unwrap().remove(last).is_some(), "{key} in {text}");
    document.to_string()
}

/// Tests that random values of all parameters of `T` are unchanged when written and read again, and that a missing one
/// is detected.
fn reads_back<T: Kind>(seeds: u64) {
    let mut seen = BTreeSet::new();
    for seed in 0..seeds {
        let given = random::table::<T>(&mut Random(seed), false).to_string();
        let read = T::parse(&given).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{given}"));
        let written = text(&read);
        let again = T::parse(&written).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{written}"));
        assert_eq!(again, read, "seed {seed}: {written}");
        assert_eq!(text(&again), written, "seed {seed}");

        // The given values are those that were read, and serde has them under the same keys.
        let document: DocumentMut = given.parse().unwrap();
        let (given, stored) = (json(document.as_item()), serde_json::to_value(&read).unwrap());
        let whole = read.item().unwrap();
        for Parameter { key, definition } in leaves::<T>(Some(document.as_item())) {
            let value = at(&given, &key_in_document(document.as_item(), &key));
            let stored = at(&stored, &key_in_document(&whole, &key));
            if !value.is_null() {
                assert!(same(value, stored), "seed {seed}: {key} is {stored}, expected {value}");
            }
            let default = definition.default.as_ref().map(json).unwrap_or_default();
            if value.is_null() {
                // A section that is missing has no values.
                assert!(
                    stored.is_null() || same(stored, &default),
                    "seed {seed}: {key} is {stored}, expected its default"
                );
            } else if !same(value, &default) {
                seen.insert(random::bare(&key));
            }
        }

        // Planted: a writer that omits any one value.
        if seed % 20 == 0 {
            let document: DocumentMut = written.parse().unwrap();
            for Parameter { key, definition } in leaves::<T>(Some(document.as_item())) {
                let Some(value) = find(document.as_item(), &key) else { continue };
                let is_default = definition.default.is_some_and(|default| same(&json(&default), &json(value)));
                let lost = T::parse(&without(&written, &key));
                assert_eq!(
                    lost.is_ok_and(|lost| lost == read),
                    is_default,
                    "seed {seed}: a missing {key} = {value} was not detected"
                );
            }
        }
    }
    let all: BTreeSet<String> = leaves::<T>(None).iter().map(|parameter| random::bare(&parameter.key)).collect();
    assert_eq!(seen, all, "not every parameter had a value other than its default");
}

#[test]
fn what_is_written_reads_back() {
    reads_back::<Style>(if full() { 200 } else { 50 });
    reads_back::<marks::Recipe>(200);
    reads_back::<texture::Recipe>(200);
    for name in names() {
        let style = Style::load(name).unwrap();
        assert_eq!(Style::parse(name, &style.text()).unwrap(), style);
    }
}

/// Returns the ends of a range, and values just outside it.
fn around(range: Range) -> Option<([Value; 2], Vec<Value>)> {
    let next = |number: f32| Value::from(f64::from(number.next_up()));
    let before = |number: f32| Value::from(f64::from(number.next_down()));
    let number = |number: f32| Value::from(f64::from(number));
    Some(match range {
        Range::Within(low, high) => ([number(low), number(high)], vec![before(low), next(high)]),
        Range::AtLeast(low) => ([number(low), 1e30.into()], vec![before(low)]),
        Range::Above(low) => ([next(low), 1e30.into()], vec![number(low)]),
        Range::PowerOfTwo(low, high) => {
            ([low.into(), high.into()], vec![(low / 2).into(), (high * 2).into(), 48.into()])
        }
        Range::ZeroOr(low, high) => ([low.into(), 0.into()], vec![(low - 1).into(), (high + 1).into()]),
        Range::Rising(low) => (
            [[low, low + 1.0].into(), [low, 1e30].into()],
            vec![[low - 1.0, low + 1.0].into(), [low + 1.0, low + 1.0].into()],
        ),
        Range::Span(low, high) => (
            [[low, high].into(), [high, high].into()],
            vec![[low - 1.0, high].into(), [low, high + 1.0].into(), [high, low].into()],
        ),
        Range::Any | Range::Entries(..) => return None,
    })
}

fn to_toml(value: &Value) -> toml_edit::Value {
    match value {
        Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into(),
            None => number.as_f64().unwrap().into(),
        },
        Value::Array(list) => list.iter().map(to_toml).collect::<toml_edit::Array>().into(),
        other => panic!("{other} cannot be the value of a parameter"),
    }
}

/// Tests that every number in a text with all keys is checked against its range, and that the error names its key.
fn ranges_are_checked<T: Kind>() {
    let mut checked = 0;
    let whole = random::table::<T>(&mut Random(7), true).to_string();
    let document: DocumentMut = whole.parse().unwrap();
    T::parse(&whole).unwrap();
    for Parameter { key, definition } in leaves::<T>(Some(document.as_item())) {
        let is_number = matches!(definition.kind, ValueKind::Number | ValueKind::Whole | ValueKind::Pair);
        assert!(!is_number || definition.range != Range::Any || key.ends_with("seed"), "{key} needs a range");
        let Some((inside, outside)) = around(definition.range) else { continue };
        // In the fast tier one value inside and one outside of each range, not always the same ones.
        let (inside, outside) = match full() {
            true => (&inside[..], &outside[..]),
            false => (&inside[checked % 2..][..1], &outside[checked % outside.len()..][..1]),
        };
        let with = |value: &Value| {
            let value = match (&definition.kind, value.as_f64()) {
                // Whole numbers are rounded away from the range, since their neighbours differ by 1.
                (ValueKind::Whole, Some(number)) => {
                    let [least, most] = definition.range.ends().map(|end| end.map(f64::from));
                    match number {
                        _ if least.is_some_and(|least| number < least) => (number.floor() as i64).into(),
                        _ if most.is_some_and(|most| number > most) => (number.ceil() as i64).into(),
                        _ => (number as i64).into(),
                    }
                }
                _ => to_toml(value),
            };
            T::parse(&set::<T>("x.toml", &whole, &key, value).unwrap())
        };
        for value in outside {
            let error = with(value).err().unwrap_or_else(|| panic!("{key} = {value} was accepted"));
            // For a stop far outside, the first error may be that stops must increase.
            let is_named =
                error.contains(&format!(": {}", random::bare(&key))) || error.contains("stops must increase");
            assert!(is_named, "{key} = {value}: {error}");
            assert!(error.starts_with("x.toml:") && error.lines().count() == 1, "{error}");
        }
        for value in inside {
            // Other rules than the range apply here: stops must increase, and marks cannot be wider than their spacing
            // allows.
            let is_bound = ["at", "width_px", "spacing_px"].iter().any(|bound| random::bare(&key).ends_with(bound));
            if let Err(error) = with(value) {
                assert!(is_bound && !error.contains("not between"), "{key} cannot be {value}: {error}");
            }
        }
        checked += 1;
    }
    assert!(checked >= 10, "only {checked} parameters have a range");
}

#[test]
fn every_range_is_checked() {
    ranges_are_checked::<Style>();
    ranges_are_checked::<marks::Recipe>();
    ranges_are_checked::<texture::Recipe>();
}

#[test]
fn definitions_help() {
    let roots = [Style::kind(), marks::Recipe::kind(), texture::Recipe::kind()];
    let all: Vec<Parameter> = roots.iter().flat_map(|kind| parameters_of(kind, None)).collect();
    assert!(all.len() > 100, "{}", all.len());
    let flawed = |help: &str| {
        let ends = help.ends_with('.') && help.starts_with(char::is_uppercase);
        !ends || help.contains("[`") || help.contains('|') || help.contains("  ") || help.chars().count() > 130
    };
    for Parameter { key, definition } in &all {
        assert!(!flawed(definition.help), "{key}: {}", definition.help);
        if let ValueKind::Choice(choices) = &definition.kind {
            assert!(choices.iter().all(|choice| !flawed(choice.help)), "{key}: {choices:?}");
        }
    }
    // Planted: flawed helps.
    for help in ["", "no beginning.", "No end", "A | b.", "[`Link`]."] {
        assert!(flawed(help), "{help}");
    }
}

#[test]
fn the_documentation_is_that_of_the_definitions() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/style-parameters.md");
    let written = fs::read_to_string(&path).unwrap_or_default();
    let made = document();
    let differs = written.lines().zip(made.lines()).position(|(written, made)| written != made);
    assert!(
        written == made,
        "docs/style-parameters.md does not agree with the definitions from line {} on; regenerate it with\n  \
         cargo run --release --example style_parameters",
        differs.unwrap_or(0) + 1
    );
    // Every parameter is documented with its help and default. Planted: one that is not.
    let is_there = |definition: &hachure::style::parameters::Definition| {
        made.contains(&format!("| `{}` | {} |", definition.key, definition.help))
    };
    let all: Vec<Parameter> = [Style::kind(), marks::Recipe::kind(), texture::Recipe::kind()]
        .iter()
        .flat_map(|kind| parameters_of(kind, None))
        .filter(|parameter| parameter.definition.section().is_none())
        .collect();
    assert!(all.iter().all(|parameter| is_there(&parameter.definition)));
    let mut planted = all[0].definition.clone();
    planted.help = "Planted.";
    assert!(!is_there(&planted));
    assert!(made.contains("| `width_px` | Width of a stroke. | px | 0.5 to 64 |  |"), "{made}");
}

#[test]
fn presets_are_edited_with_their_comments() {
    let text = preset_text("strokes").unwrap();
    let thick = set::<Style>("strokes", text, "strokes.width_px", 9.5).unwrap();
    assert_eq!(thick, text.replace("width_px = 2.6", "width_px = 9.5"));
    assert!(thick.contains("# Rebuilt in every tenth frame"));
    let [before, after] = [text, &thick].map(|text| read::<Style>("strokes", text).unwrap());
    assert_eq!(after.strokes().unwrap().width_px, 9.5);
    // Nothing else has changed, and the comparison detects the change.
    assert_ne!(after, before);
    let mut back = after;
    back.strokes_mut().unwrap().width_px = before.strokes().unwrap().width_px;
    assert_eq!(back, before);
}
