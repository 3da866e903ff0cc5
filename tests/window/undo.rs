//! The way back: changes of the scene and of the style are undone in one order, and the camera returns to its views.

use std::path::Path;
use std::time::Duration;

use hachure::file::png::read_rgba8;

use crate::display::{Display, can_run, hachure, is_full, open_with, until};
use crate::person::Person;
use crate::taken;

/// Takes a picture of the window, and returns its pixels and the line that says how it was drawn.
fn seen(display: &Display, folder: &Path) -> (Vec<u8>, String) {
    let path = taken(display, folder);
    let output = hachure(folder).arg("info").arg(&path).env("XDG_RUNTIME_DIR", folder).output().unwrap();
    let info = String::from_utf8(output.stdout).unwrap().replace(path.file_name().unwrap().to_str().unwrap(), "");
    (read_rgba8(&path).unwrap().rgba, info)
}

#[test]
fn scene_style_and_camera_have_a_way_back() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::of_size("900x1000x24").expect("Xvfb must start");
    let widgets = folder.join("widgets");
    let environment = [("HACHURE_WIDGETS", &*widgets)];
    // `lsa` draws the sea too, and has the same controls.
    let style = if is_full() { "wash" } else { "lsa" };
    let arguments = ["--style", style, "--antialias", "none", "--size", "900x1000", "--sea-level", "50"];
    let (mut program, window) = open_with(&display, folder, &environment, &arguments);
    let person = Person { display: &display, window, widgets, frame: Duration::from_millis(300) };
    person.find("ComboBox", "Drawn style");
    if !is_full() {
        // A coarser picture of the window leaves more time for its screenshots.
        person.keys(&["minus", "minus"]);
    }
    person.keys(&["i"]);
    person.find("Slider", "Density");
    // When the style is drawn, rows of the panel stay where they are.
    let start = seen(&display, folder);
    // Both sections are open at first.
    for (role, first) in [("CheckBox", "Sea"), ("Slider", "Sun azimuth")] {
        person.find(role, first);
    }
    let value = |role, name| person.find(role, name).value;
    let sun = || value("Slider", "Sun azimuth");
    let sea = || value("Slider", "Sea level");
    let density = || value("Slider", "Density");
    let all = || [sun(), sea(), density()];
    let first_sun = sun();
    assert_eq!(all()[1..], ["50", "0"]);

    // The sun is dragged to several places, a sea level is typed, and a slider of the style is dragged.
    let drag = |name: &str| {
        let [x, y] = Person::middle(&person.find("Slider", name));
        person.point([x, y]);
        display.key(&["mousedown", "1"]);
        for step in 1..=4 {
            person.point([x - 5.0 * f64::from(step), y]);
            std::thread::sleep(Duration::from_millis(150));
        }
        display.key(&["mouseup", "1"]);
    };
    drag("Sun azimuth");
    until("the sun", || Some(sun()).filter(|now| *now != first_sun));
    person.fill("SpinButton", "Sea level, number", "412");
    until("the sea", || (sea() == "412").then_some(()));
    drag("Density");
    until("the style", || Some(density()).filter(|now| *now != "0"));
    let [moved_sun, _, moved_density] = all();

    let is_at = |wanted: [&str; 3]| until(&format!("{wanted:?}"), || (all() == wanted).then_some(()));
    person.keys(&["ctrl+z"]);
    is_at([&moved_sun, "412", "0"]);
    person.keys(&["ctrl+z"]);
    is_at([&moved_sun, "50", "0"]);
    person.keys(&["ctrl+z"]);
    is_at([&first_sun, "50", "0"]);
    for (key, wanted) in [
        ("ctrl+y", [&*moved_sun, "50", "0"]),
        ("ctrl+shift+z", [&*moved_sun, "412", "0"]),
        ("ctrl+y", [&*moved_sun, "412", &*moved_density]),
    ] {
        person.keys(&[key]);
        is_at(wanted);
    }
    let changed = seen(&display, folder);
    assert!(changed.1 != start.1, "{}", changed.1);
    person.keys(&["ctrl+z", "ctrl+z"]);
    // The buttons of the inspector are for both histories, too.
    is_at([&moved_sun, "50", "0"]);
    person.click("Button", "Undo");
    is_at([&first_sun, "50", "0"]);
    assert!(seen(&display, folder) == start, "something is not undone");

    // The camera shows all of the land, and looks down: in the fast tier in a small window without panels.
    let (start, [x, y]) = if is_full() {
        (start, [450.0, 500.0])
    } else {
        person.keys(&["h", "i"]);
        display.key(&["windowsize", &person.window, "320", "200"]);
        let is_small = |(rgba, _): &(Vec<u8>, String)| rgba.len() == 4 * 320 * 200;
        (until("the small window", || Some(seen(&display, folder)).filter(is_small)), [160.0, 100.0])
    };
    let moved = |key: &str| {
        let before = seen(&display, folder).1;
        person.keys(&[key]);
        let mut last = before.clone();
        until("another view at rest", || {
            let now = seen(&display, folder).1;
            let rests = now == std::mem::replace(&mut last, now.clone()) && now != before;
            rests.then_some(now)
        })
    };
    let framed = moved("f");
    person.point([x, y]);
    let top = moved("t");
    assert!(framed != start.1 && top != framed);
    for (key, wanted) in [
        ("alt+Left", &framed),
        ("alt+Left", &start.1),
        ("alt+Left", &start.1),
        ("alt+Right", &framed),
        ("alt+Right", &top),
        ("alt+Left", &framed),
    ] {
        person.keys(&[key]);
        let info = seen(&display, folder).1;
        assert!(info == *wanted, "{key}: {info} instead of {wanted}");
    }
    if is_full() {
        person.click("Button", "Previous view");
    } else {
        person.keys(&["alt+Left"]);
    }
    until("the start", || (seen(&display, folder).1 == start.1).then_some(()));
    assert!(seen(&display, folder) == start, "the start is another picture");
    assert!(program.0.try_wait().unwrap().is_none(), "{}", std::fs::read_to_string(folder.join("stderr")).unwrap());
}
