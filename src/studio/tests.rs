//! Tests documents: values, layers, history and what is drawn.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod controls;
mod drawn;
mod extends;
mod files;

use std::collections::BTreeMap;

use toml_edit::{Array, Value};

use super::document::StyleDocument;
use super::rows::{Place, Row};
use crate::style::layers::LayerEdit;
use crate::style::parameters::ValueKind;
use crate::style::set::{SetValue, with_values};
use crate::style::{Layer, Style, names, preset_text};
use crate::tests::common::full;

fn open(name: &str) -> StyleDocument {
    StyleDocument::open(name).unwrap()
}

/// Returns the presets that a test of documents opens: in the long tier all of them, otherwise one for each kind of
/// layers, tones and sections.
fn presets() -> Vec<&'static str> {
    const EACH_KIND: [&str; 8] =
        ["plain", "pen", "hachures", "engraving", "panorama", "tone-lines", "relief", "crosshatch-curvature"];
    if full() { names() } else { EACH_KIND.to_vec() }
}

fn kinds(style: &Style) -> Vec<&'static str> {
    style.layers.iter().map(Layer::kind).collect()
}

/// Returns all values of a document by their keys.
fn values(document: &StyleDocument) -> BTreeMap<String, Option<String>> {
    let rows = document.sections().iter().flat_map(|section| &section.rows);
    let text = |row: &Row| row.value.as_ref().map(|value| value.to_string().trim().to_owned());
    rows.map(|row| (row.key.clone(), text(row))).collect()
}

#[test]
fn values_alone_are_a_command_line_and_other_edits_are_not() {
    let mut random = Random(7);
    for name in presets() {
        let mut document = open(name);
        assert_eq!(document.set_values(), Some(Vec::new()), "{name}");
        let keys: Vec<Row> = document.sections().iter().flat_map(|section| section.rows.clone()).collect();
        for _ in 0..6 {
            let row = &keys[random.below(keys.len())];
            let value = random.value(row);
            // An edit that is not allowed changes nothing.
            let _ = document.set(&row.key, value);
        }
        if !document.is_edited() {
            continue;
        }
        let Some(values) = document.set_values() else {
            // A text that looks like another value.
            continue;
        };
        let pairs: Vec<SetValue> = values.iter().map(|value| value.to_string().parse().unwrap()).collect();
        let preset = Style::parse(name, preset_text(name).unwrap()).unwrap();
        let text = with_values(name, preset_text(name).unwrap(), &preset, &pairs).unwrap();
        assert_eq!(&Style::parse(name, &text).unwrap(), document.style(), "{name}: {values:?}");
        // Planted: without one of them the style is another.
        if let Some((_, rest)) = pairs.split_first() {
            let text = with_values(name, preset_text(name).unwrap(), &preset, rest).unwrap();
            assert!(Style::parse(name, &text).map_or(true, |style| style != *document.style()), "{name}: {values:?}");
        }
    }
    let mut document = open("ink");
    document.edit_layers(&LayerEdit::Remove(0)).unwrap();
    assert_eq!(document.set_values(), None, "no value removes a layer");
}

/// A pseudorandom number generator (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end as u64) as usize
    }

    /// Returns a value of a parameter, most often one that is allowed.
    fn value(&mut self, row: &Row) -> Value {
        let part = self.below(1001) as f32 / 1000.0;
        let [low, high] = row.definition.range.ends();
        let (low, high) = (low.unwrap_or(-10.0), high.unwrap_or(100.0));
        let number = low + (high - low) * part * if self.below(20) == 0 { 2.0 } else { 1.0 };
        let color = |random: &mut Self| format!("#{:06x}", random.below(1 << 24));
        match &row.definition.kind {
            ValueKind::Number => f64::from(number).into(),
            ValueKind::Whole => (number as i64).into(),
            ValueKind::Flag => (self.below(2) == 0).into(),
            ValueKind::Color => color(self).into(),
            ValueKind::Pair => [f64::from(low), f64::from(number)].into_iter().collect::<Array>().into(),
            ValueKind::Choice(choices) => choices[self.below(choices.len())].name.as_str().into(),
            ValueKind::Text => ["pen", "brush", "line", "\"'#\n"][self.below(4)].into(),
            _ => (0..self.below(5)).map(|_| color(self)).collect::<Array>().into(),
        }
    }

    fn layer_edit(&mut self, document: &StyleDocument) -> LayerEdit {
        let count = document.style().layers.len() + 1;
        let sections = document.sections();
        let section = &sections[self.below(sections.len())];
        match (self.below(7), &section.place) {
            (0, _) => LayerEdit::Remove(self.below(count)),
            (1, _) => LayerEdit::Duplicate(self.below(count)),
            (2, _) => LayerEdit::Move(self.below(count), self.below(count)),
            (3, _) => LayerEdit::Add(["cuts", "strokes", "water", "rows", "rims"][self.below(5)]),
            (_, Place::Optional) => LayerEdit::RemoveSection(section.key.clone()),
            (_, Place::Absent) => LayerEdit::AddSection(section.key.clone()),
            (4, Place::Entry { list, index }) => LayerEdit::RemoveEntry(list.clone(), *index),
            (_, Place::Entry { list, .. }) => LayerEdit::AddEntry(list.clone()),
            _ => LayerEdit::Move(self.below(count), self.below(count)),
        }
    }
}

#[test]
fn a_thousand_random_edits_are_what_the_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(40);
    let (mut taken, mut refused, mut layered) = (0, 0, 0);
    for name in presets() {
        let mut document = open(name);
        for step in 0..40 {
            let before = (document.text().to_owned(), document.style().clone());
            let done = match random.below(10) {
                0 => {
                    layered += 1;
                    let edit = random.layer_edit(&document);
                    document.edit_layers(&edit)
                }
                1 => {
                    document.undo();
                    Ok(())
                }
                2 => {
                    document.redo();
                    Ok(())
                }
                3 => {
                    let rows: Vec<String> = values(&document).into_keys().collect();
                    document.restore(&rows[random.below(rows.len())])
                }
                _ => {
                    let rows: Vec<Row> = document.sections().iter().flat_map(|section| section.rows.clone()).collect();
                    let row = &rows[random.below(rows.len())];
                    let value = random.value(row);
                    let values_before = values(&document);
                    let done = document.set(&row.key, value.clone());
                    if done.is_ok() {
                        check_set(&document, row, &value, values_before);
                    }
                    document.release();
                    done
                }
            };
            match done {
                Ok(()) => taken += 1,
                // A refused edit changes nothing, and its error gives the reason in one line.
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().contains('\n'), "{error}");
                    assert_eq!((document.text(), document.style()), (before.0.as_str(), &before.1));
                }
            }
            assert_eq!(document.style(), &Style::parse(name, document.text()).unwrap(), "{name} {step}");
        }
        let mut saved = document.save_as(folder.path().join(name).to_str().unwrap(), None).unwrap();
        let path = saved.path().unwrap().to_owned();
        let read = Style::read(&path).unwrap();
        assert_eq!(saved.style(), &read);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), saved.text());
        // Only the name and the file differ from what was edited.
        let expected = Style { name: read.name.clone(), files: read.files.clone(), ..document.style().clone() };
        assert_eq!(expected, read);
        saved.save().unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), saved.text());
    }
    // The fast tier has a quarter of the presets.
    let [most, some, few] = [600, 60, 20].map(|least| if full() { least } else { least / 4 });
    assert!(taken > most && refused > few && layered > some, "{taken} taken, {refused} refused, {layered} layers");
}

/// Checks that only one parameter has changed, and that it has the value.
fn check_set(document: &StyleDocument, row: &Row, value: &Value, mut before: BTreeMap<String, Option<String>>) {
    let mut after = values(document);
    // A kind of tone or a detector decides which other parameters there are, and the order of sets follows `from`.
    if row.key == "tone.kind" || row.key.ends_with("].from") {
        return;
    }
    // After an edit of `from`, a file may list its sets in another order than the style has them.
    let lines = document.text().lines().filter_map(|line| line.trim().strip_prefix("from = "));
    let froms: Vec<f64> = lines.filter_map(|from| from.parse().ok()).collect();
    if row.key.contains(".sets[") && !froms.is_sorted() {
        return;
    }
    let text = after.remove(&row.key).unwrap().unwrap();
    before.remove(&row.key);
    let is_same = match (value.as_float(), text.parse::<f64>()) {
        (Some(number), Ok(read)) => (number as f32 - read as f32).abs() <= 1e-6 * number.abs() as f32,
        _ => match row.definition.kind {
            ValueKind::Pair | ValueKind::List(_) | ValueKind::Text => true,
            _ => text.to_lowercase() == value.to_string().to_lowercase(),
        },
    };
    assert!(is_same, "{}: {value} became {text}", row.key);
    assert_eq!(after, before, "{} changed something else", row.key);
}

#[test]
fn every_step_is_undone_and_redone() {
    let (styles, steps) = if full() { (&["ink", "wash", "crosshatch"][..], 130) } else { (&["crosshatch"][..], 60) };
    for name in styles {
        let mut document = open(name);
        let mut random = Random(7);
        let mut texts = vec![document.text().to_owned()];
        while texts.len() < steps {
            let rows: Vec<Row> = document.sections().iter().flat_map(|section| section.rows.clone()).collect();
            let row = &rows[random.below(rows.len())];
            let value = random.value(row);
            let done = document.set(&row.key, value);
            document.release();
            if done.is_ok() && texts.last().unwrap() != document.text() {
                texts.push(document.text().to_owned());
            }
        }
        for text in texts.iter().rev().skip(1) {
            document.undo().unwrap();
            assert_eq!(document.text(), text);
        }
        assert!(document.undo().is_none() && !document.is_edited());
        for text in &texts[1..] {
            document.redo().unwrap();
            assert_eq!(document.text(), text);
        }
        assert!(document.redo().is_none());
        document.revert().unwrap();
        assert_eq!(document.text(), preset_text(name).unwrap());
        document.undo().unwrap();
        assert_eq!(document.text(), texts.last().unwrap());
    }
}

#[test]
fn steps_have_names_and_a_drag_is_one() {
    let mut document = open("crosshatch");
    for tenths in 10..20 {
        document.set("strokes.width_px", f64::from(tenths) / 10.0).unwrap();
    }
    document.release();
    document.set("strokes.width_px", 3.0).unwrap();
    document.edit_layers(&LayerEdit::Move(0, 1)).unwrap();
    let mut names = Vec::new();
    while let Some(name) = document.undo() {
        names.push(name);
    }
    assert_eq!(names, ["Raised layer: Hatching", "Strokes: width 3.0 px", "Strokes: width 1.9 px"]);
    assert_eq!(document.step_names(), [None, Some("Strokes: width 1.9 px")]);
    assert!(document.set("strokes.width_px", 1000.0).is_err());
    assert_eq!(document.step_names()[1], Some("Strokes: width 1.9 px"), "what is refused is no step");
}

#[test]
fn a_default_is_restored_and_comments_stay() {
    let mut document = open("crosshatch");
    let text = document.text().to_owned();
    // A comment is above this key.
    document.restore("strokes.crowd").unwrap();
    assert_eq!(document.text(), text.replace("crowd = 0.07", "crowd = 1.0"));
    document.restore("strokes.taper_px").unwrap();
    assert_eq!(document.text(), text.replace("crowd = 0.07", "crowd = 1.0").replace("taper_px = 24.0\n", ""));
    assert_eq!(document.style().strokes().unwrap().taper_px, 0.0);
    // A required parameter has no default.
    let error = document.restore("strokes.width_px").unwrap_err().to_string();
    assert!(error.contains("width_px") && document.style().strokes().unwrap().width_px == 2.8, "{error}");
    // A parameter that is not given already has its default.
    let before = document.text().to_owned();
    document.restore("paper.margin_px").unwrap();
    document.restore("strokes.crease_deg").unwrap();
    assert_eq!(document.text(), before);
}

#[test]
fn pasted_texts_are_values() {
    let mut document = open("crosshatch");
    document.set_text("strokes.width_px", " 3.5 ").unwrap();
    document.set_text("strokes.ink", "#abcdef").unwrap();
    document.set_text("paper.color", "\"#fedcba\"").unwrap();
    document.set_text("light.wrap", "0.5").unwrap();
    let strokes = document.style().strokes().unwrap();
    assert_eq!((strokes.width_px, strokes.ink.to_string().as_str()), (3.5, "#abcdef"));
    assert_eq!(document.style().paper.color.to_string(), "#fedcba");
    for (key, text) in [("strokes.width_px", "wide"), ("strokes.ink", "red-ish"), ("strokes.width_px", "")] {
        assert!(document.set_text(key, text).is_err(), "{key} = {text}");
    }
}

#[test]
fn layers_are_moved_copied_and_removed() {
    let mut document = open("crosshatch");
    assert_eq!(kinds(document.style()), ["hatching", "drainage", "water", "rims", "strokes"]);
    let comment = "# Thins out crowded strokes; far ranges keep their skylines.\ncrowd = 0.07\n";
    document.edit_layers(&LayerEdit::Move(4, 0)).unwrap();
    assert_eq!(kinds(document.style()), ["strokes", "hatching", "drainage", "water", "rims"]);
    assert!(document.text().contains(comment) && document.style().hatching().unwrap().sets.len() == 3);
    document.edit_layers(&LayerEdit::Add("cuts")).unwrap();
    document.edit_layers(&LayerEdit::Duplicate(2)).unwrap();
    let copied = kinds(document.style());
    assert_eq!(copied, ["strokes", "hatching", "cuts", "cuts", "drainage", "water", "rims"]);
    // The second layer of a kind has values of its own.
    document.set("cuts[1].form_px", 99.0).unwrap();
    let forms: Vec<f32> = document
        .style()
        .layers
        .iter()
        .filter_map(|layer| match layer {
            Layer::Cuts(cuts) => Some(cuts.form_px),
            _ => None,
        })
        .collect();
    assert!(forms[0] < 99.0 && forms[1] == 99.0, "{forms:?}");
    // A second layer of hatching is not allowed, and neither is a layer that is not there.
    let before = document.text().to_owned();
    let error = document.edit_layers(&LayerEdit::Duplicate(1)).unwrap_err().to_string();
    assert!(error.contains("at most one layer"), "{error}");
    assert!(document.edit_layers(&LayerEdit::Remove(7)).is_err());
    assert!(document.edit_layers(&LayerEdit::Move(0, 7)).is_err());
    assert_eq!(document.text(), before);
    document.edit_layers(&LayerEdit::Remove(0)).unwrap();
    assert_eq!(kinds(document.style()), ["hatching", "cuts", "cuts", "drainage", "water", "rims"]);
    while document.undo().is_some() {}
    assert_eq!(document.text(), preset_text("crosshatch").unwrap());
}

#[test]
fn moved_layers_keep_their_values_in_every_preset() {
    for name in presets() {
        let mut document = open(name);
        let count = document.style().layers.len();
        let before: Vec<Layer> = document.style().layers.to_vec();
        for (from, to) in [(0, count - 1), (count - 1, 0), (count / 2, 0)] {
            document.edit_layers(&LayerEdit::Move(from, to)).unwrap();
        }
        let mut expected = before;
        let moved = expected.remove(count / 2);
        expected.insert(0, moved);
        assert_eq!(document.style().layers.to_vec(), expected, "{name}: {}", document.text());
        let comments = |text: &str| text.lines().filter(|line| line.contains('#')).count();
        assert_eq!(comments(document.text()), comments(preset_text(name).unwrap()), "{name}");
    }
}

#[test]
fn sections_and_entries_come_and_go() {
    let mut document = open("crosshatch");
    let focus = || LayerEdit::AddSection("focus".to_owned());
    document.edit_layers(&focus()).unwrap();
    assert!(document.style().focus.is_some());
    document.edit_layers(&LayerEdit::AddSection("tone.ramp".to_owned())).unwrap();
    document.edit_layers(&LayerEdit::AddEntry("hatching.sets".to_owned())).unwrap();
    assert_eq!(document.style().hatching().unwrap().sets.len(), 4);
    document.set("hatching.sets[3].from", 0.75).unwrap();
    document.edit_layers(&LayerEdit::RemoveEntry("hatching.sets".to_owned(), 0)).unwrap();
    let from: Vec<f32> = document.style().hatching().unwrap().sets.iter().map(|set| set.from).collect();
    assert_eq!(from, [0.35, 0.55, 0.75]);
    document.edit_layers(&LayerEdit::RemoveSection("focus".to_owned())).unwrap();
    assert!(document.style().focus.is_none());
    assert!(document.edit_layers(&LayerEdit::RemoveSection("focus".to_owned())).is_err());
    assert!(document.edit_layers(&LayerEdit::RemoveEntry("hatching.sets".to_owned(), 3)).is_err());
}

#[test]
fn hidden_layers_are_not_drawn_and_no_edit() {
    let mut document = open("crosshatch");
    document.toggle_hidden("hatching");
    assert_eq!(kinds(&document.drawn()), ["drainage", "water", "rims", "strokes"]);
    assert!(!document.is_edited() && document.step_names() == [None, None]);
    document.toggle_solo("strokes");
    assert_eq!(kinds(&document.drawn()), ["strokes"]);
    document.toggle_solo("strokes");
    assert_eq!(kinds(&document.drawn()), ["drainage", "water", "rims", "strokes"]);
    document.toggle_hidden("hatching");
    assert_eq!(document.drawn(), *document.style());
    // A layer that is removed while it is alone must not leave an empty picture.
    document.toggle_solo("strokes");
    document.edit_layers(&LayerEdit::Remove(4)).unwrap();
    assert_eq!(kinds(&document.drawn()), ["hatching", "drainage", "water", "rims"]);
}

#[test]
fn both_forms_of_a_file_are_edited() {
    let old = "name = \"x\" # mine\ndescription = \"y\"\n[strokes] # thin\nwidth_px = 2.0\n[tone]\nkind = \"plain\"\n";
    let inline = "name = \"x\"\ndescription = \"y\"\nlayers = [{ kind = \"strokes\", width_px = 2.0 }]\n[tone]\nkind = \"plain\"\n";
    let folder = tempfile::tempdir().unwrap();
    for (number, text) in [old, inline].into_iter().enumerate() {
        let path = folder.path().join(format!("{number}.toml"));
        crate::file::atomic::write(&path, text.as_bytes()).unwrap();
        let mut document = open(path.to_str().unwrap());
        document.set("strokes.width_px", 5.0).unwrap();
        assert_eq!(document.text(), text.replace("2.0", "5.0"));
        document.edit_layers(&LayerEdit::Move(1, 0)).unwrap();
        assert_eq!(kinds(document.style()), ["strokes", "rims"]);
        assert_eq!(document.style().strokes().unwrap().width_px, 5.0);
        assert_eq!(document.text().contains("# thin"), number == 0);
    }
}
