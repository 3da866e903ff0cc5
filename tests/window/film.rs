//! A film of a camera path that is made in the window: to its end, and cancelled.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hachure::file::png::read_rgba8;

use crate::display::{Display, can_run, until};
use crate::exports::{Exporter, files, run_line, unlike};
use crate::person::Widget;

/// Size of the frames in pixels.
const SIZE_PX: [u32; 2] = [160, 100];

/// Returns the names in a folder, without those of the window itself.
fn names(folder: &Path) -> Vec<String> {
    let names = folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name != "stderr").collect();
    names.sort();
    names
}

/// Returns the names of files that are being written.
fn partial(folder: &Path) -> Vec<String> {
    names(folder).into_iter().filter(|name| name.ends_with(".part")).collect()
}

/// Cancels the export that writes a file of this name.
fn cancel(exporter: &Exporter<'_>, name: &str) {
    let name = format!("Cancel: Exporting {name}");
    exporter.person.click("Button", &name);
    until("the end", || exporter.person.see("Button", &name).is_none().then_some(()));
}

#[test]
fn a_film_of_the_path_panel_is_drawn_and_cancelled() {
    if !can_run() {
        return;
    }
    let [folder, again] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [folder, again] = [folder.path(), again.path()];
    let display = Display::of_size("900x640x24").expect("Xvfb must start");
    let (mut program, exporter) = Exporter::open(&display, folder);
    std::fs::copy(folder.join("cone.tif"), again.join("cone.tif")).unwrap();
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let person = &exporter.person;

    // A path of two keys, which lasts a second.
    person.keys(&["v"]);
    person.click("Button", "Add key");
    person.find("Button", "Delete key 1");
    display.key(&["keydown", "w"]);
    std::thread::sleep(Duration::from_millis(400));
    display.key(&["keyup", "w"]);
    std::thread::sleep(Duration::from_millis(600));
    person.click("Button", "Add key");
    person.find("Button", "Delete key 2");
    person.fill("SpinButton", "Duration of the path", "1");

    // Its film, as frames.
    person.click("Button", "Render film…");
    person.fill("SpinButton", "Width in pixels", &SIZE_PX[0].to_string());
    person.fill("SpinButton", "Height in pixels", &SIZE_PX[1].to_string());
    person.fill("SpinButton", "Frames per second", "3");
    person.fill("TextInput", "Path of the output", "film.mp4");
    person.click("Button", "frames");
    let line = exporter.line("film/%05d.png", "--fps=3");
    person.click("Button", "Export");
    exporter.wait_for("film/%05d.png");
    let drawn = files(&folder.join("film"));
    let wanted: Vec<PathBuf> = (0..4).map(|frame| PathBuf::from(format!("{frame:05}.png"))).collect();
    assert_eq!(drawn.keys().cloned().collect::<Vec<_>>(), wanted);
    let frames = wanted.iter().map(|name| read_rgba8(&folder.join("film").join(name)).unwrap());
    let frames: Vec<_> = frames.inspect(|frame| assert_eq!([frame.width, frame.height], SIZE_PX)).collect();
    assert!(frames[0] != frames[1] && frames[1] != frames[3], "the camera does not move");
    run_line(&line, again, folder);
    let by_line = files(&again.join("film"));
    assert_eq!(unlike(&drawn, &by_line), None, "{line}");
    // Planted: the frames of another rate are others.
    run_line(&line.replace("--fps=3", "--fps=6"), again, folder);
    assert!(unlike(&drawn, &files(&again.join("film"))).is_some());

    // A longer film is cancelled after some frames: those are whole.
    person.fill("SpinButton", "Frames per second", "50");
    person.fill("TextInput", "Path of the output", "long/%05d.png");
    exporter.line("long/%05d.png", "--fps=50");
    person.click("Button", "Export");
    let long = folder.join("long");
    until("some frames", || (long.exists() && names(&long).len() > 2).then_some(()));
    cancel(&exporter, "%05d.png");
    let left = names(&long);
    assert!(partial(&long).is_empty() && left.len() < 50, "{left:?}");
    for name in &left {
        assert_eq!(read_rgba8(&long.join(name)).unwrap().width, SIZE_PX[0], "{name}");
    }
    // In one file, nothing is left.
    person.click("Button", ".gif");
    exporter.line("long.gif", "--fps=50");
    let before = names(folder);
    person.click("Button", "Export");
    let is_drawing = |widget: &Widget| {
        widget.role == "ProgressIndicator"
            && widget.name == "drawing"
            && widget.value.parse().is_ok_and(|done: f64| done > 3.0)
    };
    until("some frames", || person.all().into_iter().find(is_drawing));
    cancel(&exporter, "long.gif");
    assert_eq!(names(folder), before, "a cancelled film leaves no file");
    // Planted: a file that is left is found.
    std::fs::write(folder.join(".long.gif.abc.part"), b"").unwrap();
    assert!(names(folder) != before && partial(folder) == [".long.gif.abc.part"]);
    assert!(person.beginning("Button", "Dismiss: ").is_none(), "nobody has to be told what they did");
    assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
    assert!(!printed().contains("ERROR") && !printed().contains("panicked"), "{}", printed());
}
