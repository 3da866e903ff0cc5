//! A model that is dropped on the window replaces the world.

use crate::display::{Display, can_run, open_with, settled, until};
use crate::{drawn_again, drop, taken};
use hachure::file::png::read_rgba8;

/// A tent of 4 × 3 × 5 m.
const TENT: &str = "v 0 0 0\nv 4 0 0\nv 4 0 5\nv 0 0 5\nv 2 3 0\nv 2 3 5\nf 1 4 6 5\nf 2 5 6 3\nf 4 3 6\nf 1 5 2\n";

#[test]
fn a_model_is_dropped_and_drawn_again() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::open().expect("Xvfb must start");
    let (mut program, window) = open_with(&display, folder, &[], &["--style", "plain", "-v"]);
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let title = || display.xdotool(&["getwindowname", &window]).unwrap_or_default();
    let cone = settled(&display, folder);

    // A broken model changes nothing, and its error names the file, the line and the cause.
    std::fs::write(folder.join("broken.obj"), TENT.replace("f 1 5 2", "f 1 5 99")).unwrap();
    assert!(drop::file(&display.name, &window, &folder.join("broken.obj"), [160, 100]), "{}", printed());
    let line = until("the error", || printed().lines().find(|line| line.contains("broken.obj")).map(str::to_owned));
    assert!(line.contains("line 10: the face uses vertex 99, but there are 6"), "{line}");
    assert!(title().contains("cone"), "{}", title());

    std::fs::write(folder.join("tent.obj"), TENT).unwrap();
    assert!(drop::file(&display.name, &window, &folder.join("tent.obj"), [160, 100]), "{}", printed());
    until("the model", || title().contains("tent").then_some(()));
    // Its picture is that of the program without a window.
    let path = taken(&display, folder);
    let tent = read_rgba8(&path).unwrap();
    assert!(tent != cone && (tent.width, tent.height) == (320, 200));
    assert!(drawn_again(folder, &path, &[]) == tent, "{}", printed());
    // Planted error: the model has changed.
    std::fs::write(folder.join("tent.obj"), TENT.replace("v 2 3 5", "v 2 4 5")).unwrap();
    assert!(drawn_again(folder, &path, &[]) != tent);

    // The camera keeps no more distance from the ground than suits a model: orbiting and flying leave it in view.
    display.key(&["keydown", "w"]);
    std::thread::sleep(std::time::Duration::from_millis(300));
    display.key(&["keyup", "w"]);
    let moved = read_rgba8(&taken(&display, folder)).unwrap();
    assert!(moved != tent, "W did not fly");
    assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
    assert!(!printed().contains("ERROR") && !printed().contains("panicked"), "{}", printed());
}
