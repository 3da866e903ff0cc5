//! A person at work, with real events of mouse and keyboard, at five frames a second and at one: no click is lost or
//! misread.

use std::path::Path;
use std::time::Duration;

use hachure::file::png::read_rgba8;

use crate::display::{Display, can_run, is_full, open_with, until};
use crate::drop;
use crate::person::Person;

fn work_at(frame_ms: u64) {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::of_size("900x640x24").expect("Xvfb must start");
    let (widgets, frame) = (folder.join("widgets"), frame_ms.to_string());
    let environment = [("HACHURE_WIDGETS", &*widgets), ("HACHURE_FRAME_MS", Path::new(&frame))];
    let arguments = ["--style", "plain", "--size", "900x640"];
    let (mut program, window) = open_with(&display, folder, &environment, &arguments);
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let person = Person { display: &display, window, widgets, frame: Duration::from_millis(frame_ms) };

    // Another DEM is dropped on the window.
    std::fs::copy(folder.join("cone.tif"), folder.join("hill.tif")).unwrap();
    person.find("ComboBox", "Drawn style");
    if !is_full() {
        // A coarser picture of the window takes less time.
        person.keys(&["minus", "minus"]);
    }
    assert!(drop::file(&display.name, &person.window, &folder.join("hill.tif"), [500, 300]), "{}", printed());
    until("the world", || display.xdotool(&["getwindowname", &person.window]).filter(|name| name.contains("hill")));

    // A preset is chosen from the list.
    person.click("ComboBox", "Drawn style");
    person.click("Button", "ink");
    until("the style", || person.see("ComboBox", "Drawn style").filter(|list| list.value == "ink"));

    // A slider of the inspector is dragged, and that is one step.
    person.keys(&["i"]);
    let density = || person.find("Slider", "Density");
    let before = density();
    assert_eq!(before.value, "0");
    let [x, y] = Person::middle(&before);
    person.point([x, y]);
    display.key(&["mousedown", "1"]);
    for step in 1..=4 {
        person.point([x + 8.0 * f64::from(step), y]);
        std::thread::sleep(Duration::from_millis(60));
    }
    display.key(&["mouseup", "1"]);
    // Slow frames may still show a part of the drag.
    let mut last = String::new();
    let after = until("the drag", || {
        let now = density().value;
        let rests = now == std::mem::replace(&mut last, now.clone());
        Some(now).filter(|value| rests && value != "0")
    });
    person.keys(&["ctrl+z"]);
    until("the undone drag", || (density().value == "0").then_some(()));
    person.keys(&["ctrl+shift+z"]);
    until("the drag again", || (density().value == after).then_some(()));

    // The style is saved under a name.
    person.keys(&["ctrl+shift+s"]);
    person.click("TextInput", "Name of the new style file");
    person.keys(&["ctrl+a"]);
    display.key(&["type", "--delay", "20", "own.toml"]);
    until("the name", || {
        Some(person.find("TextInput", "Name of the new style file")).filter(|it| it.value == "own.toml")
    });
    person.keys(&["Return"]);
    let style = folder.join("own.toml");
    until("the style file", || std::fs::read_to_string(&style).ok().filter(|text| text.contains("ink")));

    // A picture is exported: its size and its name are those of the dialog.
    person.keys(&["ctrl+e"]);
    person.click("Button", "paper");
    // Somebody types faster than frames are drawn: a click must not overtake the keys before it.
    let [dots, title] = [("SpinButton", "Dots per inch"), ("TextInput", "Title below the picture")]
        .map(|(role, name)| Person::middle(&person.find(role, name)));
    person.point(dots);
    display.key(&["click", "1"]);
    person.keys(&["ctrl+a"]);
    display.key(&["type", "--delay", "10", "40"]);
    person.keys(&["Return"]);
    person.point(title);
    display.key(&["click", "1"]);
    display.key(&["type", "--delay", "10", "My hill"]);
    let value = |role, name| person.find(role, name).value;
    until("the title", || (value("TextInput", "Title below the picture") == "My hill").then_some(()));
    assert_eq!(value("SpinButton", "Dots per inch"), "40");
    let output = person.find("TextInput", "Path of the output").value;
    let output = folder.join(output);
    assert!(!output.exists(), "{output:?}");
    person.click("Button", "Export");
    let picture = until("the export", || read_rgba8(&output).ok());
    // A3 at 40 dots per inch.
    assert!(picture.width == 661 && picture.height == 468, "{} {}", picture.width, picture.height);
    // Planted: it is a picture of the new world in the new style, so its imprint names both.
    let imprint = crate::hachure(folder).args(["info", "--json"]).arg(&output).env("XDG_RUNTIME_DIR", folder).output();
    let imprint = String::from_utf8(imprint.unwrap().stdout).unwrap();
    assert!(imprint.contains("hill.tif") && !imprint.contains("cone.tif"), "{imprint}");

    // Nothing is left to save, so two presses of Esc leave. The first one before them closes the dialog.
    person.keys(&["Escape"]);
    until("the closed dialog", || person.see("TextInput", "Path of the output").is_none().then_some(()));
    // The second one dismisses the message of the export.
    until("the message", || person.beginning("Button", "Dismiss: Wrote "));
    person.keys(&["Escape"]);
    until("the dismissed message", || person.beginning("Button", "Dismiss: ").is_none().then_some(()));
    person.keys(&["Escape"]);
    person.keys(&["Escape"]);
    let status = until("the end", || program.0.try_wait().unwrap());
    assert_eq!(status.code(), Some(0), "{}", printed());
    assert!(!printed().contains("ERROR") && !printed().contains("panicked"), "{}", printed());
}

#[test]
fn a_person_works_at_five_frames_a_second() {
    work_at(200);
}

/// Is in the long tier, because it waits for a minute. `window::panel::tests` clicks in slow frames, too.
#[test]
fn a_person_works_at_one_frame_a_second() {
    if is_full() {
        work_at(1000);
    }
}
