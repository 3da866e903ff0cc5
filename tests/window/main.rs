//! Tests the window on a virtual display: it opens, reacts to keys and the mouse, writes pictures, and ends well.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

mod again;
mod budget;
mod display;
mod drawn;
mod drop;
mod exports;
mod film;
mod labels;
mod land;
mod latency;
mod model;
mod person;
mod studio;
mod undo;
mod walk;

use std::path::{Path, PathBuf};
use std::time::Duration;

use display::{Display, can_run, hachure, is_full, open, open_with, pictures, settled, take_picture, until};
use hachure::file::png::{Picture, read_rgba8};

#[test]
fn without_a_display_one_line_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for display in [None, Some(":987")] {
        let mut command = hachure(folder.path());
        command.env_remove("DISPLAY").envs(display.map(|name| ("DISPLAY", name)));
        let output = command.output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert_eq!(text.trim().lines().count(), 1, "{text}");
        assert!(text.contains("no display") && text.contains("hachure render"), "{text}");
    }
}

#[test]
fn a_shader_changes_while_it_flies() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let shaders = folder.join("shaders");
    std::fs::create_dir_all(shaders.join("composite")).unwrap();
    let composite = shaders.join("composite/composite.wgsl");
    let text = include_str!("../../shaders/composite/composite.wgsl");
    std::fs::write(&composite, text).unwrap();
    let display = Display::open().expect("Xvfb must start");
    let (mut program, _) = open(&display, folder, &[("HACHURE_SHADERS", &shaders)]);
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let start = settled(&display, folder);

    let inverted = text.replace("vec4<f32>(color, alpha)", "vec4<f32>(1.0 - color, alpha)");
    assert!(inverted != text);
    std::fs::write(&composite, &inverted).unwrap();
    let brightness = |picture: &Picture| {
        let sum: u64 = picture.rgba.chunks_exact(4).flat_map(|texel| &texel[..3]).map(|byte| u64::from(*byte)).sum();
        sum as f64 / (picture.rgba.len() / 4 * 3) as f64
    };
    // Paper is bright, so the inverted picture is dark.
    let is_dark = |picture: &Picture| brightness(picture) < brightness(&start) - 30.0;
    until("the change", || Some(take_picture(&display, folder)).filter(is_dark));
    // A picture that was being drawn when the shader changed has samples of both.
    let other = take_picture(&display, folder);
    // An invalid shader is reported in one line, and changes nothing.
    std::fs::write(&composite, text.replace("composite.paper;", "composite.papyrus;")).unwrap();
    let line = until("the message", || printed().lines().find(|line| line.contains("papyrus")).map(str::to_owned));
    let place = text.lines().position(|line| line.contains("composite.paper;")).unwrap() + 1;
    assert!(line.contains(&format!("composite/composite.wgsl:{place}:")), "{line}");
    assert!(take_picture(&display, folder) == other);
    std::fs::write(&composite, text).unwrap();
    until("the mended one", || (take_picture(&display, folder) == start).then_some(()));
    assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
    assert_eq!(printed().lines().filter(|line| line.contains("papyrus")).count(), 1, "{}", printed());
}

/// Returns the texts of the edits that are kept in the cache of `folder`.
fn kept_edits(folder: &Path) -> Vec<String> {
    let own = folder.join("cache").read_dir().into_iter().flatten().flatten().map(|entry| entry.path().join("unsaved"));
    let files = own.filter_map(|unsaved| unsaved.read_dir().ok()).flatten().flatten();
    files.filter_map(|file| std::fs::read_to_string(file.path()).ok()).collect()
}

#[test]
fn a_style_changes_while_it_flies() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let style = folder.join("own.toml");
    let text = include_str!("../../src/style/presets/ink.toml");
    std::fs::write(&style, text).unwrap();
    let display = Display::open().expect("Xvfb must start");
    let (mut program, _) = open_with(&display, folder, &[], &["--style", "own.toml"]);
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let start = settled(&display, folder);

    // The file is rewritten in place, and then replaced by another.
    let red = text.replace("color = \"#fbf6ea\"", "color = \"#ff0000\"");
    assert_ne!(red, text);
    let is_red = |picture: &Picture| {
        let sum =
            |channel: usize| -> u64 { picture.rgba.iter().skip(channel).step_by(4).map(|it| u64::from(*it)).sum() };
        sum(0) > 2 * sum(1)
    };
    std::fs::write(&style, &red).unwrap();
    until("the change", || is_red(&take_picture(&display, folder)).then_some(()));
    // What is not valid changes nothing.
    std::fs::write(&style, "name = ").unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert!(is_red(&take_picture(&display, folder)), "an invalid file changed the picture");
    let other = folder.join("other.toml");
    std::fs::write(&other, text).unwrap();
    std::fs::rename(&other, &style).unwrap();
    until("the first style", || (take_picture(&display, folder) == start).then_some(()));

    // Undoing gives the red paper again, which is then an edit that the file does not have.
    assert!(kept_edits(folder).is_empty());
    display.key(&["key", "ctrl+z"]);
    until("the undone change", || is_red(&take_picture(&display, folder)).then_some(()));
    until("the kept edit", || kept_edits(folder).iter().any(|kept| kept.contains("#ff0000")).then_some(()));
    assert_eq!(std::fs::read_to_string(&style).unwrap(), text, "nothing is saved that nobody saves");
    // Leaving asks once.
    display.key(&["key", "Escape"]);
    display.key(&["key", "Escape"]);
    std::thread::sleep(Duration::from_millis(500));
    assert!(program.0.try_wait().unwrap().is_none(), "it left with edits that are not saved: {}", printed());
    // A crash loses nothing, and the next start does not apply the edits by itself.
    program.0.kill().unwrap();
    program.0.wait().unwrap();
    assert!(kept_edits(folder).iter().any(|kept| kept.contains("#ff0000")));
    let (_again, _) = open_with(&display, folder, &[], &["--style", "own.toml"]);
    assert!(settled(&display, folder) == start, "edits were applied by themselves");
    display.key(&["key", "ctrl+z"]);
    // A save without edits keeps the file.
    display.key(&["key", "ctrl+s"]);
    assert!(take_picture(&display, folder) == start);
    assert_eq!(std::fs::read_to_string(&style).unwrap(), text);
}

#[test]
fn flies_and_takes_pictures() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::open().expect("Xvfb must start");
    let (mut program, window) = open(&display, folder, &[]);
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();

    let start = settled(&display, folder);
    assert_eq!((start.width, start.height), (320, 200));
    let first = &start.rgba[..4];
    let others = start.rgba.chunks_exact(4).filter(|pixel| *pixel != first).count();
    assert!(others > 320 * 200 / 10, "the picture is nearly uniform: {others} pixels are not {first:?}");

    // Another style gives another picture, and going back gives the first one.
    display.key(&["key", "Next"]);
    assert!(take_picture(&display, folder) != start, "Page down changed nothing");
    display.key(&["key", "Prior"]);
    assert!(take_picture(&display, folder) == start, "Page up did not come back");

    // Another place gives another picture, too.
    display.key(&["keydown", "w"]);
    // Long enough for a frame while other programs compute.
    std::thread::sleep(Duration::from_millis(1500));
    display.key(&["keyup", "w"]);
    assert!(take_picture(&display, folder) != start, "W did not fly");
    display.key(&["key", "r"]);
    assert!(take_picture(&display, folder) == start, "R did not go back");

    // A smaller window gives a smaller picture.
    display.key(&["windowsize", &window, "200", "120"]);
    let size = until("the resize", || {
        let picture = take_picture(&display, folder);
        Some((picture.width, picture.height)).filter(|size| *size != (320, 200))
    });
    assert_eq!(size, (200, 120));

    display.key(&["key", "Escape"]);
    display.key(&["key", "Escape"]);
    let status = until("the end", || program.0.try_wait().unwrap());
    assert_eq!(status.code(), Some(0), "{}", printed());
    assert!(!printed().contains("ERROR") && !printed().contains("panicked"), "{}", printed());
}

/// Returns the path of the picture that F12 writes.
fn taken(display: &Display, folder: &Path) -> PathBuf {
    let before = pictures(folder);
    display.key(&["key", "F12"]);
    until("F12", || pictures(folder).into_iter().find(|path| !before.contains(path)))
}

/// Draws a picture again by its imprint, with more arguments.
fn drawn_again(folder: &Path, picture: &Path, arguments: &[&str]) -> Picture {
    let again = folder.join("again.png");
    let mut command = hachure(folder);
    command.arg("render").arg("--like").arg(picture).arg("-o").arg(&again).args(arguments);
    command.env("XDG_RUNTIME_DIR", folder);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    read_rgba8(&again).unwrap()
}

#[test]
fn a_picture_is_drawn_again_bit_for_bit() {
    if !can_run() {
        return;
    }
    // Strokes and hatching, watercolour, and map colours; the fast tier draws the first in a small window.
    let few = ["crosshatch", "wash", "relief"];
    let all = hachure::style::names();
    let [width, height] = if is_full() { [320, 200] } else { [200, 120] };
    let size = format!("{width}x{height}");
    for style in if is_full() { &all[..] } else { &few[..1] } {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let display = Display::open().expect("Xvfb must start");
        let arguments: [&str; 6] = ["--style", style, "--antialias", "temporal", "--size", &size];
        let (mut program, _) = open_with(&display, folder, &[], &arguments);
        let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
        // After a flight, the history of the window is not that of a single picture.
        display.key(&["keydown", "w"]);
        std::thread::sleep(Duration::from_millis(400));
        display.key(&["keyup", "w"]);
        std::thread::sleep(Duration::from_millis(1500));
        let path = taken(&display, folder);
        let picture = read_rgba8(&path).unwrap();
        assert_eq!((picture.width, picture.height), (width, height));
        assert!(drawn_again(folder, &path, &[]) == picture, "{style}: {}", printed());
        // Planted errors: another sun, and an edge that is smoothed less. Not all styles depend on the sun.
        if is_full() && few.contains(style) {
            assert!(drawn_again(folder, &path, &["--sun", "120,30"]) != picture, "{style}: another sun");
        }
        assert!(drawn_again(folder, &path, &["--samples", "8"]) != picture, "{style}: other samples");
        assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
    }
}

#[test]
fn the_mouse_navigates_by_the_place_under_the_cursor() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let display = Display::open().expect("Xvfb must start");
    let camera = "--camera=0,-3500,+900,0,-12,45";
    let (mut program, window) = open_with(&display, folder, &[], &[camera, "--style", "plain"]);
    let printed = || std::fs::read_to_string(folder.join("stderr")).unwrap();
    let start = take_picture(&display, folder);
    display.key(&["key", "h"]);
    let moves = |what: &str, arguments: &[&[&str]]| {
        for argument in arguments {
            display.key(argument);
            std::thread::sleep(Duration::from_millis(250));
        }
        until(what, || (take_picture(&display, folder) != start).then_some(()));
        display.key(&["key", "r"]);
        until(&format!("R after {what}"), || (take_picture(&display, folder) == start).then_some(()));
    };
    let at = ["mousemove", "--window", &window, "170", "120"];
    let beside = ["mousemove", "--window", &window, "230", "140"];
    moves("the wheel", &[&at, &["click", "4"]]);
    moves("the middle button", &[&at, &["mousedown", "2"], &beside, &["mouseup", "2"]]);
    // The first motion makes a drag of a press, and the next ones turn the view.
    let further = ["mousemove_relative", "25", "8"];
    moves("the left button", &[&at, &["mousedown", "1"], &beside, &further, &["mouseup", "1"]]);
    moves("a double click", &[&beside, &["click", "--repeat", "2", "--delay", "60", "1"]]);
    moves("the top view", &[&at, &["key", "t"]]);
    moves("frame all", &[&["key", "f"]]);
    moves("coordinates", &[&["key", "l"], &["type", "x100,y200"], &["key", "Return"]]);
    // A single click neither moves the camera nor captures the mouse.
    display.key(&at);
    display.key(&["click", "1"]);
    display.key(&beside);
    std::thread::sleep(Duration::from_millis(500));
    assert!(take_picture(&display, folder) == start, "a click moved the camera");
    assert!(program.0.try_wait().unwrap().is_none(), "{}", printed());
}
