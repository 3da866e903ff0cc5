//! Tests the docked panels without a window.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

use std::collections::BTreeMap;

use super::*;

struct Bench {
    dock: Dock,
    /// The parts of the window that the contents of panels had in the last frame.
    rects: BTreeMap<Pane, Rect>,
}

fn open(dock: Dock, size: [f32; 2]) -> Harness<'static, Bench> {
    let harness = Harness::builder().with_size(egui::vec2(size[0], size[1])).with_max_steps(40);
    let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
        |ui, Bench { dock, rects }: &mut Bench| {
            rects.clear();
            dock.show(ui, &mut |ui, pane| {
                rects.insert(pane, ui.max_rect().intersect(ui.clip_rect()));
                ui.label(format!("content of {}", pane.title()));
            });
        },
        Bench { dock, rects: BTreeMap::new() },
    );
    harness.run();
    harness
}

fn width(harness: &Harness<'_, Bench>, pane: Pane) -> f32 {
    harness.state().rects[&pane].width()
}

fn resize(harness: &mut Harness<'_, Bench>, width: f32) {
    harness.set_size(egui::vec2(width, 540.0));
    harness.run();
}

#[test]
fn panels_keep_their_width_when_the_window_shrinks_and_grows() {
    let mut harness = open(Dock::default(), [1280.0, 800.0]);
    harness.state_mut().dock.set_shown(Pane::Style, true);
    harness.run();
    let before = [Pane::Flight, Pane::Style].map(|pane| width(&harness, pane));
    assert!(before[0] >= 240.0 && before[1] >= 320.0, "{before:?}");
    resize(&mut harness, 960.0);
    assert_eq!([Pane::Flight, Pane::Style].map(|pane| width(&harness, pane)), before);
    resize(&mut harness, 300.0);
    assert!(width(&harness, Pane::Flight) < 0.5 * before[0], "{}", width(&harness, Pane::Flight));
    resize(&mut harness, 1.0);
    resize(&mut harness, 1600.0);
    let after = [Pane::Flight, Pane::Style].map(|pane| width(&harness, pane));
    assert!((0..2).all(|side| (after[side] - before[side]).abs() < 1.0), "{before:?}, then {after:?}");
}

#[test]
fn a_border_is_dragged() {
    let mut harness = open(Dock::default(), [1280.0, 800.0]);
    let before = width(&harness, Pane::Flight);
    let border = harness.state().rects[&Pane::Flight].right() + f32::from(MARGIN);
    let at = |x: f32| egui::pos2(x, 400.0);
    assert!(harness.state().dock.is_over(at(border + 2.0)), "the border takes the mouse");
    harness.hover_at(at(border));
    harness.run();
    harness.drag_at(at(border));
    harness.step();
    for step in 1..=6 {
        harness.hover_at(at(border + 10.0 * step as f32));
        harness.step();
    }
    harness.drop_at(at(border + 60.0));
    harness.run();
    let after = width(&harness, Pane::Flight);
    assert!((after - before - 60.0).abs() < 3.0, "{before}, then {after}");
    // What the user has chosen stays over a small window, and over a restart.
    resize(&mut harness, 200.0);
    resize(&mut harness, 1280.0);
    assert!((width(&harness, Pane::Flight) - after).abs() < 1.0);
    let text = harness.state().dock.text().unwrap();
    let again = open(Dock::of_text(&text).unwrap(), [1000.0, 600.0]);
    assert!((width(&again, Pane::Flight) - after).abs() < 1.0);
}

#[test]
fn a_closed_panel_comes_back_to_its_place() {
    let mut harness = open(Dock::default(), [1280.0, 800.0]);
    assert!(harness.query_by_label("content of Flight").is_some());
    let at = harness.state().rects[&Pane::Flight].center();
    assert!(harness.state().dock.is_over(at) && !harness.state().dock.is_over(egui::pos2(640.0, 400.0)));
    harness.get_by_label("Close").click();
    harness.run();
    assert!(!harness.state().dock.is_shown(Pane::Flight) && !harness.state().dock.is_over(at));
    assert!(harness.query_by_label("content of Flight").is_none());
    harness.state_mut().dock.toggle(Pane::Flight);
    harness.run();
    assert_eq!(harness.state().rects[&Pane::Flight].center(), at);
    // Two panels at one place are tabs; the requested one is in front.
    harness.state_mut().dock.toggle(Pane::Inside);
    harness.run();
    assert!(!harness.state().dock.is_shown(Pane::Flight) && harness.state().dock.is_shown(Pane::Inside));
    harness.get_by_label("Flight").click();
    harness.run();
    assert!(harness.state().dock.is_shown(Pane::Flight));
    harness.state_mut().dock.toggle(Pane::Style);
    harness.run();
    let window = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1280.0, 800.0));
    let free = harness.state().dock.free(window);
    assert!(free.left() > 250.0 && free.right() < 960.0 && free.height() == 800.0, "{free}");
}

#[test]
fn the_camera_path_is_below_the_picture_and_keeps_its_height() {
    let mut harness = open(Dock::default(), [1280.0, 800.0]);
    harness.state_mut().dock.toggle(Pane::Path);
    harness.run();
    let window = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1280.0, 800.0));
    let area = |harness: &Harness<'_, Bench>| harness.state().rects[&Pane::Path];
    let (before, flight) = (area(&harness), width(&harness, Pane::Flight));
    assert!(before.height() > 150.0 && before.height() < 200.0 && before.width() > 900.0, "{before}");
    assert!(harness.state().dock.is_over_pane(Pane::Path, before.center()));
    assert!(!harness.state().dock.is_over_pane(Pane::Path, egui::pos2(700.0, 300.0)));
    assert!(!harness.state().dock.is_over(egui::pos2(700.0, 300.0)), "the picture above it");
    let free = harness.state().dock.free(window);
    assert!(free.bottom() < 620.0 && free.bottom() > 560.0 && free.left() > 250.0 && free.right() == 1280.0, "{free}");
    for (size, is_same) in
        [([960.0, 540.0], true), ([960.0, 200.0], false), ([1.0, 1.0], false), ([1280.0, 800.0], true)]
    {
        harness.set_size(egui::vec2(size[0], size[1]));
        harness.run();
        if is_same {
            assert!((area(&harness).height() - before.height()).abs() < 1.0, "{size:?}: {}", area(&harness));
            assert!((width(&harness, Pane::Flight) - flight).abs() < 1.0, "{size:?}");
        }
    }
    // Its upper border is dragged.
    let at = |y: f32| egui::pos2(800.0, y);
    let border = before.top() - f32::from(MARGIN) - TITLE_HEIGHT;
    harness.hover_at(at(border));
    harness.run();
    harness.drag_at(at(border));
    harness.step();
    for step in 1..=5 {
        harness.hover_at(at(border - 10.0 * step as f32));
        harness.step();
    }
    harness.drop_at(at(border - 50.0));
    harness.run();
    let after = area(&harness).height();
    assert!((after - before.height() - 50.0).abs() < 3.0, "{before}, then {after}");
    let again = open(Dock::of_text(&harness.state().dock.text().unwrap()).unwrap(), [1000.0, 700.0]);
    assert!((area(&again).height() - after).abs() < 1.0);
}

#[test]
fn a_layout_without_the_camera_path_gets_it() {
    // As version 0.2 wrote it after the panel of the style was moved to the left.
    let mut old = Dock::default();
    let path = old.tile(Pane::Path).unwrap();
    let below = old.tree.tiles.parent_of(path).unwrap();
    old.tree.tiles.remove(path);
    old.tree.tiles.remove(below);
    let middle = old.tree.tiles.parent_of(below).unwrap();
    if let Some(Tile::Container(container)) = old.tree.tiles.get_mut(middle) {
        assert!(container.remove_child(below).is_some());
    }
    old.tree.simplify(&options());
    let view = old.tile(Pane::View).unwrap();
    old.widths.insert(old.tree.tiles.parent_of(old.tile(Pane::Flight).unwrap()).unwrap(), 300.0);
    assert!(!old.is_complete() && old.tree.tiles.parent_of(old.tree.tiles.parent_of(view).unwrap()) == old.tree.root());
    let mut harness = open(Dock::of_text(&old.text().unwrap()).unwrap(), [1280.0, 800.0]);
    assert!(!harness.state().dock.is_shown(Pane::Path));
    harness.state_mut().dock.toggle(Pane::Path);
    harness.run();
    let path = harness.state().rects[&Pane::Path];
    assert!(path.top() > 600.0 && path.width() > 900.0, "{path}");
    assert!((width(&harness, Pane::Flight) - 300.0 + 2.0 * f32::from(MARGIN)).abs() < 2.0, "the width is kept");
}

#[test]
fn texts_that_are_no_panels_are_refused() {
    let text = Dock::default().text().unwrap();
    assert!(Dock::of_text(&text).is_some());
    let damaged = [
        String::new(),
        "{}".to_owned(),
        text.replace("\"cost\"", "\"style\""),
        text.replace("\"view\"", "\"picture\""),
        text[..text.len() / 2].to_owned(),
    ];
    for text in damaged {
        assert!(Dock::of_text(&text).is_none(), "{text}");
    }
    // Containers that contain each other, and a tile in two places.
    let dock = Dock::default();
    let root = dock.tree.root().unwrap();
    for child in [root, dock.tile(Pane::Flight).unwrap()] {
        let mut dock = Dock::default();
        if let Some(Tile::Container(container)) = dock.tree.tiles.get_mut(root) {
            container.add_child(child);
        }
        assert!(Dock::of_text(&dock.text().unwrap()).is_none());
    }
}
