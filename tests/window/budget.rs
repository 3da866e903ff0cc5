//! `fly --budget`: a governor lowers the resolution until frames take the time that was asked for.

use crate::display::{Display, can_run, hachure, is_full, write_dem};

/// What a flight printed.
struct Flown {
    width_px: u32,
    p50_ms: f64,
    /// The line about the governor.
    governed: Option<String>,
}

fn fly(display: &Display, folder: &std::path::Path, frames: u32, budget: &[&str]) -> Flown {
    let mut command = hachure(folder);
    command.args(["cone.tif", "--style", "wash", "--size", "480x270", "--antialias", "none"]);
    command.arg(format!("--frames={frames}")).args(budget).env("DISPLAY", &display.name).env("XDG_RUNTIME_DIR", folder);
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let number = |before: &str, after: &str| {
        let (_, rest) = text.split_once(before).unwrap();
        rest.split(after).next().unwrap().trim().parse::<f64>().unwrap()
    };
    Flown {
        width_px: text.split('x').next().unwrap().parse().unwrap(),
        p50_ms: number("p50", "ms"),
        governed: text.lines().find(|line| line.contains(" frames within ")).map(str::to_owned),
    }
}

#[test]
fn a_budget_is_held_by_the_resolution() {
    if !can_run() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_dem(&folder.join("cone.tif"));
    let display = Display::open().expect("Xvfb must start");
    let frames = if is_full() { 60 } else { 20 };
    let fly = |budget: &[&str]| fly(&display, folder, frames, budget);
    // A budget that every frame holds changes nothing.
    let ample = fly(&["--budget", "60000"]);
    let line = ample.governed.unwrap();
    assert!(ample.width_px == 480 && line.contains(" 0 changes; at the end: as set"), "{line}");
    // One that needs half the time does, and the frames become faster.
    let budget_ms = format!("{:.2}", 0.5 * ample.p50_ms);
    let tight = fly(&["--budget", &budget_ms]);
    let line = tight.governed.unwrap();
    assert!(tight.width_px < 400 && line.contains("at the end: resolution 0."), "{budget_ms} ms: {line}");
    assert!(tight.p50_ms < 0.8 * ample.p50_ms, "{} ms, and {} ms without", tight.p50_ms, ample.p50_ms);
    // Without a budget there is no governor.
    let alone = self::fly(&display, folder, if is_full() { frames } else { 2 }, &[]);
    assert!(alone.governed.is_none());
}

#[test]
fn a_wrong_quality_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    write_dem(&folder.path().join("cone.tif"));
    for (arguments, cause) in [
        (&["--budget", "0"][..], "--budget"),
        (&["--budget", "11", "--quality", "draft"], "--quality"),
        (&["--front", "front.toml"], "--front"),
        (&["--style", "plain", "--quality", "draft"], "no measured settings"),
        (&["--vr", "--budget", "11"], "--vr"),
    ] {
        let mut command = hachure(folder.path());
        let output = command.args(["fly", "cone.tif"]).args(arguments).env("DISPLAY", ":987").output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        let is_one_line = text.trim().lines().count() == 1;
        assert!(!output.status.success() && is_one_line && text.contains(cause), "{arguments:?}: {text}");
        assert!(!text.contains("no display"), "{arguments:?}: {text}");
    }
}
