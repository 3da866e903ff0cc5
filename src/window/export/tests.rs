//! Tests the export dialog without a window: its widgets, and the command lines that it makes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by it")]

use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::*;
use crate::gpu::device::AdapterWish;
use crate::picture::imprint::{Imprint, More};
use crate::scene::Sun;
use crate::style::Style;
use crate::window::screen_reader::tests::{focusable, repeated, unnamed};

struct Bench {
    dialog: ExportDialog,
    view: ShownView,
    is_edited: bool,
    requests: Vec<ExportRequest>,
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
            let shown = WindowView { view, refusal: is_edited.then_some(Refusal::Edited), window_px: [1280, 720] };
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
        Some(ExportRequest::Run(arguments, _)) => arguments,
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
    assert_eq!(harness.state().requests, [ExportRequest::SaveStyle]);
    harness.state_mut().is_edited = false;
    harness.run();
    assert!(!harness.get_by_label("Export").accesskit_node().is_disabled());
}

#[test]
fn all_widgets_are_in_a_small_window_and_have_names() {
    let mut harness = harness(egui::vec2(640.0, 360.0), false);
    let mut counts = Vec::new();
    for (kind, name) in Kind::ALL {
        harness.get_by_label(name).click();
        harness.run();
        for ending in kind.endings() {
            if kind.endings().len() > 1 {
                harness.get_by_label(&format!(".{ending}")).click();
                harness.run();
            }
            for area in ["paper", "around the camera", "pixels"] {
                if let Some(button) = harness.query_by_label(area) {
                    button.click();
                    harness.run();
                }
                let (unnamed, repeated) = (unnamed(&harness), repeated(&harness));
                assert!(unnamed.is_empty(), "{name}, {ending}, {area}: {unnamed:?}");
                assert!(repeated.is_empty(), "{name}, {ending}, {area}: {repeated:?}");
                counts.push(focusable(&harness).len());
            }
        }
    }
    // The kinds, the output and the buttons at the bottom are there always.
    let fewest = Kind::ALL.len() + 3;
    assert!(counts.iter().all(|count| *count > fewest), "{counts:?}");
}

#[test]
fn files_of_the_user_are_replaced_only_after_a_question() {
    let folder = tempfile::tempdir().unwrap();
    let photo = folder.path().join("photo.png");
    crate::file::atomic::write(&photo, b"mine").unwrap();
    let mut harness = harness(egui::vec2(1280.0, 800.0), false);
    harness.state_mut().dialog.export.output = photo.display().to_string();
    let click = |harness: &mut Harness<'_, Bench>, label: &str| {
        harness.get_by_label(label).click();
        harness.run();
    };
    click(&mut harness, "Export");
    assert!(harness.state().requests.is_empty(), "it asks first");
    let question = format!("{} exists, and hachure did not draw it. Replace it?", named(&photo));
    assert!(harness.query_by_label(&question).is_some());
    assert!(unnamed(&harness).is_empty() && repeated(&harness).is_empty());
    click(&mut harness, "Keep it");
    assert!(harness.state().requests.is_empty() && harness.query_by_label(&question).is_none());
    click(&mut harness, "Export");
    // Other options are another export.
    harness.state_mut().dialog.export.samples = 3;
    harness.run();
    assert!(harness.query_by_label("Replace it").is_none());
    click(&mut harness, "Export");
    // The shown command line is the one that runs.
    let shown = quoted(&{
        let mut arguments = harness.state().dialog.export.arguments(&harness.state().view);
        arguments.push("--overwrite".to_owned());
        arguments
    });
    assert!(harness.query_by_label(&shown).is_some(), "{shown}");
    click(&mut harness, "Replace it");
    match harness.state_mut().requests.pop() {
        Some(ExportRequest::Run(arguments, _)) => assert_eq!(quoted(&arguments), shown),
        other => panic!("{other:?}"),
    }
    // The next export does not replace what the user has not been asked about.
    assert!(!exported_after_removing(&mut harness, &photo).contains(&"--overwrite".to_owned()));
    // A closed dialog forgets the question.
    crate::file::atomic::write(&photo, b"mine").unwrap();
    click(&mut harness, "Export");
    harness.state_mut().dialog.close();
    harness.state_mut().dialog.toggle("", [1, 1], 1);
    harness.run();
    assert!(harness.query_by_label("Replace it").is_none() && harness.query_by_label("Export").is_some());
}

/// Removes a file and returns the arguments of the export that is then made without a question.
fn exported_after_removing(harness: &mut Harness<'_, Bench>, file: &std::path::Path) -> Vec<String> {
    std::fs::remove_file(file).unwrap();
    exported(harness)
}
