//! Tests the panel of the camera path without a window: its widgets, their names, and what they do.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::collections::BTreeMap;

use egui::accesskit::{Action, ActionData, ActionRequest, Role, TreeId};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::*;

const TEXT: &str = "t,x,y,z,yaw,pitch,fov\n0,0,0,900,0,-10,50\n4,100,0,900,10,-10,50\n10,200,50,950,20,-10,50\n";

struct Bench {
    panel: PathPanel,
    document: PathDocument,
    player: Player,
    views: Views,
    has_kept: bool,
    requests: Vec<PathRequest>,
    errors: Vec<String>,
}

fn here() -> Camera {
    "7,8,900,1,2,50".parse().unwrap()
}

fn open(text: &str, size: [f32; 2]) -> Harness<'static, Bench> {
    let document = match text {
        "" => PathDocument::empty(),
        text => PathDocument::of_text("a.csv", Some("a.csv".into()), text, |_, _| 0.0).unwrap(),
    };
    let bench = Bench {
        panel: PathPanel::default(),
        document,
        player: Player::default(),
        views: Views::default(),
        has_kept: false,
        requests: Vec::new(),
        errors: Vec::new(),
    };
    let harness = Harness::builder().with_size(egui::vec2(size[0], size[1])).with_max_steps(40);
    let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
        |ui, bench: &mut Bench| {
            let Bench { panel, document, player, views, has_kept, requests, errors } = bench;
            let shown = PathState { document, player, views, has_kept: *has_kept };
            let new = panel.show(ui, &shown);
            for request in &new {
                match request {
                    PathRequest::Edit(edit) => errors.extend(panel.apply(document, player, *edit, &here()).err()),
                    PathRequest::Seek(time_s) => player.playhead_s = *time_s,
                    PathRequest::Rename(index, name) => views.rename(*index, name),
                    _ => {}
                }
            }
            requests.extend(new);
        },
        bench,
    );
    harness.run();
    harness
}

fn click(harness: &mut Harness<'_, Bench>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

/// Drags the mouse from one point to another.
fn drag(harness: &mut Harness<'_, Bench>, from: egui::Pos2, to: egui::Pos2) {
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for step in 1..=8 {
        harness.hover_at(from + (to - from) * (step as f32 / 8.0));
        harness.step();
    }
    harness.drop_at(to);
    harness.run();
}

fn times_s(harness: &Harness<'_, Bench>) -> Vec<f64> {
    harness.state().document.keys().iter().map(|key| key.time_s).collect()
}

fn with_views(harness: &mut Harness<'_, Bench>) {
    for camera in ["1,2,900,0,0,50", "3,4,900,0,0,50"] {
        harness.state_mut().views.add(camera.parse().unwrap()).unwrap();
    }
    harness.run();
}

#[test]
fn every_widget_has_a_name_of_its_own() {
    let mut harness = open(TEXT, [700.0, 400.0]);
    with_views(&mut harness);
    harness.state_mut().has_kept = true;
    click(&mut harness, "Save the path as");
    let roles = [Role::Button, Role::CheckBox, Role::ComboBox, Role::Slider, Role::SpinButton, Role::TextInput];
    let mut counts = BTreeMap::new();
    for node in harness.root().children_recursive() {
        if roles.contains(&node.accesskit_node().role()) {
            let label = node.accesskit_node().label().unwrap_or_default();
            *counts.entry(label.trim().to_owned()).or_insert(0) += 1;
        }
    }
    assert!(!counts.contains_key("") && counts.values().all(|count| *count == 1), "{counts:?}");
    let wanted = [
        "Play",
        "Loop",
        "Time of the playhead",
        "Duration of the path",
        "Add key",
        "Undo an edit of the path",
        "Save the path",
        "Open a path",
        "New path",
        "Render film…",
        "Time line of the camera path",
        "Key 2",
        "Key 2 at 4 s",
        "Time of key 2",
        "Ease of key 2, percent",
        "Replace key 2 by the present view",
        "Delete key 2",
        "Add view",
        "Name of view 2",
        "Go to view 2",
        "Add view 2 as a key frame",
        "Delete view 2",
        "Restore the edits",
        "Path of the new camera path",
    ];
    for label in wanted {
        assert!(counts.contains_key(label), "{label}: {counts:?}");
    }
}

#[test]
fn the_playhead_is_dragged_and_stepped() {
    let mut harness = open(TEXT, [700.0, 200.0]);
    let rect = harness.get_by_label("Time line of the camera path").rect();
    let key = |harness: &Harness<'_, Bench>, label: &str| harness.get_by_label(label).rect().center();
    let (first, last) = (key(&harness, "Key 1 at 0 s"), key(&harness, "Key 3 at 10 s"));
    // Above the diamonds, from a fifth of the path to its half.
    let at = |part: f32| egui::pos2(first.x + part * (last.x - first.x), rect.top() + 4.0);
    drag(&mut harness, at(0.2), at(0.5));
    let seeks: Vec<f64> = harness
        .state()
        .requests
        .iter()
        .filter_map(|request| match request {
            PathRequest::Seek(time_s) => Some(*time_s),
            _ => None,
        })
        .collect();
    assert!((seeks[0] - 2.0).abs() < 0.1 && seeks.len() >= 8, "{seeks:?}");
    assert!((harness.state().player.playhead_s - 5.0).abs() < 0.1, "{}", harness.state().player.playhead_s);
    // Beyond the ends, it stays at them.
    drag(&mut harness, at(0.5), egui::pos2(rect.right() + 50.0, rect.top() + 4.0));
    assert_eq!(harness.state().player.playhead_s, 10.0);
    // The keyboard and a screen reader.
    harness.get_by_label("Time line of the camera path").focus();
    harness.run();
    for (key, wanted_s) in [(Key::ArrowLeft, 9.9), (Key::Home, 0.0), (Key::ArrowRight, 0.1), (Key::End, 10.0)] {
        harness.key_press(key);
        harness.run();
        assert_eq!(harness.state().player.playhead_s, wanted_s, "{key:?}");
    }
    assert!(harness.get_by_label("Time line of the camera path").accesskit_node().is_focused());
    let target_node = harness.get_by_label("Time line of the camera path").accesskit_node().locate().0;
    let request = |action: Action, data: Option<ActionData>| {
        egui::Event::AccessKitActionRequest(ActionRequest { action, target_tree: TreeId::ROOT, target_node, data })
    };
    harness.event(request(Action::SetValue, Some(ActionData::NumericValue(3.0))));
    harness.run();
    harness.event(request(Action::Increment, None));
    harness.run();
    assert_eq!(harness.state().player.playhead_s, 3.1);
    harness.key_press(Key::Space);
    harness.run();
    assert_eq!(harness.state().requests.last(), Some(&PathRequest::Play(true)));
}

#[test]
fn keys_are_selected_dragged_and_deleted() {
    let mut harness = open(TEXT, [700.0, 240.0]);
    let middle = harness.get_by_label("Key 2 at 4 s").rect().center();
    let last = harness.get_by_label("Key 3 at 10 s").rect().center();
    let per_s = (last.x - middle.x) / 6.0;
    drag(&mut harness, middle, middle + egui::vec2(2.0 * per_s, 3.0));
    assert_eq!(times_s(&harness)[0], 0.0);
    assert!((times_s(&harness)[1] - 6.0).abs() < 0.1 && times_s(&harness)[2] == 10.0, "{:?}", times_s(&harness));
    assert_eq!(harness.state().player.playhead_s, times_s(&harness)[1], "the playhead goes with it");
    assert_eq!(harness.state().document.undo_count(), 1, "a drag is one step");
    // The drag has selected it.
    harness.key_press(Key::Delete);
    harness.run();
    assert_eq!(times_s(&harness), [0.0, 10.0]);
    harness.key_press(Key::Delete);
    harness.run();
    assert_eq!(times_s(&harness), [0.0, 10.0], "nothing is selected any more");
    click(&mut harness, "Undo an edit of the path");
    click(&mut harness, "Undo an edit of the path");
    assert_eq!(harness.state().document.text(), TEXT);
    click(&mut harness, "Redo an edit of the path");
    assert_ne!(harness.state().document.text(), TEXT);
    click(&mut harness, "Undo an edit of the path");
    // A click goes there.
    click(&mut harness, "Key 3 at 10 s");
    assert_eq!(harness.state().player.playhead_s, 10.0);
    click(&mut harness, "Key 2");
    assert_eq!(harness.state().player.playhead_s, 4.0);
    click(&mut harness, "Delete key 1");
    assert_eq!(times_s(&harness), [4.0, 10.0]);
    assert!(harness.state().errors.is_empty());
}

#[test]
fn keys_are_added_replaced_and_eased() {
    let mut harness = open("", [700.0, 240.0]);
    assert!(harness.query_by_label_contains("No key frames yet").is_some());
    for disabled in ["Play", "Save the path", "Save the path as", "New path", "Render film…", "Duration of the path"]
    {
        assert!(harness.get_by_label(disabled).accesskit_node().is_disabled(), "{disabled}");
    }
    for _ in 0..3 {
        click(&mut harness, "Add key");
    }
    assert_eq!(times_s(&harness), [0.0, 4.0, 8.0]);
    assert_eq!(harness.state().document.keys()[2].camera, here());
    with_views(&mut harness);
    harness.state_mut().player.playhead_s = 6.5;
    harness.run();
    click(&mut harness, "Add view 2 as a key frame");
    assert_eq!(times_s(&harness), [0.0, 4.0, 6.5, 8.0]);
    assert_eq!(harness.state().document.keys()[2].camera.position_m.x, 3.0);
    click(&mut harness, "Replace key 3 by the present view");
    assert_eq!(harness.state().document.keys()[2].camera, here());
    // Numbers are typed.
    for (label, text) in [("Ease of key 2, percent", "75"), ("Time of key 4", "9.5"), ("Duration of the path", "19")] {
        click(&mut harness, label);
        harness.get_by_label(label).type_text(text);
        harness.run();
        harness.key_press(Key::Enter);
        harness.run();
    }
    assert_eq!(harness.state().document.keys()[1].ease, 0.75);
    assert_eq!(times_s(&harness), [0.0, 8.0, 13.0, 19.0]);
    for label in ["Play", "Loop", "Render film…"] {
        click(&mut harness, label);
    }
    let requests = &harness.state().requests;
    assert!(requests.ends_with(&[PathRequest::Play(true), PathRequest::Loop(true), PathRequest::Film]), "{requests:?}");
}

#[test]
fn a_name_is_asked_for_and_edits_are_discarded_only_on_purpose() {
    let mut harness = open(TEXT, [700.0, 240.0]);
    assert!(harness.get_by_label("Save the path").accesskit_node().is_disabled(), "nothing has changed");
    click(&mut harness, "Delete key 2");
    click(&mut harness, "Save the path");
    assert_eq!(harness.state().requests.last(), Some(&PathRequest::Save));
    click(&mut harness, "Save the path as");
    harness.get_by_label("Path of the new camera path").type_text("/x");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    assert!(matches!(harness.state().requests.last(), Some(PathRequest::SaveAs(name)) if name.contains("/x")));
    harness.state_mut().panel.set_error(Some("path.csv: exists".to_owned()));
    harness.run();
    assert!(harness.query_by_label("path.csv: exists").is_some());
    harness.state_mut().panel.set_error(None);
    harness.state_mut().panel.end_name();
    harness.run();
    assert!(harness.query_by_label("Path of the new camera path").is_none());
    click(&mut harness, "New path");
    assert_ne!(harness.state().requests.last(), Some(&PathRequest::New));
    click(&mut harness, "Discard the edits of the path");
    assert_eq!(harness.state().requests.last(), Some(&PathRequest::New));
}

#[test]
fn views_are_renamed_and_edits_of_an_earlier_run_offered() {
    let mut harness = open(TEXT, [700.0, 300.0]);
    with_views(&mut harness);
    harness.get_by_label("Name of view 1").click();
    harness.run();
    harness.get_by_label("Name of view 1").type_text("!");
    harness.run();
    assert!(harness.state().views.list()[0].name.contains('!'));
    // Delete in a field is not for the key.
    click(&mut harness, "Key 1");
    harness.get_by_label("Name of view 1").click();
    harness.run();
    harness.key_press(Key::Delete);
    harness.run();
    assert_eq!(times_s(&harness).len(), 3);
    for (label, wanted) in [
        ("Add view", PathRequest::AddView),
        ("Go to view 2", PathRequest::GoTo(1)),
        ("Delete view 1", PathRequest::RemoveView(0)),
        ("Open a path", PathRequest::Open),
    ] {
        click(&mut harness, label);
        assert!(harness.state_mut().requests.contains(&wanted), "{label}");
    }
    assert!(harness.state().requests.contains(&PathRequest::KeepViews));
    harness.state_mut().has_kept = true;
    harness.run();
    for (label, restores) in [("Restore the edits", true), ("Discard them", false)] {
        click(&mut harness, label);
        assert_eq!(harness.state().requests.last(), Some(&PathRequest::Restore(restores)));
    }
}

#[test]
fn a_long_path_and_a_small_panel_are_laid_out() {
    let mut text = String::from("t,x,y,z,yaw,pitch,fov\n");
    (0..3000).for_each(|row| text += &format!("{row},0,0,900,0,0,50\n"));
    let mut harness = open(&text, [430.0, 180.0]);
    assert!(harness.query_by_label("Key 1").is_some() && harness.query_by_label("Key 2000").is_none());
    let rows = harness.root().children_recursive().count();
    assert!(rows < 300, "{rows}: only the keys that are seen are laid out");
    // A long list scrolls to a key that is added.
    harness.state_mut().player.playhead_s = 1999.5;
    click(&mut harness, "Add key");
    assert!(harness.query_by_label("Key 2001").is_some());
    let panel = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(430.0, 180.0));
    let line = harness.get_by_label("Time line of the camera path").rect();
    assert!(panel.contains_rect(line), "{line}");
    assert!(line.bottom() < 110.0, "the list has room: {line}");
}
