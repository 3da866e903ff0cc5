//! Tests the panel of the flight without a window.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::*;
use crate::lines::strokes::LeftOut;
use crate::scene::camera::Camera;
use crate::scene::stereo::Pair;
use crate::scene::{SceneFocus, Sun};

#[test]
fn numbers_are_grouped() {
    assert_eq!(grouped(0), "0");
    assert_eq!(grouped(999), "999");
    assert_eq!(grouped(1000), "1 000");
    assert_eq!(grouped(1_234_567), "1 234 567");
    assert_eq!(digits(-12.34), "−12.3");
    assert_eq!(digits(-1234.0), "−1 234");
    assert_eq!(digits(-0.01), "0.0");
    assert_eq!(digits(1234.5), "1 235");
}

#[test]
fn infinity_is_written_as_such() {
    assert_eq!(distance_words(FARTHEST_M), "∞");
    assert_eq!(distance_words(12.34), "12.3 m");
    for (words, distance_m) in [("∞", FARTHEST_M), ("inf", FARTHEST_M), ("12.5 m", 12.5), ("3", 3.0)] {
        assert_eq!(distance_of(words), Some(distance_m));
    }
    assert_eq!(distance_of("far"), None);
}

static NO_FRAMES: LazyLock<(FrameTimes, PassTimes)> = LazyLock::new(Default::default);

fn stats(strokes: Option<StrokeNumbers>) -> PanelStats<'static> {
    PanelStats {
        adapter: "",
        picture_px: [640, 360],
        quality: None,
        has_levels: true,
        frame_times: &NO_FRAMES.0,
        pass_times: &NO_FRAMES.1,
        triangles: 0,
        patches: 0,
        strokes,
        tiles_on_gpu: 0,
        tiles_loaded: 0,
        tiles_missing: 0,
        over_budget_px: None,
        over_memory_px: None,
        gpu_bytes: 0,
        height_above_ground_m: 0.0,
        is_preparing: false,
        panels: &[],
        has_labels: false,
        views: [true, false],
    }
}

/// Returns the texts of the section on performance, with their colours.
fn performance_texts(strokes: Option<StrokeNumbers>) -> Vec<(String, Color32)> {
    let output = egui::Context::default().run_ui(egui::RawInput::default(), |ui| performance(ui, &stats(strokes)));
    let texts = output.shapes.into_iter().filter_map(|clipped| match clipped.shape {
        egui::Shape::Text(text) => {
            let color = text.galley.job.sections.first().map_or(Color32::TRANSPARENT, |part| part.format.color);
            Some((text.galley.text().to_owned(), color))
        }
        _ => None,
    });
    texts.collect()
}

#[test]
fn a_click_counts_where_frames_are_slow() {
    let click = |context: &egui::Context| {
        let at = egui::pos2(20.0, 12.0);
        let button = |pressed| egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let frames = [vec![], vec![egui::Event::PointerMoved(at)], vec![button(true)], vec![button(false)]];
        let mut is_clicked = false;
        for (second, events) in frames.into_iter().enumerate() {
            let input = egui::RawInput { time: Some(second as f64), events, ..Default::default() };
            let _ = context.run_ui(input, |ui| is_clicked |= ui.button("a button").clicked());
        }
        is_clicked
    };
    let context = egui::Context::default();
    set_up(&context);
    assert!(click(&context));
    assert!(!click(&egui::Context::default()), "planted: as egui has it");
}

#[test]
fn strokes_over_the_limit_are_a_warning() {
    let with = |strokes| Some(StrokeNumbers { drawn: 1234, left_out: LeftOut { strokes, ..LeftOut::default() } });
    let warning = |texts: &[(String, Color32)]| texts.iter().find(|(_, color)| *color == WARNING).cloned();
    let texts = performance_texts(with(56));
    assert!(texts.iter().any(|(text, _)| text == "1 234"), "{texts:?}");
    let (text, _) = warning(&texts).expect("a warning");
    assert!(text.contains("56 strokes exceed the limits"), "{text}");
    // If every stroke fits, only the number is shown; without strokes not even that.
    let texts = performance_texts(with(0));
    assert!(warning(&texts).is_none() && texts.iter().any(|(text, _)| text == "Strokes"), "{texts:?}");
    assert!(performance_texts(None).iter().all(|(text, color)| text != "Strokes" && *color != WARNING));
}

#[test]
fn every_row_has_one_value() {
    let texts = performance_texts(None);
    let has_two = |text: &str| text.contains(", ") && text != "Frame time, median" && text != "Frame time, 95 %";
    let several: Vec<&String> = texts.iter().map(|(text, _)| text).filter(|text| has_two(text)).collect();
    assert!(several.is_empty(), "{several:?}");
    for wanted in ["Frame time, median", "Frame time, 95 %", "Tiles loaded", "Tiles missing", "Triangles", "Patches"] {
        assert!(texts.iter().any(|(text, _)| text == wanted), "{wanted}: {texts:?}");
    }
    // Planted: a row of two values is found.
    assert!(has_two("Tiles loaded, missing"));
}

#[test]
fn light_and_land_are_open_at_first() {
    let harness = open();
    // `open` clicks on the titles of the sections that are closed.
    for wanted in ["Sun azimuth", "Sea level", "Tiles loaded"] {
        assert!(harness.query_all_by_label(wanted).next().is_some(), "{wanted}");
    }
    // Planted: a click on an open section closes it.
    let mut harness = harness;
    harness.get_by_label("Light").click();
    harness.run();
    assert!(harness.query_all_by_label("Sun azimuth").next().is_none());
}

struct Bench {
    settings: Settings,
    camera: FlyCamera,
    light: LightPanel,
    land: LandPanel,
    styles: Styles,
    requests: Vec<PanelRequests>,
}

fn open() -> Harness<'static, Bench> {
    let start: Camera = "0,0,+500,0,-10,45".parse().expect("a camera");
    let bench = Bench {
        settings: Settings {
            eyes: Eyes::SideBySide,
            sea_level_m: Some(3.0),
            tree_seed: Some(1),
            world_seed: Some(1),
            ..crate::window::settings::tests::settings()
        },
        camera: FlyCamera::new(&start, |_| 0.0, [10_000.0, 10_000.0]),
        light: LightPanel::new(None),
        land: LandPanel::new([0.0, 100.0], None, None),
        styles: Styles::with("ink").expect("a preset").0,
        requests: Vec::new(),
    };
    let harness = Harness::builder().with_size(egui::vec2(264.0, 1600.0)).with_context_setup(set_up);
    let mut harness = harness.build_ui_state(
        |ui, bench: &mut Bench| {
            let panels = [(Pane::Style, false), (Pane::Inside, false), (Pane::Cost, true)];
            let stats = PanelStats { panels: &panels, ..stats(None) };
            let Bench { settings, camera, light, land, styles, requests } = bench;
            let request = show(ui, &stats, styles, settings, camera, (light, land));
            if request != PanelRequests::default() {
                requests.push(request);
            }
        },
        bench,
    );
    harness.run();
    for section in ["Performance", "Keys"] {
        harness.get_by_label(section).click();
        harness.run();
    }
    harness
}

/// Returns the names of all widgets that a user can operate; `None` for one without a name.
fn names(harness: &Harness<'_, Bench>) -> Vec<Option<String>> {
    use egui::accesskit::Role;
    let roles = [Role::Button, Role::CheckBox, Role::ComboBox, Role::Slider, Role::SpinButton, Role::TextInput];
    let nodes = harness.root().children_recursive();
    let nodes = nodes.map(|node| (node.accesskit_node().role(), node.accesskit_node().label()));
    nodes.filter(|(role, _)| roles.contains(role)).map(|(_, label)| label).collect()
}

#[test]
fn sliders_leave_values_that_nobody_moves() {
    let mut harness = open();
    let bench = harness.state_mut();
    bench.settings.sun = Sun { azimuth_deg: 134.44, elevation_deg: 25.67 };
    bench.settings.haze_m = 735.55;
    bench.settings.lod_error_px = 37.123;
    bench.settings.pair = Pair { ipd_m: 0.063_456_7, convergence_m: Some(1234.5678) };
    let focus = SceneFocus { place_m: glam::DVec2::ONE, height_m: None, radius_m: 5.4321, strength: 0.123_456 };
    bench.settings.focus = Some(focus);
    (bench.camera.speed_factor, bench.camera.clearance_m, bench.camera.fov_deg) = (1.234_567, 1234.567, 2.3456);
    let (settings, camera) = (bench.settings.clone(), bench.camera.clone());
    harness.run();
    for slider in ["Sun azimuth", "Haze", "Terrain error", "Eye distance", "Convergence", "Focus radius", "Clearance"] {
        assert!(names(&harness).contains(&Some(slider.to_owned())), "{slider} is not shown");
    }
    assert_eq!(harness.state().settings, settings);
    assert_eq!(harness.state().camera, camera);
}

#[test]
fn every_widget_has_a_name_of_its_own() {
    let harness = open();
    let names = names(&harness);
    let mut counts = BTreeMap::new();
    names.iter().for_each(|name| *counts.entry(name.clone().unwrap_or_default()).or_insert(0) += 1);
    assert_eq!(counts.get(""), None, "{counts:?}");
    assert!(counts.values().all(|count| *count == 1), "{counts:?}");
    for wanted in [
        "Style",
        "Drawn style",
        "Eyes",
        "Resolution 0.5",
        "Convergence",
        "Convergence, number",
        "Sun azimuth",
        "Haze, number",
        "Exaggeration",
        "Sea level",
        "Tree seed",
        "Tree seed, next",
        "World seed",
    ] {
        assert!(counts.contains_key(wanted), "{wanted}: {counts:?}");
    }
}

#[test]
fn every_row_fits_into_the_panel() {
    let harness = open();
    let mut count = 0;
    for node in harness.root().children_recursive() {
        let Some(bounds) = node.accesskit_node().bounding_box() else { continue };
        let name = node.accesskit_node().label();
        assert!(bounds.x0 >= 0.0 && bounds.x1 <= 264.0, "{name:?}: {bounds:?}");
        count += 1;
    }
    assert!(count > 100, "{count} nodes");
    assert!(harness.query_by_label("∞").is_none());
    assert_eq!(harness.get_by_label("Convergence, number").accesskit_node().value().as_deref(), Some("∞"));
}

#[test]
fn buttons_of_panels_ask_for_them() {
    let mut harness = open();
    harness.get_by_label("Look inside").click();
    harness.run();
    harness.get_by_label("Copy").click();
    harness.run();
    let requests = &harness.state().requests;
    let toggled = PanelRequests { toggled: Some(Pane::Inside), ..PanelRequests::default() };
    let copied = PanelRequests { copied: true, ..PanelRequests::default() };
    assert_eq!(requests.as_slice(), [toggled, copied]);
}

#[test]
fn buttons_return_to_views_that_there_are() {
    let mut harness = open();
    let is_disabled = |name: &str| harness.get_by_label(name).accesskit_node().is_disabled();
    assert_eq!(["Previous view", "Next view"].map(is_disabled), [false, true]);
    for name in ["Next view", "Previous view"] {
        harness.get_by_label(name).click();
        harness.run();
    }
    let back = PanelRequests { to_view: Some(ViewStep::Back), ..PanelRequests::default() };
    assert_eq!(harness.state().requests.as_slice(), [back]);
}

#[test]
fn tab_moves_the_focus_and_space_presses() {
    let mut harness = open();
    // The buttons of the other panels come first.
    for _ in 0..2 {
        harness.key_press(egui::Key::Tab);
        harness.run();
    }
    assert!(harness.get_by_label("Look inside").accesskit_node().is_focused());
    harness.key_press(egui::Key::Space);
    harness.run();
    assert_eq!(harness.state().requests.first().and_then(|request| request.toggled), Some(Pane::Inside));
}
