#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use super::*;
use crate::measure::report::Pass;
use crate::measure::statistics::write_frames_csv;
use crate::measure::work::{CacheUse, FrameWork};

/// A flight in which the frame takes `frame_ms` times the load of the place, and its two passes a part of that.
fn frames(seed: u64, factors: [f64; 2]) -> RunFrames {
    let frame = |frame: u64| {
        let noise = 1.0 + 0.04 * (((frame * 7919 + seed * 104_729) % 101) as f64 / 101.0 - 0.5);
        let load = (1.0 + 0.5 * (frame as f64 / 10.0).sin()) * noise;
        let [surface_ms, lines_ms] = [4.0 * factors[0] * load, 2.0 * factors[1] * load];
        FrameRecord {
            frame,
            t_s: frame as f64 / 30.0,
            frame_ms: Some(surface_ms + lines_ms + 1.0),
            gpu_ms: Some(surface_ms + lines_ms),
            prepare_ms: Some(0.2 * noise),
            pass_gpu_ms: vec![("surface".to_owned(), surface_ms), ("lines".to_owned(), lines_ms)],
            ..FrameRecord::default()
        }
    };
    RunFrames { style: "ink".to_owned(), eyes: "mono".to_owned(), frames: (0..90).map(frame).collect() }
}

fn report(frames: &RunFrames) -> Report {
    let mut run = Run::of_frames(&frames.style, &frames.eyes, &frames.frames);
    run.work =
        Some(FrameWork { bytes_read: 1_000_000, bytes_written: 200_000, wgpu_passes: 9, ..FrameWork::default() });
    let pass = |name: &str| Pass {
        name: name.to_owned(),
        bytes_read: Some(500_000),
        bytes_written: Some(100_000),
        runs: Some(1),
        ..Pass::default()
    };
    run.passes = vec![pass("surface"), pass("lines")];
    run.caches.insert("tiles".to_owned(), CacheUse { hits: 95, misses: 5 });
    let settings = Some(Settings { frames: Some(90), lod_error_px: 1.0, ..Settings::default() });
    Report { adapter: "a card".to_owned(), size_px: [64, 36], settings, runs: vec![run], ..Report::default() }
}

fn baseline(frames: RunFrames) -> Baseline {
    Baseline { name: "old/report.json".to_owned(), report: report(&frames), frames: vec![frames] }
}

fn names(changes: &[Change]) -> Vec<&str> {
    changes.iter().map(|change| change.figure.as_str()).collect()
}

#[test]
fn an_equal_run_is_not_worse() {
    let old = baseline(frames(1, [1.0, 1.0]));
    for seed in 1..20 {
        let new = frames(seed, [1.0, 1.0]);
        let comparison = old.compare(&report(&new), &[new]);
        assert_eq!((comparison.worse, comparison.better, comparison.notes), (vec![], vec![], vec![]), "seed {seed}");
        assert!(comparison.compared >= 15, "{}", comparison.compared);
    }
}

#[test]
fn a_planted_slowdown_is_named_with_its_pass() {
    let old = baseline(frames(1, [1.0, 1.0]));
    let slow = frames(2, [1.0, 1.3]);
    let comparison = old.compare(&report(&slow), std::slice::from_ref(&slow));
    assert_eq!(names(&comparison.worse), ["frame ms", "GPU ms", "GPU ms of lines"]);
    let lines = comparison.worse.last().unwrap();
    assert!((lines.ratio.unwrap() - 1.3).abs() < 0.03 && lines.noise.unwrap() < 0.02, "{lines:?}");
    assert!(lines.percent().starts_with("+2") || lines.percent().starts_with("+3"), "{}", lines.percent());
    // The other way round it is better.
    let back = baseline(slow).compare(&old.report, &old.frames);
    assert_eq!((names(&back.better), back.worse), (vec!["frame ms", "GPU ms", "GPU ms of lines"], vec![]));
}

#[test]
fn planted_bytes_passes_and_misses_are_named() {
    let old = baseline(frames(1, [1.0, 1.0]));
    let new = frames(2, [1.0, 1.0]);
    let mut more = report(&new);
    let run = &mut more.runs[0];
    run.work = run.work.map(|work| FrameWork { bytes_read: 1_010_000, wgpu_passes: 10, ..work });
    run.passes[1].bytes_written = Some(110_000);
    run.passes[0].runs = Some(2);
    run.caches.insert("tiles".to_owned(), CacheUse { hits: 80, misses: 20 });
    let comparison = old.compare(&more, &[new]);
    let expected = ["bytes read", "wgpu passes", "runs of surface", "bytes of lines", "hit rate %, tiles"];
    assert_eq!(names(&comparison.worse), expected);
    assert_eq!(comparison.worse[0].percent(), "+1.0 %");
}

#[test]
fn what_cannot_be_compared_is_said() {
    let new = frames(2, [2.0, 2.0]);
    let compared = |change: &dyn Fn(&mut Baseline)| {
        let mut old = baseline(frames(1, [1.0, 1.0]));
        change(&mut old);
        let comparison = old.compare(&report(&new), std::slice::from_ref(&new));
        assert_eq!(comparison.worse, [], "{:?}", comparison.notes);
        comparison.notes.join("; ")
    };
    assert!(compared(&|old| old.report.adapter = "another".to_owned()).contains("the GPU was another"));
    assert!(compared(&|old| old.frames.clear()).contains("frames.csv"));
    assert!(compared(&|old| old.report.runs.clear()).contains("ink, mono"));
    let antialias = compared(&|old| old.report.runs[0].antialias = "temporal".to_owned());
    assert!(antialias.contains("ink, mono: is not compared") && antialias.contains("--antialias temporal"));
}

#[test]
fn nothing_is_compared_with_a_report_of_other_frames() {
    // Everything takes twice as long, so that each figure that is compared is named.
    let new = frames(2, [2.0, 2.0]);
    let compared = |change: &dyn Fn(&mut Report)| {
        let mut old = baseline(frames(1, [1.0, 1.0]));
        change(&mut old.report);
        old.compare(&report(&new), std::slice::from_ref(&new))
    };
    type Spoil = fn(&mut Report);
    let changes: [(Spoil, &str); 4] = [
        (|old| old.size_px = [1, 2], "1x2"),
        (|old| old.world.extent_m = [1.0, 2.0], "the worlds differ"),
        (|old| old.settings.as_mut().unwrap().path_crc32 = "other".to_owned(), "the cameras of --path"),
        (|old| old.settings.as_mut().unwrap().lod_error_px = 4.0, "--lod-error 4, this one with --lod-error 1"),
    ];
    for (change, reason) in changes {
        let comparison = compared(&change);
        assert_eq!((comparison.compared, comparison.notes.len()), (0, 1), "{:?}", comparison.notes);
        assert!(comparison.notes[0].starts_with("nothing is compared"), "{:?}", comparison.notes);
        assert!(comparison.notes[0].contains(reason), "{:?}", comparison.notes);
        assert_eq!(comparison.unchanged(), None);
    }
    // Two reasons are two notes.
    let both = compared(&|old| (old.size_px, old.world.samples) = ([1, 2], 7));
    assert_eq!(both.notes.len(), 2);
    // Another program, or a report that does not say how it was made, is a note only.
    let other = compared(&|old| old.settings.as_mut().unwrap().version = "0.0.1".to_owned());
    assert!(other.notes[0].contains("hachure 0.0.1") && !other.worse.is_empty(), "{:?}", other.notes);
    let silent = compared(&|old| old.settings = None);
    assert!(silent.notes[0].contains("does not say") && !silent.worse.is_empty(), "{:?}", silent.notes);
}

#[test]
fn work_of_other_frames_is_not_compared() {
    let new = frames(2, [1.0, 1.0]);
    let mut more = report(&new);
    more.runs[0].work = more.runs[0].work.map(|work| FrameWork { dispatches: 5, barriers: 7, ..work });
    more.runs[0].passes[0].runs = Some(2);
    let old = baseline(frames(1, [1.0, 1.0]));
    let same = old.compare(&more, std::slice::from_ref(&new));
    assert_eq!(names(&same.worse), ["dispatches", "barriers", "runs of surface"]);
    // In real time, times and shares of frames are compared, and nothing else.
    let mut old = baseline(frames(1, [1.0, 1.0]));
    for report in [&mut old.report, &mut more] {
        let settings = report.settings.as_mut().unwrap();
        (settings.frames, settings.real_time) = (None, true);
    }
    more.runs[0].tiles.late_frames = Some(45);
    old.report.runs[0].tiles.late_frames = Some(0);
    let real_time = old.compare(&more, std::slice::from_ref(&new));
    assert_eq!(names(&real_time.worse), ["late frames %"]);
    assert!(real_time.notes[0].contains("--real-time") && real_time.compared >= 6, "{real_time:?}");
}

#[test]
fn times_of_too_few_frames_are_not_called_unchanged() {
    let of = |count: usize| {
        let [mut old, mut new] = [frames(1, [1.0, 1.0]), frames(2, [1.0, 1.0])];
        for run in [&mut old, &mut new] {
            run.frames.truncate(count);
        }
        let (report, old) = (report(&new), baseline(old));
        old.compare(&report, std::slice::from_ref(&new))
    };
    let (three, four) = (of(3), of(4));
    assert_eq!(three.notes.len(), 2, "{:?}", three.notes);
    assert!(three.notes[0].contains("frame ms, GPU ms, prepare ms; at least 4 frames"), "{:?}", three.notes);
    assert!(three.notes[1].contains("the times of 2 passes"), "{:?}", three.notes);
    assert_eq!((four.notes.len(), four.compared), (0, three.compared + 5));
    assert!(four.unchanged().unwrap().contains("3 % and 4 standard errors"), "{:?}", four.unchanged());
}

#[test]
fn reports_are_read_from_their_folder() {
    let folder = tempfile::tempdir().unwrap();
    let [json, table] = ["report.json", "frames.csv"].map(|name| folder.path().join(name));
    let frames = frames(1, [1.0, 1.0]);
    report(&frames).write_json(&json).unwrap();
    assert_eq!(Baseline::read(&json).unwrap().frames, []);
    write_frames_csv(&table, std::slice::from_ref(&frames)).unwrap();
    let read = Baseline::read(&json).unwrap();
    assert_eq!(read.frames, [frames]);
    assert_eq!(read.report.runs[0].work.unwrap().wgpu_passes, 9);
    crate::file::atomic::write(&json, b"{}").unwrap();
    let error = Baseline::read(&json).err().unwrap().to_string();
    assert!(error.contains("report.json") && error.contains("not a report.json of bench"), "{error}");
}
