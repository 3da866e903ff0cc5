//! Tests that two flights of one build differ by less than their noise, and that a planted slow-down of a pass is named.

#![allow(clippy::print_stdout, reason = "a test says what it measured")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use clap::Parser;

use super::{BenchArgs, Planned};
use crate::measure::comparison::Baseline;
use crate::measure::report::{Pass, Report};
use crate::measure::statistics::{RunFrames, read_frames_csv, write_frames_csv};
use crate::style;
use crate::tests::common;

/// Slow-down that is found unless the machine's noise is larger.
const SLOWER: f64 = 1.1;
/// Slow-downs that are planted where a loaded machine makes the noise larger than the smallest one.
const MORE: [f64; 4] = [1.2, 1.5, 2.0, 10.0];
/// Least share of the frame of a pass whose slow-down is planted; the comparison omits passes of less than 2.5 %.
const LEAST_SHARE: f64 = 0.04;

#[derive(Parser)]
struct Command {
    #[command(flatten)]
    bench: BenchArgs,
}

/// Flies over rough land with two styles that are equal, in turns. Returns the report and the frames.
fn flights(folder: &Path) -> Option<(Report, Vec<RunFrames>)> {
    let gpu = common::gpu()?;
    let (land, _) = common::baked(&common::grid_of(257, 257, 20.0, common::rough_height_m));
    for name in ["first", "second"] {
        let text = style::preset_text("lsa").unwrap().replacen("\"lsa\"", &format!("\"{name}\""), 1);
        crate::file::atomic::write(&folder.join(format!("{name}.toml")), text.as_bytes()).unwrap();
    }
    let path = "t,x,y,z,yaw,pitch,fov\n0,-900,-900,+250,40,-12,60\n1,-600,-600,+200,60,-10,60\n";
    crate::file::atomic::write(&folder.join("path.csv"), path.as_bytes()).unwrap();
    let at = |name: &str| folder.join(name).display().to_string();
    let styles = format!("{},{}", at("first.toml"), at("second.toml"));
    let (path, out) = (at("path.csv"), at("out"));
    let world = land.path().join("world.tif").display().to_string();
    let words =
        ["bench", &world, "--path", &path, "--styles", &styles, "--size", "128x72", "--frames", "45", "-o", &out];
    let words = words.into_iter().chain(["--steadiness-pairs", "0"]);
    let args = Command::try_parse_from(words).unwrap().bench;
    let report = Planned::of(&args).unwrap().measure(&gpu).unwrap();
    let frames = read_frames_csv(&folder.join("out/frames.csv")).unwrap();
    assert_eq!((report.runs.len(), frames.len()), (2, 2));
    Some((report, frames))
}

/// Compares two flights by their files, and returns the passes whose times became worse or better.
fn named(folder: &Path, old: (Report, RunFrames), new: (Report, RunFrames)) -> Vec<String> {
    let [json, table] = ["report.json", "frames.csv"].map(|name| folder.join(name));
    old.0.write_json(&json).unwrap();
    write_frames_csv(&table, &[old.1]).unwrap();
    let comparison = Baseline::read(&json).unwrap().compare(&new.0, &[new.1]);
    assert!(comparison.compared > 60, "{comparison:?}");
    let changes = comparison.worse.iter().chain(&comparison.better);
    changes.filter_map(|change| change.figure.strip_prefix("GPU ms of ").map(str::to_owned)).collect()
}

/// Compares two flights of one build, and plants slow-downs in the passes of the second one.
fn check(folder: &Path) -> Result<(), String> {
    let Some((report, frames)) = flights(folder) else { return Ok(()) };
    let flight = |number: usize| {
        let mut report = report.clone();
        report.runs = vec![report.runs[number].clone()];
        let mut frames = frames[number].clone();
        (report.runs[0].style, frames.style) = ("lsa".to_owned(), "lsa".to_owned());
        (report, frames)
    };
    let equal = named(folder, flight(0), flight(1));
    if !equal.is_empty() {
        return Err(format!("two flights of one build differ in {equal:?}"));
    }
    let frame_ms = report.runs[1].gpu_ms.unwrap().p50;
    let is_large =
        |pass: &&Pass| pass.frames == Some(45) && pass.gpu_ms.is_some_and(|ms| ms.p50 > LEAST_SHARE * frame_ms);
    let passes: Vec<&str> = report.runs[1].passes.iter().filter(is_large).map(|pass| pass.name.as_str()).collect();
    assert!(passes.len() >= 4, "{passes:?}");
    let (mut found, mut found_at_once) = (0, 0);
    for pass in &passes {
        let slower_by = |factor: f64, than: usize| {
            let (report, mut slow) = flight(1);
            for frame in &mut slow.frames {
                let of_pass = frame.pass_gpu_ms.iter_mut().find(|(name, _)| name == pass);
                let time_ms = of_pass.map(|(_, time_ms)| std::mem::replace(time_ms, *time_ms * factor)).unwrap();
                let more_ms = time_ms * (factor - 1.0);
                frame.gpu_ms = frame.gpu_ms.map(|gpu_ms| gpu_ms + more_ms);
                frame.frame_ms = frame.frame_ms.map(|frame_ms| frame_ms + more_ms);
            }
            named(folder, flight(than), (report, slow))
        };
        // Where nothing but the pass differs, 10 % are enough, however busy the machine is.
        assert_eq!(slower_by(SLOWER, 1), [*pass]);
        let mut factors = std::iter::once(SLOWER).chain(MORE);
        let Some(needed) = factors.find(|factor| !slower_by(*factor, 0).is_empty()) else {
            println!("{pass}: its times are nothing but noise");
            continue;
        };
        println!("{pass}: a slow-down of {:.0} % is found", (needed - 1.0) * 100.0);
        found += 1;
        found_at_once += usize::from(needed == SLOWER);
        assert_eq!(slower_by(needed, 0), [*pass]);
    }
    println!("of {} slow-downs {found} are found, {found_at_once} of them of 10 %", passes.len());
    if 2 * found < passes.len() { Err("the machine is too busy".to_owned()) } else { Ok(()) }
}

/// A machine with other work may disturb a flight, so there are three attempts.
#[test]
fn a_pass_that_is_slower_is_named_and_no_other() {
    let attempt = |number: u32| {
        let folder = tempfile::tempdir().unwrap();
        check(folder.path()).inspect_err(|error| println!("attempt {number}: {error}"))
    };
    assert!((1..=3).any(|number| attempt(number).is_ok()), "two flights of one build are too different");
}
