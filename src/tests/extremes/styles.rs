//! Every parameter of styles at both ends of its range, and random styles.

use std::collections::{BTreeMap, BTreeSet};

use hachure::style::parameters::{Definition, Range, Setting, ValueKind, parameters_of, set};
use hachure::style::{Style, names, preset_text};
use toml_edit::{Array, DocumentMut, Value};

use super::checked::{Checked, SIZE_PX};
use super::lands::{EXTREME, Land, ORDINARY, SPACING_M};
use super::views::suns;
use crate::tests::common::draw::north_west;
use crate::tests::common::full;
use crate::tests::style_parameters::random::{self, Random};

/// Returns the ends of a parameter's range: all names of a choice, both values of a flag, and the largest number where a
/// range has no upper end.
fn ends(definition: &Definition) -> Vec<Value> {
    let number = |number: f32| match definition.kind {
        ValueKind::Whole => Value::from(number as i64),
        _ => Value::from(f64::from(number)),
    };
    let pair = |a: f32, b: f32| Value::Array([a, b].map(f64::from).into_iter().collect::<Array>());
    match (&definition.kind, definition.range) {
        (ValueKind::Flag, _) => [false, true].map(Value::from).to_vec(),
        (ValueKind::Choice(choices), _) => choices.iter().map(|choice| Value::from(choice.name.as_str())).collect(),
        (ValueKind::Color, _) => ["#000000", "#ffffff"].map(Value::from).to_vec(),
        (_, Range::Within(low, high)) => vec![number(low), number(high)],
        (_, Range::AtLeast(low)) => vec![number(low), number(f32::MAX)],
        (_, Range::Above(low)) => vec![number(low.next_up()), number(f32::MAX)],
        (_, Range::PowerOfTwo(low, high)) => [low, high].map(|side| Value::from(i64::from(side))).to_vec(),
        (_, Range::ZeroOr(low, high)) => [0, low, high].map(|count| Value::from(i64::from(count))).to_vec(),
        (_, Range::Rising(low)) => vec![pair(low, low.next_up()), pair(low, f32::MAX)],
        (_, Range::Span(low, high)) => vec![pair(low, high), pair(low, low), pair(high, high)],
        _ => Vec::new(),
    }
}

/// Returns whether a parameter has ends.
fn has_ends(definition: &Definition) -> bool {
    definition.section().is_none() && !ends(definition).is_empty()
}

/// A parameter of a preset at an end of its range.
struct Case {
    name: String,
    style: Style,
}

/// Returns parameters that the presets have at every end of their ranges: in the long tier all of them in each preset,
/// otherwise one of 32 in the first preset that has it.
fn cases() -> Vec<Case> {
    let all = parameters_of(&Style::kind(), None);
    let all: BTreeSet<String> = all
        .iter()
        .filter(|parameter| has_ends(&parameter.definition))
        .map(|parameter| random::bare(&parameter.key))
        .collect();
    let all: BTreeSet<String> = all.into_iter().step_by(if full() { 1 } else { 32 }).collect();
    let (mut cases, mut drawn) = (Vec::new(), BTreeSet::new());
    let mut refused: BTreeMap<String, String> = BTreeMap::new();
    for preset in names() {
        let text = preset_text(preset).unwrap();
        let document: DocumentMut = text.parse().unwrap();
        let mut of_preset = BTreeSet::new();
        for parameter in parameters_of(&Style::kind(), Some(document.as_item())) {
            let key = random::bare(&parameter.key);
            let is_left_out = !full() && (drawn.contains(&key) || !all.contains(&key));
            if is_left_out || !has_ends(&parameter.definition) {
                continue;
            }
            for end in ends(&parameter.definition) {
                let shown = end.to_string();
                // Other rules than the range may forbid it, for example that stops increase; and a layer that the preset
                // lacks may need more keys.
                let with = set::<Style>(preset, text, &parameter.key, end).map_err(|error| error.to_string());
                match with.and_then(|text| Style::parse(preset, &text).map_err(|error| error.to_string())) {
                    Ok(style) => {
                        of_preset.insert(key.clone());
                        cases.push(Case { name: format!("{preset} with {} = {shown}", parameter.key), style });
                    }
                    Err(error) => _ = refused.insert(key.clone(), error),
                }
            }
        }
        drawn.extend(of_preset);
    }
    let missing: Vec<_> = all.difference(&drawn).map(|key| (key, refused.get(key))).collect();
    assert!(missing.is_empty(), "no preset was drawn with {missing:?}");
    println!("{} parameters, {} cases", all.len(), cases.len());
    cases
}

#[test]
fn every_parameter_is_finite_at_both_ends_of_its_range() {
    let Some(land) = Land::of_spacing(SPACING_M) else { return };
    let cameras = if full() { vec![&ORDINARY, &EXTREME[2]] } else { vec![&ORDINARY] };
    let poses: Vec<_> = cameras.into_iter().map(|camera| (camera, land.pose(camera))).collect();
    let mut checked = Checked::new(land.world);
    for Case { name, style } in cases() {
        for (camera, pose) in &poses {
            checked.case(&format!("{name}, {}", camera.name), *pose, SIZE_PX, &style, &north_west());
        }
    }
    checked.finish("parameters at their ends");
}

#[test]
fn random_styles_are_finite() {
    let Some(land) = Land::of_spacing(SPACING_M) else { return };
    let cameras: Vec<_> = [&ORDINARY].into_iter().chain(&EXTREME).collect();
    let poses: Vec<_> = cameras.iter().map(|camera| land.pose(camera)).collect();
    let lights: Vec<_> = [("the sun of maps", north_west())].into_iter().chain(suns()).collect();
    let mut checked = Checked::new(land.world);
    let seeds = if full() { 200 } else { 1 };
    for seed in 0..seeds {
        let text = random::table::<Style>(&mut Random(seed), false).to_string();
        let style = Style::parse("x.toml", &text).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        // The ordinary view, and another one under another sun.
        let other = 1 + seed as usize % EXTREME.len();
        for (number, sun) in [(0, 0), (other, seed as usize % lights.len())] {
            let name = format!("random style {seed}, {}, {}", cameras[number].name, lights[sun].0);
            checked.case(&name, poses[number], SIZE_PX, &style, &lights[sun].1);
        }
    }
    checked.finish("random styles");
}
