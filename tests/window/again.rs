//! `hachure` alone opens the world of the last flight.

use std::path::Path;
use std::process::Stdio;

use crate::display::{Display, Running, can_run, hachure, open, take_picture, until, write_dem};

/// Flies without arguments until the window has a title, which is returned with what was printed.
fn titled(display: &Display, folder: &Path, arguments: &[&str]) -> (String, String) {
    let errors = folder.join("stderr of the next flight");
    let mut command = hachure(folder);
    command.args(arguments).env("DISPLAY", &display.name).env("XDG_RUNTIME_DIR", folder);
    command.stdin(Stdio::null()).stderr(std::fs::File::create(&errors).unwrap());
    let printed = || std::fs::read_to_string(&errors).unwrap();
    let mut program = Running(command.spawn().unwrap());
    let title = until("a window", || {
        assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
        let window = display.xdotool(&["search", "--onlyvisible", "--name", "hachure"])?;
        display.xdotool(&["getwindowname", window.lines().next()?])
    });
    (title, printed())
}

#[test]
fn hachure_alone_opens_the_world_of_the_last_flight() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::open().expect("Xvfb must start");
    let (mut program, _) = open(&display, folder, &[]);
    // The world is open when it is drawn.
    take_picture(&display, folder);
    display.key(&["key", "Escape"]);
    display.key(&["key", "Escape"]);
    until("the end", || program.0.try_wait().unwrap());
    let (title, printed) = titled(&display, folder, &[]);
    assert!(title.contains("cone") && !printed.contains("WARN"), "{title}: {printed}");
    // `fly` draws what its arguments say.
    let (title, _) = titled(&display, folder, &["fly", "hut"]);
    assert!(!title.contains("cone"), "{title}");
    // A world that is gone is no reason not to start.
    std::fs::rename(folder.join("cone.tif"), folder.join("moved.tif")).unwrap();
    let (title, printed) = titled(&display, folder, &[]);
    assert!(!title.contains("cone"), "{title}");
    let warning = printed.lines().find(|line| line.contains("cone.tif")).unwrap_or_default();
    assert!(warning.contains("the built-in world is opened"), "{printed}");
}

#[test]
fn a_drawing_is_no_world_of_a_flight() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::open().expect("Xvfb must start");
    write_dem(&folder.join("cone.tif"));
    let run = |arguments: &[&str]| {
        let mut command = hachure(folder);
        command.args(arguments).env("DISPLAY", &display.name).env("XDG_RUNTIME_DIR", folder);
        let output = command.stdin(Stdio::null()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let drawing = ["render", "cone.tif", "-o", "cone.png", "--size", "64x36", "--style", "plain"];
    assert_eq!(run(&drawing).0, Some(0));
    let (status, said) = run(&["fly", "cone.png"]);
    let error = said.lines().find(|line| line.starts_with("hachure: ")).unwrap_or_default();
    let words = "cone.png: a picture that hachure drew, not land; draw it again with hachure render --like cone.png";
    assert!(status == Some(1) && error.contains(words), "{said}");
    // Planted: another file that is no land is refused with other words.
    std::fs::copy(folder.join("cone.png"), folder.join("cut.png")).unwrap();
    std::fs::File::options().write(true).open(folder.join("cut.png")).unwrap().set_len(60).unwrap();
    let (status, said) = run(&["fly", "cut.png"]);
    assert!(status == Some(1) && said.contains("cut.png") && !said.contains("hachure drew"), "{said}");
}
