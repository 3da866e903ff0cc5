//! Tests the history of the scene without a window: with its controls, and together with the history of a style.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use egui_kittest::{Harness, Node};
use glam::DVec2;

use super::*;
use crate::ladder::Quality;
use crate::measure::quality::Level;
use crate::scene::stereo::{Eyes, Pair};
use crate::scene::{SceneFocus, Sun};
use crate::studio::document::StyleDocument;
use crate::window::land_panel::LandPanel;
use crate::window::light::LightPanel;
use crate::window::settings::tests::settings;

fn focus() -> SceneFocus {
    SceneFocus { place_m: DVec2::new(10.0, 20.0), height_m: None, radius_m: 250.4, strength: 0.7 }
}

/// Returns settings in which every value is another than in [`settings`]. All fields are written out, so that a new one is
/// not forgotten here.
fn others() -> Settings {
    Settings {
        style: 5,
        scale: 2,
        quality: Quality::Level(Level::Draft),
        antialias: Antialias::Temporal,
        lod_error_px: 2.5,
        sun: Sun { azimuth_deg: 120.04, elevation_deg: 35.0 },
        haze_m: 30_000.0,
        exaggeration: 2.0,
        sea_level_m: Some(412.0),
        tree_seed: Some(7),
        world_seed: Some(9),
        focus: Some(focus()),
        eyes: Eyes::SideBySide,
        pair: Pair { ipd_m: 0.5, convergence_m: Some(40.0) },
        follows_land: true,
    }
}

#[test]
fn every_value_but_the_style_has_a_step_with_a_name() {
    let (start, end) = (settings(), others());
    let mut history = SceneHistory::new(&start);
    history.note(&end, false);
    let mut now = end.clone();
    let names: Vec<String> = std::iter::from_fn(|| history.undo(&mut now)).collect();
    let wanted = [
        "Convergence 40 m",
        "Auto eye distance",
        "Eyes: side-by-side",
        "Quality: draft",
        "Resolution 0.5",
        "Smooth edges",
        "Terrain error 2.5 px",
        "World seed 9",
        "Tree seed 7",
        "Sea level 412 m",
        "Exaggeration 2 ×",
        "Focus of radius 250 m, strength 0.7",
        "Haze 30 km",
        "Sun at azimuth 120°, elevation 35°",
    ];
    assert_eq!(names, wanted);
    assert_eq!(now, Settings { style: end.style, ..start.clone() }, "a value has no step, or the style has one");
    let count = std::iter::from_fn(|| history.redo(&mut now)).count();
    assert_eq!((count, now), (wanted.len(), end));
    // The names of the way back to nothing.
    let mut gone = others();
    (gone.focus, gone.sea_level_m, gone.tree_seed) = (None, None, None);
    let mut history = SceneHistory::new(&others());
    history.note(&gone, false);
    let names: Vec<String> = std::iter::from_fn(|| history.undo(&mut gone)).collect();
    assert_eq!(names, ["No trees", "No sea", "No focus"]);
}

/// Undoes or redoes, as a flight does, what was changed last. Returns its name.
fn step(side: usize, document: &mut StyleDocument, history: &mut SceneHistory, now: &mut Settings) -> Option<String> {
    let announced = next_names(history.steps(), document.steps())[side].map(str::to_owned);
    let of_scene = is_later(history.steps()[side], document.steps()[side]);
    let done = match (side, of_scene) {
        (0, true) => history.undo(now),
        (0, false) => document.undo(),
        (_, true) => history.redo(now),
        (_, false) => document.redo(),
    };
    assert_eq!(announced, done);
    done
}

#[test]
fn scene_and_style_have_one_order_of_time() {
    let mut document = StyleDocument::open("crosshatch").unwrap();
    let (mut now, text) = (settings(), document.text().to_owned());
    let mut history = SceneHistory::new(&now);
    now.sun.azimuth_deg = 200.0;
    history.note(&now, false);
    document.set("strokes.width_px", 3.0).unwrap();
    document.release();
    now.sea_level_m = Some(10.0);
    history.note(&now, false);
    document.set("strokes.width_px", 4.0).unwrap();
    document.release();
    let edited = (now.clone(), document.text().to_owned());
    let all =
        ["Strokes: width 4.0 px", "Sea level 10 m", "Strokes: width 3.0 px", "Sun at azimuth 200°, elevation 40°"];
    for _ in 0..2 {
        let undone: Vec<String> = std::iter::from_fn(|| step(0, &mut document, &mut history, &mut now)).collect();
        assert_eq!(undone, all);
        assert_eq!((&now, document.text()), (&settings(), &*text));
        let mut redone: Vec<String> = std::iter::from_fn(|| step(1, &mut document, &mut history, &mut now)).collect();
        redone.reverse();
        assert_eq!(redone, all);
        assert_eq!((&now, document.text()), (&edited.0, &*edited.1));
    }
    // A change ends what could be redone of its own kind; the other kind does not depend on it.
    (0..4).for_each(|_| _ = step(0, &mut document, &mut history, &mut now));
    now.haze_m = 5000.0;
    history.note(&now, false);
    let redone: Vec<String> = std::iter::from_fn(|| step(1, &mut document, &mut history, &mut now)).collect();
    assert_eq!(redone, ["Strokes: width 3.0 px", "Strokes: width 4.0 px"]);
    // The last repeated change is undone first.
    assert_eq!(step(0, &mut document, &mut history, &mut now).unwrap(), "Strokes: width 4.0 px");
    document.set("strokes.width_px", 5.0).unwrap();
    assert_eq!(step(1, &mut document, &mut history, &mut now), None);
}

#[test]
fn what_the_program_changes_is_no_step() {
    let start = Settings { eyes: Eyes::SideBySide, follows_land: true, ..settings() };
    let mut history = SceneHistory::new(&start);
    let mut now = start.clone();
    now.pair.ipd_m = 12.0;
    history.note(&now, false);
    assert_eq!(history.steps(), [None, None], "the distance between the eyes follows the land");
    // Setting the distance by hand is one change, and following the land again undoes it.
    now.follows_land = false;
    history.note(&now, false);
    now.pair.ipd_m = 3.0;
    history.note(&now, false);
    assert_eq!(history.undo(&mut now).unwrap(), "Eye distance 3 m");
    assert_eq!(history.undo(&mut now).unwrap(), "Eye distance 12 m");
    assert!(now.follows_land);
    // A change that could not be followed is forgotten, whatever was changed after it, and other changes are not.
    let mut history = SceneHistory::new(&start);
    let mut now = start.clone();
    now.exaggeration = 2.0;
    history.note(&now, false);
    now.exaggeration = 50.0;
    history.note(&now, false);
    now.haze_m = 5000.0;
    history.note(&now, false);
    now.exaggeration = 2.0;
    history.refuse(SceneValue::Exaggeration, &now);
    history.note(&now, false);
    let names: Vec<String> = std::iter::from_fn(|| history.undo(&mut now)).collect();
    assert_eq!(names, ["Haze 5 km", "Exaggeration 2 ×"]);
    // The same for a change that was undone.
    now.exaggeration = 2.0;
    history.refuse(SceneValue::Exaggeration, &now);
    assert_eq!(history.redo(&mut now).unwrap(), "Haze 5 km");
}

#[test]
fn the_oldest_steps_are_dropped() {
    let mut history = SceneHistory::new(&settings());
    let mut now = settings();
    for seed in 0..MAX_STEPS as u32 + 20 {
        now.tree_seed = Some(seed);
        history.note(&now, false);
    }
    let names: Vec<String> = std::iter::from_fn(|| history.undo(&mut now)).collect();
    assert_eq!((names.len(), now.tree_seed), (MAX_STEPS, Some(19)));
}

/// The controls of light and land, with a history.
struct Bench {
    light: LightPanel,
    land: LandPanel,
    settings: Settings,
    history: SceneHistory,
    /// Whether the history learns that a control is held.
    sees_holds: bool,
}

fn open(sees_holds: bool) -> Harness<'static, Bench> {
    let settings = Settings { sea_level_m: Some(3.0), world_seed: Some(1), ..settings() };
    let bench = Bench {
        light: LightPanel::new(None),
        land: LandPanel::new([0.0, 1000.0], None, None),
        history: SceneHistory::new(&settings),
        settings,
        sees_holds,
    };
    let harness = Harness::builder().with_size(egui::vec2(300.0, 600.0));
    let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
        |ui, Bench { light, land, settings, .. }: &mut Bench| {
            light.show(ui, settings, 0.0);
            land.show(ui, settings, true);
        },
        bench,
    );
    frames(&mut harness);
    assert_eq!(harness.state().history.steps(), [None, None], "controls have changed values that nobody touched");
    harness
}

/// Draws a frame, as a flight does.
fn frame(harness: &mut Harness<'_, Bench>) {
    harness.step();
    let is_held = is_held(&harness.ctx);
    let Bench { settings, history, sees_holds, .. } = harness.state_mut();
    history.note(settings, is_held && *sees_holds);
}

fn frames(harness: &mut Harness<'_, Bench>) {
    (0..4).for_each(|_| frame(harness));
}

/// Returns the widget of a name; the text in front of it has the same.
fn widget<'a>(harness: &'a Harness<'_, Bench>, name: &'a str) -> Node<'a> {
    harness.query_all_by_label(name).find(|node| node.accesskit_node().role() != Role::Label).unwrap()
}

fn undone(harness: &mut Harness<'_, Bench>) -> Vec<String> {
    let Bench { settings, history, .. } = harness.state_mut();
    std::iter::from_fn(|| history.undo(settings)).collect()
}

/// Drags the sun around, to a number of places.
fn drag_sun(harness: &mut Harness<'_, Bench>) {
    let centre = widget(harness, "Sun: direction and height").rect().center();
    harness.drag_at(centre + egui::vec2(0.0, 20.0));
    frame(harness);
    for step in 0..6 {
        harness.hover_at(centre + egui::vec2(5.0 * step as f32, 20.0));
        frame(harness);
    }
    harness.drop_at(centre + egui::vec2(30.0, 20.0));
    frames(harness);
}

#[test]
fn a_drag_of_the_sun_is_one_step() {
    let mut harness = open(true);
    let before = harness.state().settings.clone();
    drag_sun(&mut harness);
    let after = harness.state().settings.sun;
    drag_sun(&mut harness);
    // The second drag ends where it began, but each press moves the sun first.
    assert_eq!(harness.state().settings.sun, after);
    let names = undone(&mut harness);
    assert!(names.len() == 1 && names[0].starts_with("Sun at azimuth 1"), "{names:?}");
    assert_eq!(harness.state().settings, before);
    // Planted: without knowing that the mouse is held, each frame is a step.
    let mut harness = open(false);
    drag_sun(&mut harness);
    assert!(undone(&mut harness).len() > 3);
}

/// Types a sea level, letter by letter.
fn type_sea_level(harness: &mut Harness<'_, Bench>) {
    let name = "Sea level, number";
    widget(harness, name).click();
    frames(harness);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    for letter in ["4", "1", "2"] {
        widget(harness, name).type_text(letter);
        frames(harness);
    }
    harness.key_press(egui::Key::Enter);
    frames(harness);
}

#[test]
fn a_number_that_is_typed_is_one_step() {
    let mut harness = open(true);
    let before = harness.state().settings.clone();
    drag_sun(&mut harness);
    type_sea_level(&mut harness);
    assert_eq!(harness.state().settings.sea_level_m, Some(412.0));
    widget(&harness, "World seed, next").click();
    frames(&mut harness);
    widget(&harness, "Trees").click();
    frames(&mut harness);
    let names = undone(&mut harness);
    assert_eq!(names[..3], ["Tree seed 1", "World seed 2", "Sea level 412 m"]);
    assert_eq!(names.len(), 4);
    // Controls leave what was undone.
    frames(&mut harness);
    assert_eq!(harness.state().settings, before);
    assert_eq!(harness.state().history.steps()[0], None);
    // Planted: each letter is a step.
    let mut harness = open(false);
    type_sea_level(&mut harness);
    assert_eq!(undone(&mut harness), ["Sea level 412 m", "Sea level 41 m", "Sea level 4 m"]);
}
