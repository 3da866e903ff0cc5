//! Tests flights from start to end: styles, sizes, states of the session, buttons, and error messages for missing
//! things.

use crate::Room;
use crate::common::full;

/// One style of each kind: chained strokes, marks, and in the long tier lines and running colour.
const STYLES: [&str; 4] = ["pen", "crosshatch", "lsa", "wash"];

#[test]
fn flights_end_well_and_nobody_complains() {
    let Some(room) = Room::with_hill() else { return };
    let (styles, frames) = if full() { (4, 24) } else { (2, 12) };
    // With a visibility mask, with one that changes, and without a mask.
    let masks = [&[("MASK", "corners")][..], &[("MASK", "7")], &[], &[]];
    for (style, mask) in STYLES.into_iter().zip(masks).take(styles) {
        let run = room.fly(mask, &["--frames", &frames.to_string(), "--style", style]);
        let report = run.well(style);
        assert!(report.starts_with(&format!("96x80 and 96x80 {style}: {frames} frames")), "{report}");
        assert!(run.log.contains(&format!("ended after {frames} frames")), "{}", run.log);
    }
}

/// Takes some minutes: `cargo test --release --test headset -- --ignored a_thousand`.
#[test]
#[ignore = "it takes many minutes"]
fn a_thousand_frames_of_every_style() {
    let Some(room) = Room::with_hill() else { return };
    for style in hachure::style::names() {
        room.fly(&[("SIZES", "48x40,48x40")], &["--frames", "1000", "--style", style]).well(style);
    }
}

#[test]
fn eyes_of_any_size_are_drawn() {
    let Some(room) = Room::with_hill() else { return };
    for sizes in ["1x1,1x1", "33x17,96x80"] {
        let style = if full() { "lsa" } else { "plain" };
        let report = room.fly(&[("SIZES", sizes)], &["--frames", "6", "--style", style]);
        let report = report.well(sizes);
        assert!(report.starts_with(&sizes.replace(',', " and ")), "{report}");
    }
}

/// No frame of a software driver takes as little as a fiftieth of a millisecond, and none takes a minute.
#[test]
fn a_budget_lowers_the_resolution() {
    let Some(room) = Room::with_hill() else { return };
    let fly = |script: &[(&str, &str)], budget_ms: &str| {
        let frames = if full() { "40" } else { "20" };
        let run = room.fly(script, &["--frames", frames, "--style", "pen", "--budget", budget_ms]);
        run.well(budget_ms).to_owned()
    };
    let low = fly(&[], "0.02");
    assert!(low.contains(" at the end: resolution 0.5"), "{low}");
    let high = fly(&[], "60000");
    assert!(high.contains(" 0 changes; at the end: as set"), "{high}");
    // The runtime's own work comes too late for some time.
    let hot = fly(&[("HOT", "4-9")], "60000");
    assert!(hot.contains("1 notice of the runtime that the GPU is too slow"), "{hot}");
    assert!(!high.contains("notice"), "{high}");
}

#[test]
fn every_kind_of_format_is_drawn_on() {
    let Some(room) = Room::with_hill() else { return };
    for format in ["50", "97", "37"] {
        room.fly(&[("FORMATS", format)], &["--frames", "4", "--style", "plain"]).well(format);
    }
}

#[test]
fn the_session_goes_through_its_states() {
    let Some(room) = Room::with_hill() else { return };
    for (script, frames) in [
        // The headset is taken off and put on again; ten frames are not drawn.
        (("OFF", "5-15"), 30),
        // The runtime ends the session and lets it begin again; one more frame is ended.
        (("PAUSE", "5"), 21),
        // The user ends the program.
        (("STOP", "7"), 8),
        // The head is not tracked for a while.
        (("TRACKING", "4-9"), 25),
        // No stage was set up.
        (("STAGE", "none"), 20),
    ]
    .into_iter()
    .take(if full() { 5 } else { 3 })
    {
        let run = room.fly(&[script], &["--frames", "20", "--style", "plain"]);
        run.well(script.0);
        assert!(run.log.contains(&format!("ended after {frames} frames")), "{script:?}: {}", run.log);
    }
}

#[test]
fn what_is_lost_is_one_line() {
    let Some(room) = Room::with_hill() else { return };
    for (name, lost) in [
        ("LOSE_SESSION", "its session"),
        ("BREAK_INSTANCE", "the runtime"),
        ("BREAK_SESSION", "its session"),
        ("LOSE_INSTANCE", "the runtime"),
    ]
    .into_iter()
    .take(if full() { 4 } else { 2 })
    {
        let run = room.fly(&[(name, "5")], &["--frames", "20", "--style", "plain"]);
        assert!(run.line().starts_with(&format!("--vr: the connection to the headset was lost ({lost})")), "{name}");
        assert!(run.stdout.is_empty(), "{name}: {}", run.stdout);
    }
}

#[test]
fn what_is_missing_is_one_line() {
    let Some(room) = Room::with_hill() else { return };
    // A file that is not a loader.
    std::fs::create_dir(room.path("libraries")).unwrap();
    std::fs::write(room.path("libraries/libopenxr_loader.so.1"), "no library").unwrap();
    let folder = room.path("libraries");
    for (script, words) in [
        (&[("=LD_LIBRARY_PATH", folder.to_str().unwrap())][..], "no OpenXR loader"),
        (&[("=XR_RUNTIME_JSON", "/nonexistent/runtime.json")], "no OpenXR runtime is active"),
        (&[("HEADSET", "none")], "finds no headset; connect the headset"),
        // Runtimes whose service is not running say so in several ways.
        (&[("SERVICE", "-2")], "an OpenXR runtime is active, but it does not answer (xrCreateInstance: "),
        (&[("SERVICE", "-51")], "an OpenXR runtime is active, but it does not answer (xrCreateInstance: "),
        (&[("SERVICE", "-6")], "its service is not running, or the headset is not connected; start the service"),
        (&[("SYSTEM", "-2")], "an OpenXR runtime is active, but it does not answer (xrGetSystem: "),
        (&[("SERVICE", "-4")], "failed in xrCreateInstance"),
        (&[("VULKAN", "none")], "lacks XR_KHR_vulkan_enable2"),
        (&[("FORMATS", "1")], "lacks a supported colour format"),
        (&[("=VK_DRIVER_FILES", "/nonexistent"), ("=VK_ICD_FILENAMES", "/nonexistent")], "Vulkan cannot draw"),
    ] {
        let run = room.fly(script, &["--frames", "2"]);
        let line = run.line();
        assert!(line.starts_with("--vr: ") && line.contains(words), "{line}");
        let has_runtime = !words.contains("no OpenXR");
        assert!(!has_runtime || !line.contains("no OpenXR runtime is active"), "{line}");
    }
    // An error in the world is reported before a missing headset.
    let mut command = room.command(env!("CARGO_BIN_EXE_hachure").as_ref(), &[("HEADSET", "none")]);
    command.args(["fly", "nowhere.tif", "--vr"]);
    assert!(room.run(command).line().contains("nowhere.tif"));
}

#[test]
fn buttons_are_heard() {
    let Some(room) = Room::with_hill() else { return };
    let names = hachure::style::names();
    let place = names.iter().position(|name| *name == "plain").unwrap();
    let next = names[(place + 1) % names.len()];
    let simple = "/interaction_profiles/khr/simple_controller";
    for script in [
        &[("PUSHES", "4-7:/user/hand/right/input/b/click")][..],
        &[("PUSHES", "4-7:/user/hand/right/input/select/click"), ("PROFILE", simple)],
    ]
    .into_iter()
    .take(if full() { 2 } else { 1 })
    {
        let run = room.fly(script, &["--frames", "16", "--style", "plain"]);
        let report = run.well("a button");
        assert!(
            report.starts_with(&format!("96x80 and 96x80 {next}: ")),
            "holding a button once must be one step: {report}"
        );
    }
    // The other hand has no such button.
    let run = room.fly(&[("PUSHES", "4-7:/user/hand/left/input/b/click")], &["--frames", "12", "--style", "plain"]);
    assert!(run.well("no button").contains(" plain: "));
}
