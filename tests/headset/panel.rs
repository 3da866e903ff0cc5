//! Tests the panel in the headset: what it says and when, where it is, and what its lists do.

use hachure::internals::{control_names, with_control};
use hachure::style::Style;

use crate::Room;
use crate::common::full;
use crate::pictures::difference;

/// Colour of the panel behind its text, in sRGB.
const PAPER: [u8; 3] = [26, 28, 33];
const SIZE_PX: [usize; 2] = [1024, 768];

/// A frame with the panel.
struct Shown {
    /// Frame of the script, 0 until the world is seen.
    frame: u64,
    /// Position, orientation and size.
    numbers: [f64; 9],
    space: String,
    /// Name of the image's file.
    file: String,
}

/// Flies with a script, and returns the log's last line, the report, and the frames with the panel.
fn fly(room: &Room, script: &[(&str, &str)], arguments: &[&str]) -> (String, String, Vec<Shown>) {
    let dump = room.path("dump");
    let _ = std::fs::remove_dir_all(&dump);
    std::fs::create_dir(&dump).unwrap();
    let script = [script, &[("DUMP", dump.to_str().unwrap())]].concat();
    let run = room.fly(&script, arguments);
    let report = run.well("panel").to_owned();
    let table = std::fs::read_to_string(dump.join("quads.csv")).unwrap_or_default();
    let shown = table.lines().map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        Shown {
            frame: cells[1].parse().unwrap(),
            numbers: std::array::from_fn(|i| cells[2 + i].parse().unwrap()),
            space: cells[11].to_owned(),
            file: cells[12].to_owned(),
        }
    });
    (run.log.lines().last().unwrap_or_default().to_owned(), report, shown.collect())
}

/// Returns the part of the rows of a panel's picture, between two of them, on which there is something to read.
fn written(bytes: &[u8], from: usize, to: usize) -> f64 {
    let is_ink = |pixel: &[u8]| (0..3).any(|i| pixel[i].abs_diff(PAPER[i]) > 90);
    let width = SIZE_PX[0];
    let rows = bytes.chunks_exact(4 * width).take(to).skip(from);
    let count = rows.filter(|row| row[160..4 * width - 160].chunks_exact(4).any(is_ink)).count();
    count as f64 / (to - from) as f64
}

#[test]
fn the_panel_is_seen_from_the_first_frame_and_stays_in_its_place() {
    let Some(room) = Room::with_hill() else { return };
    let (log, _, shown) = fly(&room, &[], &["--frames", "20", "--style", "lsa"]);
    assert!(log.ends_with(" and 0 empty frames"), "{log}");
    // Before the first picture, and with it, because no button was pressed.
    assert!(shown.iter().any(|shown| shown.frame == 0) && shown.iter().any(|shown| shown.frame >= 19));
    for Shown { numbers, space, .. } in &shown {
        // In the room, not at the head, which moves: always at the same place.
        assert!(space.contains("STAGE"), "{space}");
        assert_eq!(*numbers, shown[0].numbers);
    }
    let [x, y, z, _, qy, _, qw, width, height] = shown[0].numbers;
    // Two metres from the head, which the script begins with at (0, 1.6, 0.1), a little below its height, upright, and
    // facing it.
    let off = [x, z - 0.1];
    assert!((off[0].hypot(off[1]) - 2.0).abs() < 0.1 && (y - 1.45).abs() < 0.05, "{x} {y} {z}");
    assert!((qy.hypot(qw) - 1.0).abs() < 1e-3 && (2.0 * qw * qy * 2.0 + off[0]).abs() < 0.1, "{qy} {qw}");
    // Letters are 28 of 768 pixels high.
    let letter_deg = (28.0 / 768.0 * height / 2.0).atan().to_degrees();
    assert!(letter_deg > 1.5 && (width / height - 4.0 / 3.0).abs() < 1e-6, "{letter_deg}");
    let picture = |shown: &Shown| std::fs::read(room.path("dump").join(&shown.file)).unwrap();
    for shown in [&shown[0], &shown[shown.len() - 1]] {
        let bytes = picture(shown);
        // Title, controls, and the last line.
        for (from, to) in [(40, 90), (130, 620), (700, 740)] {
            let found = written(&bytes, from, to);
            assert!(found > 0.4, "{} {from}-{to}: {found}", shown.file);
        }
    }
    // What is being done changes.
    assert!(picture(&shown[0]) != picture(&shown[shown.len() - 1]));
    // Planted: a blank panel.
    let blank = [PAPER[0], PAPER[1], PAPER[2], 255].repeat(SIZE_PX[0] * SIZE_PX[1]);
    assert_eq!(written(&blank, 130, 620), 0.0);
}

#[test]
fn a_button_closes_the_panel_and_another_one_shows_it_again() {
    let Some(room) = Room::with_hill() else { return };
    let pushes = "6-8:/user/hand/right/input/a/click,40-42:/user/hand/left/input/y/click";
    let (_, _, shown) = fly(&room, &[("PUSHES", pushes)], &["--frames", "60", "--style", "plain"]);
    let frames: Vec<u64> = shown.iter().map(|shown| shown.frame).collect();
    assert!(frames.contains(&5) && frames.contains(&55), "{frames:?}");
    assert!(!frames.iter().any(|frame| (9..39).contains(frame)), "{frames:?}");
    // It is opened in front of the eyes, which have turned.
    assert!(shown[0].numbers != shown[shown.len() - 1].numbers);
}

/// Pushes of a stick or a button, one after another from a frame on, each for two frames.
fn pushes(from: u64, what: &[&str]) -> String {
    let all = what.iter().zip(0..).map(|(what, i)| format!("{}-{}:{what}", from + 4 * i, from + 4 * i + 2));
    all.collect::<Vec<_>>().join(",")
}

#[test]
fn the_list_of_styles_changes_the_style() {
    let Some(room) = Room::with_hill() else { return };
    // `hokusai` is the eighth favourite; below it is `relief`, which remembers nothing of the frames before.
    let down = pushes(6, &["/user/hand/right/input/thumbstick:0:-1"]);
    let script = format!("4-14:/user/hand/right/input/trigger/value,{down}");
    let relief = Style::load("relief").unwrap();
    let off = difference(&room, &[("PUSHES", &script)], ("hokusai", "40"), &relief, 1.0);
    assert!(off < 0.01, "{off} of the pixels differ");
    // Planted: a list that is only opened changes nothing.
    let opened = [("PUSHES", "4-14:/user/hand/right/input/trigger/value")];
    let off = difference(&room, &opened, ("hokusai", "40"), &relief, 1.0);
    assert!(off > 0.03, "{off}");
}

#[test]
fn every_controller_has_the_list_and_the_controls() {
    let Some(room) = Room::with_hill() else { return };
    let held = |frames: &str, path: &str| format!("{frames}:{path}");
    let down = |path: &str| pushes(60, &[&format!("{path}:0:-1")]);
    let right_stick = "/user/hand/right/input/thumbstick";
    // Those of the fast tier, which differ from that of the other tests, come first.
    for (profile, button, next) in [
        ("htc/vive_controller", "/user/hand/right/input/trigger/value", down("/user/hand/right/input/trackpad")),
        (
            "khr/simple_controller",
            "/user/hand/right/input/select/click",
            pushes(60, &["/user/hand/left/input/select/click"]),
        ),
        ("oculus/touch_controller", "/user/hand/right/input/trigger/value", down(right_stick)),
        ("valve/index_controller", "/user/hand/right/input/trigger/value", down(right_stick)),
        ("microsoft/motion_controller", "/user/hand/right/input/trigger/value", down(right_stick)),
    ]
    .into_iter()
    .take(if full() { 5 } else { 2 })
    {
        let profile = format!("/interaction_profiles/{profile}");
        // Held for more than 0.4 s, which are 36 frames.
        let script = format!("{},{next}", held("4-80", button));
        let script = [("PUSHES", script.as_str()), ("PROFILE", &profile), ("SIZES", "48x40,48x40")];
        let (_, report, shown) = fly(&room, &script, &["--frames", "90", "--style", "ink"]);
        // Below `ink` is `pen`.
        assert!(report.contains(" pen: "), "{profile}: {report}");
        assert!(shown.iter().any(|shown| shown.frame == 70) && !shown.iter().any(|shown| shown.frame == 90));
    }
}

#[test]
fn the_five_controls_change_the_picture_as_the_inspector_does() {
    let Some(room) = Room::with_hill() else { return };
    let stick = |x: i32, y: i32| format!("/user/hand/right/input/thumbstick:{x}:{y}");
    let (down, right, left) = (stick(0, -1), stick(1, 0), stick(-1, 0));
    let warmth = control_names().iter().position(|name| *name == "Warmth").unwrap();
    // Down to the last control, three steps to the right and one back.
    let mut what = vec![down.as_str(); warmth];
    what.extend([right.as_str(), &right, &right, &left]);
    let script = format!("4-50:/user/hand/left/input/trigger/value,{}", pushes(8, &what));
    let warm = with_control("lsa", "Warmth", 20).unwrap();
    let off = difference(&room, &[("PUSHES", &script)], ("lsa", "70"), &warm, 1.0);
    assert!(off < 0.01, "{off} of the pixels differ");
    // Planted: the style without the change, and with a further step.
    let others = [with_control("lsa", "Warmth", 40).unwrap(), Style::load("lsa").unwrap()];
    for other in others.into_iter().take(if full() { 2 } else { 1 }) {
        let off = difference(&room, &[("PUSHES", &script)], ("lsa", "70"), &other, 1.0);
        assert!(off > 0.03, "{off}");
    }
    // The edits are kept for the window.
    let kept = std::fs::read_dir(room.path("cache")).unwrap().flatten().map(|entry| entry.path().join("unsaved"));
    let files: Vec<_> = kept.filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten().collect();
    assert_eq!(files.len(), 1, "{files:?}");
}
