//! Tests the export dialog without a window: its widgets, and the command lines that it makes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by it")]

use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::*;
use crate::gpu::device::AdapterWish;
use crate::picture::imprint::{Imprint, More};
use crate::scene::Sun;
use crate::style::Style;

struct Bench {
    dialog: ExportDialog,
    view: ShownView,
    is_edited: bool,
    requests: Vec<Request>,
}

fn view() -> ShownView {
    let imprint = Imprint {
        world: Some("my dem.tif".to_owned()),
        camera: "1,2,300,45,-10,50".parse().unwrap(),
        sun: Sun { azimuth_deg: 315.0, elevation_deg: 40.0 },
        style: Style::load("ink").unwrap(),
        size_px: [1280, 720],
        dpi: None,
        more: More::default(),
    };
    ShownView { imprint, style: "ink".to_owned(), set: Vec::new(), trusts_scene: false, adapter: AdapterWish::Best }
}

fn harness<'a>(size: egui::Vec2, is_edited: bool) -> Harness<'a, Bench> {
    let bench = Bench { dialog: ExportDialog::default(), view: view(), is_edited, requests: Vec::new() };
    let harness = Harness::builder().with_size(size).with_context_setup(crate::window::panel::set_up);
    let mut harness = harness.build_ui_state(
        |ui, bench: &mut Bench| {
            let Bench { view, is_edited, .. } = bench;
            let shown = Shown { view, refusal: is_edited.then_some(Refusal::Edited), window_px: [1280, 720] };
            let request = bench.dialog.show(ui.ctx(), &shown);
            bench.requests.extend(request);
        },
        bench,
    );
    harness.state_mut().dialog.toggle("/nowhere/my dem-ink", [1280, 720], 16);
    harness.run();
    harness
}

/// Returns the arguments after a click on the button that exports.
fn exported(harness: &mut Harness<'_, Bench>) -> Vec<String> {
    harness.get_by_label("Export").click();
    harness.run();
    match harness.state_mut().requests.pop() {
        Some(Request::Run(arguments, _)) => arguments,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_poster_is_chosen_and_its_command_is_shown() {
    let mut harness = harness(egui::vec2(1280.0, 800.0), false);
    harness.get_by_label("paper").click();
    harness.run();
    harness.get_by_label("portrait").click();
    harness.run();
    let line = "hachure render 'my dem.tif' --camera=1,2,300,45,-10,50 --sun=315,40 --samples=16 --style=ink --paper=a3 \
                --portrait --dpi=300 '--output=/nowhere/my dem-ink.png'";
    assert!(harness.query_by_label(line).is_some(), "the line is shown");
    assert_eq!(quoted(&exported(&mut harness)), line, "and it is what runs");
    harness.get_by_label("Copy the command").click();
    harness.run();
    assert!(harness.query_by_label("Copied").is_some());
    harness.get_by_label("Poster sheets").click();
    harness.run();
    assert!(harness.query_by_label("Copied").is_none(), "another line is not copied");
    let arguments = exported(&mut harness);
    assert!(arguments.contains(&"--sheets=a4".to_owned()) && arguments.contains(&"--sheets-overlap=10".to_owned()));
}

#[test]
fn every_kind_has_its_options() {
    let mut harness = harness(egui::vec2(960.0, 540.0), false);
    let wanted: [(&str, &str); 6] = [
        ("Lines (SVG, PDF)", "--size=1280x720"),
        ("EXR channels", "--aov=depth,normal"),
        ("Map", "--map=whole"),
        ("Stereo", "--eyes=side-by-side"),
        ("Poster sheets", "--sheets=a4"),
        ("Picture", "--samples=16"),
    ];
    for (kind, option) in wanted {
        harness.get_by_label(kind).click();
        harness.run();
        let arguments = exported(&mut harness);
        assert!(arguments.iter().any(|argument| argument == option), "{kind}: {arguments:?}");
    }
    // A film cannot run without a path.
    harness.get_by_label("Film").click();
    harness.run();
    assert!(harness.query_by_label("A film needs a camera path").is_some());
    assert!(harness.get_by_label("Export").accesskit_node().is_disabled());
}

#[test]
fn edits_are_saved_before_they_are_exported() {
    let mut harness = harness(egui::vec2(960.0, 540.0), true);
    assert!(harness.get_by_label("Export").accesskit_node().is_disabled());
    assert!(harness.get_by_label("Copy the command").accesskit_node().is_disabled());
    harness.get_by_label("Save the style").click();
    harness.run();
    assert_eq!(harness.state().requests, [Request::SaveStyle]);
    harness.state_mut().is_edited = false;
    harness.run();
    assert!(!harness.get_by_label("Export").accesskit_node().is_disabled());
}

#[test]
fn all_widgets_are_in_a_small_window_and_have_names() {
    use egui::accesskit::Role;
    let mut harness = harness(egui::vec2(640.0, 360.0), false);
    for (_, kind) in Kind::ALL {
        harness.get_by_label(kind).click();
        harness.run();
        let roles = [Role::Button, Role::CheckBox, Role::ComboBox, Role::SpinButton, Role::TextInput];
        let unnamed: Vec<_> = harness
            .root()
            .children_recursive()
            .filter(|node| roles.contains(&node.accesskit_node().role()))
            .filter(|node| node.accesskit_node().label().is_none_or(|label| label.trim().is_empty()))
            .map(|node| (node.accesskit_node().role(), node.rect()))
            .collect();
        assert!(unnamed.is_empty(), "{kind}: {unnamed:?}");
    }
}
