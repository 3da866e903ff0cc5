//! Tests the inspector without a window: which widgets there are, their names, and what they do.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::{Edit, Inspector, apply};
use crate::studio::document::StyleDocument;
use crate::studio::rows::title;
use crate::style::controls::Control;
use crate::style::layers::layer_names;
use crate::style::parameters::{Setting, find, parameters_of};
use crate::style::{Style, names};

struct Bench {
    inspector: Inspector,
    document: StyleDocument,
    /// The messages of the last edits, errors included.
    said: Vec<String>,
    saves: usize,
}

/// Opens the inspector of a style in a window in which everything has room.
fn open(name: &str) -> Harness<'static, Bench> {
    let mut harness = open_in(name, egui::vec2(700.0, 16_000.0));
    harness.get_by_label("Open all").click();
    harness.run();
    harness
}

fn open_in(name: &str, size: egui::Vec2) -> Harness<'static, Bench> {
    open_with(Inspector::default(), name, size)
}

fn open_with(inspector: Inspector, name: &str, size: egui::Vec2) -> Harness<'static, Bench> {
    let document = StyleDocument::open(name).unwrap();
    let bench = Bench { inspector, document, said: Vec::new(), saves: 0 };
    let harness = Harness::builder().with_size(size).with_max_steps(40);
    let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
        |ui, bench: &mut Bench| {
            let steps = bench.document.step_names();
            for edit in bench.inspector.show(ui, &bench.document, steps).edits {
                bench.saves += usize::from(matches!(edit, Edit::Save));
                match apply(&mut bench.document, edit, Some("0.25")) {
                    Ok(said) => bench.said.extend(said),
                    Err(error) => bench.said.push(error.to_string()),
                }
            }
        },
        bench,
    );
    harness.run();
    harness
}

/// Returns the labels of all widgets that a user can operate, with their roles.
fn widgets(harness: &Harness<'_, Bench>) -> Vec<(Role, Option<String>)> {
    let roles = [
        Role::Button,
        Role::CheckBox,
        Role::ColorWell,
        Role::ComboBox,
        Role::Slider,
        Role::SpinButton,
        Role::TextInput,
    ];
    let nodes = harness.root().children_recursive();
    let nodes = nodes.map(|node| (node.accesskit_node().role(), node.accesskit_node().label()));
    nodes.filter(|(role, _)| roles.contains(role)).collect()
}

/// Returns the keys of the parameters that a style has, from the definitions and the text of the whole style.
fn keys(style: &Style) -> Vec<String> {
    let item = style.item().unwrap();
    let has_section = |key: &str| key.rsplit_once('.').is_none_or(|(section, _)| find(&item, section).is_some());
    let is_layer_of_style = |key: &str| {
        let first = key.split('.').next().unwrap();
        let kind = first.split('[').next().unwrap();
        !layer_names().any(|name| name == kind) || (0..style.layers.len()).any(|index| style.layers.key(index) == first)
    };
    let all = parameters_of(&Style::kind(), Some(&item)).into_iter();
    let all = all.filter(|parameter| parameter.definition.section().is_none());
    all.map(|parameter| parameter.key).filter(|key| has_section(key) && is_layer_of_style(key)).collect()
}

/// Returns the name that the widget of a parameter has, without the label.
fn section_of(key: &str) -> String {
    key.rsplit_once('.').map_or_else(|| "Style".to_owned(), |(section, _)| title(section))
}

/// Returns the keys of parameters that have no widget.
fn missing(harness: &Harness<'_, Bench>) -> Vec<String> {
    let widgets = widgets(harness);
    let labels: Vec<&str> = widgets.iter().filter_map(|(_, label)| label.as_deref()).collect();
    let document = &harness.state().document;
    let is_missing = |key: &String| {
        let Some(row) = document.row(key) else { return true };
        let wanted = format!("{}: {}", section_of(key), row.label);
        !labels.iter().any(|label| *label == wanted || label.starts_with(&format!("{wanted}, ")))
    };
    keys(document.style()).into_iter().filter(is_missing).collect()
}

#[test]
fn every_parameter_of_every_preset_has_a_widget_with_a_name() {
    let mut total = 0;
    for name in names() {
        let harness = open(name);
        let widgets = widgets(&harness);
        let unnamed: Vec<_> =
            widgets.iter().filter(|(_, label)| label.as_ref().is_none_or(|label| label.trim().is_empty())).collect();
        assert!(unnamed.is_empty(), "{name}: widgets without a name: {unnamed:?}");
        let labels: Vec<&str> = widgets.iter().filter_map(|(_, label)| label.as_deref()).collect();
        // A screen reader must be able to tell widgets apart.
        let mut counts = BTreeMap::new();
        labels.iter().for_each(|label| *counts.entry(*label).or_insert(0) += 1);
        let repeated: Vec<_> = counts.iter().filter(|(_, count)| **count > 1).collect();
        assert!(repeated.is_empty(), "{name}: {repeated:?}");
        let missing = missing(&harness);
        assert!(missing.is_empty(), "{name}: without a widget: {missing:?}");
        let keys = keys(harness.state().document.style());
        let distinct: BTreeSet<&String> = keys.iter().collect();
        assert_eq!(distinct.len(), keys.len());
        total += keys.len();
    }
    assert!(total > 27 * 40, "{total} parameters in all");
}

#[test]
fn a_number_is_typed_and_undone() {
    let mut harness = open("crosshatch");
    harness.get_by_label("Strokes: Width, number").click();
    harness.run();
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.get_by_label("Strokes: Width, number").type_text("4.5");
    harness.run();
    assert_eq!(harness.state().document.style().strokes().unwrap().width_px, 2.8, "it is not complete");
    harness.key_press(egui::Key::Enter);
    harness.run();
    assert_eq!(harness.state().document.style().strokes().unwrap().width_px, 4.5);
    harness.get_by_label("Undo").click();
    harness.run();
    assert_eq!(harness.state().document.style().strokes().unwrap().width_px, 2.8);
    assert_eq!(harness.state().said, ["Undo: Strokes: width 4.5 px"]);
    harness.get_by_label("Redo").click();
    harness.run();
    assert_eq!(harness.state().document.style().strokes().unwrap().width_px, 4.5);
}

#[test]
fn a_drag_of_a_slider_is_one_step() {
    let mut harness = open("crosshatch");
    let before = harness.state().document.text().to_owned();
    let rect = harness.get_by_label("Light: Wrap of light").rect();
    let at = |part: f32| egui::pos2(rect.left() + part * rect.width(), rect.center().y);
    harness.drag_at(at(0.2));
    harness.step();
    for step in 3..9 {
        harness.hover_at(at(step as f32 / 10.0));
        harness.step();
    }
    let dragged = harness.state().document.style().light.wrap;
    assert!((0.7..0.9).contains(&dragged), "{dragged}");
    harness.drop_at(at(0.8));
    harness.run();
    assert!(harness.state().document.style().light.wrap == dragged);
    harness.get_by_label("Undo").click();
    harness.run();
    assert_eq!(harness.state().document.text(), before);
    assert_eq!(harness.state().document.step_names()[0], None);
}

/// Returns whether a text that contains `words` is shown: while the mouse is over a widget, while it drags there, and after
/// it has moved again.
fn is_shown<S>(harness: &mut Harness<'_, S>, rect: egui::Rect, words: &str) -> [bool; 3] {
    let at = |part: f32| egui::pos2(rect.left() + part * rect.width(), rect.center().y);
    let rest = |harness: &mut Harness<'_, S>| {
        (0..6).for_each(|_| harness.step());
        harness.query_all_by_label_contains(words).next().is_some()
    };
    harness.hover_at(at(0.3));
    let before = rest(harness);
    harness.drag_at(at(0.3));
    harness.step();
    for step in 4..=6 {
        harness.hover_at(at(step as f32 / 10.0));
        harness.step();
    }
    let during = rest(harness);
    harness.drop_at(at(0.6));
    rest(harness);
    harness.hover_at(at(0.7));
    [before, during, rest(harness)]
}

#[test]
fn no_tooltip_covers_what_a_drag_changes() {
    let mut harness = open("crosshatch");
    let row = harness.state().document.row("light.wrap").unwrap();
    for (name, words) in [("Light: Wrap of light", row.definition.help), ("Density", Control::Density.help())] {
        let widgets = || harness.query_all_by_label(name);
        let slider = widgets().find(|node| node.accesskit_node().role() == Role::Slider);
        let rect = slider.unwrap().rect();
        let words = words.lines().next().unwrap();
        assert_eq!(is_shown(&mut harness, rect, words), [true, false, true], "{name}: {words}");
        harness.hover_at(egui::pos2(1.0, 1.0));
        harness.run();
    }
    // Planted: egui's own tooltips stay during a drag within the widget.
    let mut value = 0.0;
    let harness = Harness::builder().with_context_setup(crate::window::panel::set_up);
    let mut harness =
        harness.build_ui(|ui| _ = ui.add(egui::Slider::new(&mut value, 0.0..=1.0)).on_hover_text("words"));
    harness.run();
    let rect = harness.root().children_recursive().find(|node| node.accesskit_node().role() == Role::Slider);
    let rect = rect.unwrap().rect();
    assert_eq!(is_shown(&mut harness, rect, "words"), [true, true, true]);
}

#[test]
fn backspace_restores_the_default() {
    let mut harness = open("crosshatch");
    harness.get_by_label("Light: Contrast").hover();
    harness.run();
    harness.key_press(egui::Key::Backspace);
    harness.run();
    assert_eq!(harness.state().document.style().light.contrast, 1.0);
    // While a text is typed, Backspace deletes a letter.
    harness.get_by_label("Style: Name").click();
    harness.run();
    harness.key_press(egui::Key::End);
    harness.key_press(egui::Key::Backspace);
    harness.key_press(egui::Key::Enter);
    harness.run();
    assert_eq!(harness.state().document.style().name, "crosshatc");
    assert_eq!(harness.state().document.style().light.contrast, 1.0);
}

#[test]
fn the_menu_of_a_widget_pastes() {
    let mut harness = open("crosshatch");
    harness.get_by_label("Light: Wrap of light").click_secondary();
    harness.run();
    harness.get_by_label("Paste value").click();
    harness.run();
    assert_eq!(harness.state().document.style().light.wrap, 0.25);
}

#[test]
fn a_search_shows_what_it_finds() {
    let mut harness = open("crosshatch");
    harness.get_by_label("Search parameters").click();
    harness.run();
    harness.get_by_label("Search parameters").type_text("shadow");
    harness.run();
    let labels: Vec<String> = widgets(&harness).into_iter().filter_map(|(_, label)| label).collect();
    assert!(labels.iter().any(|label| label == "Light: Cast shadows"), "{labels:?}");
    // The count of widgets notices what is left out.
    let missing = missing(&harness);
    assert!(missing.len() > 40 && missing.iter().any(|key| key == "light.wrap"), "{missing:?}");
    assert!(!missing.iter().any(|key| key == "light.shadow"), "{missing:?}");
    assert!(!labels.iter().any(|label| label.starts_with("Strokes: Width")), "{labels:?}");
}

#[test]
fn layers_have_buttons() {
    let mut harness = open("crosshatch");
    harness.get_by_label("Hatching: Hide").click();
    harness.run();
    assert!(harness.state().document.drawn().hatching().is_none() && !harness.state().document.is_edited());
    harness.get_by_label("Strokes: Lower").click();
    harness.run();
    let kinds = |harness: &Harness<'_, Bench>| -> Vec<&'static str> {
        harness.state().document.style().layers.iter().map(crate::style::Layer::kind).collect()
    };
    assert_eq!(kinds(&harness), ["hatching", "drainage", "water", "strokes", "rims"]);
    harness.get_by_label("Water: Remove").click();
    harness.run();
    assert_eq!(kinds(&harness), ["hatching", "drainage", "strokes", "rims"]);
    harness.get_by_label("Add Focus").click();
    harness.run();
    assert!(harness.state().document.style().focus.is_some());
    assert!(harness.state().said.is_empty(), "{:?}", harness.state().said);
}

#[test]
fn a_selected_layer_is_moved_into_view() {
    let mut harness = open_in("crosshatch", egui::vec2(700.0, 540.0));
    let is_visible = |harness: &Harness<'_, Bench>, name: &str| {
        let rect = harness.query_by_label(name).map(|node| node.rect());
        rect.is_some_and(|rect| rect.top() > 0.0 && rect.bottom() < 540.0)
    };
    assert!(!is_visible(&harness, "Light: Wrap of light"));
    for (key, name) in [("light", "Light: Wrap of light"), ("hatching", "Hatching: Hide"), ("strokes", "Strokes: Hide")]
    {
        harness.state_mut().inspector.select(key.to_owned());
        harness.run();
        assert!(is_visible(&harness, name), "{key}");
        assert_eq!(harness.state().inspector.selected(), Some(key));
    }
    assert!(!is_visible(&harness, "Light: Wrap of light"), "another section is in view");
    // The inspector is opened for it.
    let mut inspector = Inspector::default();
    inspector.select("light".to_owned());
    assert!(is_visible(&open_with(inspector, "crosshatch", egui::vec2(700.0, 540.0)), "Light: Wrap of light"));
    // A search would hide the section.
    harness.get_by_label("Search parameters").click();
    harness.run();
    harness.get_by_label("Search parameters").type_text("no such parameter");
    harness.run();
    assert!(!is_visible(&harness, "Hatching: Hide"));
    harness.state_mut().inspector.select("hatching".to_owned());
    harness.run();
    assert!(is_visible(&harness, "Hatching: Hide"));
}

#[test]
fn recipes_have_pictures_and_a_wrong_one_has_none() {
    let mut harness = open("crosshatch");
    let picture = |harness: &mut Harness<'_, Bench>, words: &str| {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(60) {
            harness.run();
            if harness.query_all_by_label(words).next().is_some() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    };
    let row = |harness: &Harness<'_, Bench>, key: &str| {
        let rows = harness.state().document.sections().iter().flat_map(|section| section.rows.clone());
        rows.filter(|row| row.definition.key == key).find_map(|row| row.value?.as_str().map(str::to_owned)).unwrap()
    };
    let [marks, texture] = [row(&harness, "marks"), row(&harness, "texture")];
    assert!(picture(&mut harness, &format!("{marks}, from light to dark")), "{marks}");
    assert!(picture(&mut harness, &format!("{texture}, from heavy to light pressure")), "{texture}");
    // Planted: no recipe has this name.
    assert!(harness.query_by_label("no such marks, from light to dark").is_none());
}

#[test]
fn the_menu_copies_the_option_of_the_command_line() {
    let mut harness = open("ink");
    let sections = harness.state().document.sections();
    let rows = sections.iter().flat_map(|section| section.rows.iter().map(move |row| (section, row)));
    let (section, row) = rows.into_iter().find(|(_, row)| row.key == "tone.steps").unwrap();
    let name = format!("{}: {}", section.title, row.label);
    harness.get_by_label(&name).click_secondary();
    harness.run();
    harness.get_by_label("Copy for the command line").click();
    let copied = (0..4).find_map(|_| {
        harness.step();
        harness.output().platform_output.commands.iter().find_map(|command| match command {
            egui::OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        })
    });
    assert_eq!(copied.as_deref(), Some("--set=tone.steps=3"));
}

#[test]
fn a_search_finds_labels() {
    let mut harness = open("crosshatch");
    harness.get_by_label("Search parameters").click();
    harness.run();
    // Neither the key nor the help of `strokes.faintest` has all of these words.
    harness.get_by_label("Search parameters").type_text("ink in full haze");
    harness.run();
    assert!(harness.query_by_label("Strokes: Ink in full haze").is_some());
    assert!(harness.query_by_label("Strokes: Width").is_none());
}

#[test]
fn zero_is_shown_as_a_word_and_is_typed_as_one() {
    let mut harness = open("crosshatch");
    let name = "Strokes: Least length to width, number";
    let shown = |harness: &Harness<'_, Bench>| harness.get_by_label(name).accesskit_node().value();
    let slender = |harness: &Harness<'_, Bench>| harness.state().document.style().strokes().unwrap().slender;
    let type_in = |harness: &mut Harness<'_, Bench>, text: &str| {
        harness.get_by_label(name).click();
        harness.run();
        harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        harness.get_by_label(name).type_text(text);
        harness.key_press(egui::Key::Enter);
        harness.run();
    };
    type_in(&mut harness, "12");
    assert_eq!((slender(&harness), shown(&harness).as_deref()), (12.0, Some("12.0")));
    type_in(&mut harness, "no limit");
    assert_eq!((slender(&harness), shown(&harness).as_deref()), (0.0, Some("no limit")));
    assert_eq!(harness.state().document.step_names()[0], Some("Strokes: least length to width no limit"));
    // A number of another parameter stays a number, although it is 0.
    assert_ne!(harness.get_by_label("Strokes: Wobble, number").accesskit_node().value().as_deref(), Some("none"));
    // Planted: another word is not a number, and changes nothing.
    type_in(&mut harness, "9");
    type_in(&mut harness, "automatic");
    assert_eq!(slender(&harness), 9.0);
}
