//! The sea, the trees and exaggeration are changed in flight, one after the other; a picture of the window is drawn again
//! from its imprint.

use std::path::Path;
use std::time::Duration;

use hachure::file::png::read_rgba8;

use crate::display::{Display, can_run, hachure, is_full, open_with, until};
use crate::person::Person;
use crate::{drawn_again, taken};

/// Runs the program and returns what it prints.
fn said(folder: &Path, arguments: &[&str]) -> String {
    let output = hachure(folder).args(arguments).env("XDG_RUNTIME_DIR", folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn changes_of_the_land_in_a_row_are_in_the_picture() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::of_size("900x640x24").expect("Xvfb must start");
    let widgets = folder.join("widgets");
    let environment = [("HACHURE_WIDGETS", &*widgets)];
    let (style, size) = if is_full() { ("ink", "900x640") } else { ("lsa", "600x640") };
    let arguments = ["--style", style, "--antialias", "none", "--size", size];
    let (_program, window) = open_with(&display, folder, &environment, &arguments);
    let person = Person { display: &display, window, widgets, frame: Duration::from_millis(300) };
    person.find("ComboBox", "Drawn style");
    if !is_full() {
        // A coarser picture of the window leaves more time for its screenshots.
        person.keys(&["minus", "minus"]);
    }
    for (section, within) in [("Camera", "Clearance"), ("Light", "Sun azimuth")] {
        person.click("DisclosureTriangle", section);
        // What is below moves until the section is closed.
        until("a closed section", || person.see("Slider", within).is_none().then_some(()));
    }

    // The sea rises while the slider is held.
    person.click("CheckBox", "Sea");
    let sea = || person.find("Slider", "Sea level");
    let before = sea();
    let [x, y] = Person::middle(&before);
    // In a slow frame the slider may not be enabled yet; then it is dragged again.
    until("the sea", || {
        display.key(&["mouseup", "1"]);
        person.point([x, y]);
        display.key(&["mousedown", "1"]);
        person.point([x + 10.0, y]);
        std::thread::sleep(Duration::from_secs(1));
        Some(sea()).filter(|now| now.value != before.value)
    });
    display.key(&["mouseup", "1"]);

    let are_trees = |wanted: bool| person.see("SpinButton", "Tree seed").filter(|seed| seed.is_disabled != wanted);
    person.click_until("CheckBox", "Trees", || are_trees(true));
    let seed =
        person.click_until("Button", "Tree seed, next", || are_trees(true).filter(|seed| seed.value != "1")).value;
    let level = sea().value;
    let wooded = taken(&display, folder);
    let info = said(folder, &["info", wooded.to_str().unwrap()]);
    assert!(info.contains(&format!("trees     {seed}\n")), "{seed}: {info}");
    assert!(info.contains(&format!("sea_level {level}")), "{level}: {info}");
    let again = drawn_again(folder, &wooded, &[]);
    let wooded = read_rgba8(&wooded).unwrap();
    assert!(again == wooded);

    // The land is read with another exaggeration, and the trees go, mostly before that is done.
    person.fill("SpinButton", "Exaggeration, number", "2");
    person.click_until("CheckBox", "Trees", || are_trees(false));
    let high = until("the high land without trees", || {
        std::thread::sleep(Duration::from_millis(500));
        let path = taken(&display, folder);
        let info = said(folder, &["info", path.to_str().unwrap()]);
        (info.contains("exaggeration 2") && !info.contains("trees ")).then_some(path)
    });
    assert!(said(folder, &["info", high.to_str().unwrap()]).contains("sea_level"));
    let again = drawn_again(folder, &high, &[]);
    let high = read_rgba8(&high).unwrap();
    assert!(again == high);
    // Planted: the picture before is another one.
    assert!(high != wooded);
}
