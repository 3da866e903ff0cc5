//! Tests the gallery without a window: what it shows, and what clicks do.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::thumbnails::Thumbnails;
use super::{Choice, Gallery, families};
use crate::studio::favourites::Favourites;
use crate::style::families::Family;
use crate::style::names;
use crate::window::settings::Styles;

struct Bench {
    gallery: Gallery,
    styles: Styles,
    favourites: Favourites,
    thumbnails: Thumbnails,
    choices: Vec<Choice>,
}

fn open() -> Harness<'static, Bench> {
    let (styles, present) = Styles::with("ink").unwrap();
    let gallery = Gallery { is_open: true, ..Gallery::default() };
    let favourites = Favourites::of_nobody();
    let bench = Bench { gallery, styles, favourites, thumbnails: Thumbnails::default(), choices: Vec::new() };
    let harness = Harness::builder().with_size(egui::vec2(900.0, 1400.0)).with_max_steps(40);
    let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
        move |ui, bench: &mut Bench| {
            let Bench { gallery, styles, favourites, thumbnails, choices } = bench;
            choices.extend(gallery.show(ui.ctx(), styles, favourites, thumbnails, present));
        },
        bench,
    );
    harness.run();
    harness
}

fn place(harness: &Harness<'_, Bench>, name: &str) -> usize {
    harness.state().styles.place_of(name).unwrap()
}

#[test]
fn every_preset_has_a_cell_and_baselines_come_last() {
    let harness = open();
    let bottom = |name: &str| harness.get_by_label(&format!("Style {name}")).rect().top();
    let last = names().into_iter().filter(|name| Family::of(name) != Family::Baseline).map(bottom);
    let last = last.fold(0.0, f32::max);
    for name in ["plain", "sobel", "roystan"] {
        assert!(bottom(name) > last, "{name} at {}, others to {last}", bottom(name));
    }
    let order: Vec<Family> = families(&harness.state().styles).into_iter().map(|(family, _)| family).collect();
    assert_eq!(order, [Family::Line, Family::Hatching, Family::Map, Family::Color, Family::Baseline]);
    // Planted: a style that there is not has no cell.
    assert!(harness.query_by_label("Style no such").is_none());
}

#[test]
fn a_click_chooses_and_a_menu_sets_favourites() {
    let mut harness = open();
    harness.get_by_label("Style wash").click();
    harness.run();
    assert_eq!(harness.state().choices, [Choice::Style(place(&harness, "wash"))]);
    assert_eq!(harness.state().gallery.hovered(), Some(place(&harness, "wash")));
    harness.get_by_label("Style night").click_secondary();
    harness.run();
    harness.get_by_label("Favourite 3").click();
    harness.run();
    assert_eq!(harness.state().choices[1..], [Choice::Favourite(place(&harness, "night"), Some(2))]);
}
