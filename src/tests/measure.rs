//! Tests statistics, the report and the comparison of pictures, each with a planted error.

use std::path::Path;

use hachure::file::png::{Picture, write_rgba8};
use hachure::lines::strokes::LeftOut;
use hachure::measure::image_compare::{CompareError, Tolerance, compare, compare_with_file};
use hachure::measure::memory::rss_bytes;
use hachure::measure::report::{Memory, Report, Run, WorldSize};
use hachure::measure::report_html::{html, write_html};
use hachure::measure::statistics::{FrameRecord, Percentiles, RunFrames, write_frames_csv};

#[test]
fn percentiles_are_values_measured() {
    let of_100 = Percentiles::of((1..=100).rev().map(f64::from)).unwrap();
    assert_eq!(of_100, Percentiles { p50: 50.0, p95: 95.0, p99: 99.0, max: 100.0 });
    let of_20 = Percentiles::of((1..=20).map(f64::from)).unwrap();
    assert_eq!(of_20, Percentiles { p50: 10.0, p95: 19.0, p99: 20.0, max: 20.0 });
    let of_one = Percentiles::of([7.0, f64::NAN]).unwrap();
    assert_eq!((of_one.p50, of_one.max), (7.0, 7.0));
    assert_eq!(Percentiles::of([]), None);
}

#[test]
fn resident_memory_is_measured_on_linux() {
    assert_eq!(rss_bytes().is_some(), cfg!(target_os = "linux"));
    assert!(rss_bytes().is_none_or(|bytes| bytes > 1_000_000));
}

fn frames() -> Vec<RunFrames> {
    let frame = |frame: u64| FrameRecord {
        frame,
        t_s: frame as f64 / 60.0,
        frame_ms: Some(5.0 + (frame % 7) as f64),
        gpu_ms: Some(3.0),
        pass_gpu_ms: vec![("terrain".to_owned(), 1.0 + frame as f64 / 1000.0), ("lsa".to_owned(), 2.0)],
        lod_error_px: Some(0.5),
        triangles: Some(1000 + frame),
        late: Some(frame == 3),
        ..FrameRecord::default()
    };
    let unmeasured = FrameRecord { t_s: 1.0, ..FrameRecord::default() };
    vec![
        RunFrames { style: "ink".to_owned(), eyes: "mono".to_owned(), frames: (0..2000).map(frame).collect() },
        RunFrames { style: "a <b>".to_owned(), eyes: "mono".to_owned(), frames: vec![unmeasured] },
    ]
}

fn report() -> Report {
    let mut runs: Vec<Run> = frames().iter().map(|run| Run::of_frames(&run.style, &run.eyes, &run.frames)).collect();
    runs[0].memory = Memory { rss_bytes: Some(123), ..Memory::default() };
    runs[0].temporal = Some([("flicker_share".to_owned(), Some(0.25)), ("other".to_owned(), None)].into());
    let world = WorldSize { samples: 1 << 20, extent_m: [1000.0, 2000.0] };
    Report { adapter: "llvmpipe".to_owned(), size_px: [640, 480], world, runs, ..Report::default() }
}

#[test]
fn report_has_the_names_that_scripts_rely_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.json");
    report().write_json(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let keys = |value: &serde_json::Value| {
        let mut keys: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys.join(" ")
    };
    assert_eq!(keys(&json), "adapter comparison is_software runs settings size world");
    assert_eq!(keys(&json["world"]), "extent_m samples");
    let run = &json["runs"][0];
    assert_eq!(
        keys(run),
        "allowed_error_px antialias busy caches cpu_ms eyes frame_ms frames gpu_ms hitches lod_error_px memory \
         over_budget_frames passes prepare_ms start stereo strokes strokes_left_out style temporal tiles triangles untimed \
         work"
    );
    assert_eq!(keys(&run["frame_ms"]), "max p50 p95 p99");
    assert_eq!(keys(&run["gpu_ms"]), "max p50 p95 p99");
    assert_eq!(keys(&run["passes"][0]), "bytes_read bytes_written frames gpu_ms mean_ms name runs");
    assert_eq!(keys(&run["passes"][0]["gpu_ms"]), "p50 p95 p99");
    assert_eq!(keys(&run["memory"]), "cpu_tile_bytes drawing_bytes gpu_bytes rss_bytes tile_cache_bytes");
    assert_eq!(
        keys(&run["tiles"]),
        "cancelled evicted failed full_detail_ms late_frames late_frames_after_1s loaded \
         memory_factor"
    );
    assert_eq!(keys(&run["lod_error_px"]), "max p50 p99");
    assert_eq!((&run["passes"][1]["name"], &run["frames"]), (&"lsa".into(), &2000.into()));
    assert_eq!((&run["tiles"]["late_frames"], &run["triangles"]), (&1.into(), &1999.into()));

    // Values that were not measured are null, never 0.
    for value in [&run["stereo"], &run["strokes"], &run["memory"]["gpu_bytes"], &run["tiles"]["loaded"]] {
        assert!(value.is_null(), "{value}");
    }
    let other = &json["runs"][1];
    for key in ["frame_ms", "gpu_ms", "lod_error_px", "triangles", "strokes", "strokes_left_out", "temporal", "stereo"]
    {
        assert!(other[key].is_null(), "{key}");
    }
    assert!(other["tiles"]["late_frames"].is_null());
    assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report());
}

#[test]
fn strokes_that_found_no_room_are_the_most_of_a_frame() {
    let frame = |edges, strokes| FrameRecord {
        strokes_left_out: Some(LeftOut { edges, segments: 0, strokes }),
        ..FrameRecord::default()
    };
    let report = |frames: &[FrameRecord]| Report { runs: vec![Run::of_frames("<pen>", "mono", frames)], ..report() };
    let full = report(&[frame(0, 7), frame(3, 2), FrameRecord::default()]);
    assert_eq!(full.runs[0].strokes_left_out, Some(LeftOut { edges: 3, segments: 0, strokes: 7 }));
    let page = html(&full, &[]);
    assert!(
        page.contains("&lt;pen&gt;: per frame, up to 3 edges, 0 segments and 7 strokes exceed the limits"),
        "{page}"
    );
    // A measured 0 causes no warning; unmeasured values are null.
    let (roomy, without) = (report(&[frame(0, 0)]), report(&[FrameRecord::default()]));
    assert_eq!(roomy.runs[0].strokes_left_out, Some(LeftOut::default()));
    assert_eq!(without.runs[0].strokes_left_out, None);
    for quiet in [roomy, without] {
        assert!(!html(&quiet, &[]).contains("exceed the limits"));
    }
}

#[test]
fn frames_table_has_a_column_for_each_pass() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.csv");
    write_frames_csv(&path, &frames()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2002);
    assert_eq!(
        lines[0],
        "style,eyes,frame,t_s,frame_ms,gpu_ms,lod_error_px,triangles,strokes,tiles_loaded,late,prepare_ms,jumped,wall_s,\
         allowed_error_px,over_budget,memory_factor,record_ms,submit_ms,wait_ms,bytes_read,bytes_written,wgpu_passes,dispatches,\
         draws,copies,barriers,gpu_ms.terrain,gpu_ms.lsa"
    );
    assert_eq!(lines[1], format!("ink,mono,0,0,5,3,0.5,1000,,,0,,,,,{},1,2", ",".repeat(11)));
    assert_eq!(lines[2001], format!("a <b>,mono,0,1,{}", ",".repeat(24)));
}

#[test]
fn page_stands_alone() {
    let page = html(&report(), &frames());
    for needed in ["<svg", "<polyline", "<rect", "Frame time along the path", "flicker_share", "prefers-color-scheme"] {
        assert!(page.contains(needed), "{needed}");
    }
    for foreign in ["http", "<script", "src=", "@import", "url(", "NaN", "a <b>"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    // 2000 frames fit the plot's columns.
    assert!(page.len() < 100_000, "{}", page.len());
    for tag in ["svg", "table", "tr", "td", "p", "h2", "div", "text"] {
        let count = |text: String| page.matches(&text).count();
        let opened = count(format!("<{tag}>")) + count(format!("<{tag} "));
        assert_eq!(opened, count(format!("</{tag}>")), "{tag}");
    }
    // An empty report makes a valid page, too.
    assert!(html(&Report::default(), &[]).contains("</html>"));
    let folder = tempfile::tempdir().unwrap();
    write_html(&folder.path().join("report.html"), &report(), &frames()).unwrap();
    assert!(write_html(Path::new("/no/such/report.html"), &report(), &[]).is_err());
}

/// Returns white paper, with a black diagonal line of 1 px if `line`.
fn drawing(line: bool) -> Picture {
    let size = 256;
    let mut rgba = vec![255; size * size * 4];
    if line {
        for at in 0..size {
            rgba[(at * size + at) * 4..][..3].fill(0);
        }
    }
    Picture { width: size as u32, height: size as u32, rgba }
}

const TOLERANCE: Tolerance = Tolerance { channel_difference: 8, outlier_share: 0.001 };

#[test]
fn a_lost_line_fails_where_a_mean_would_pass() {
    let (with, without) = (drawing(true), drawing(false));
    let pairs = with.rgba.iter().zip(&without.rgba);
    let mean = pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / with.rgba.len() as f64;
    assert!(mean < 1.0, "the mean difference must be small, but is {mean} of 255");
    let comparison = compare(&without, &with, TOLERANCE).unwrap();
    assert_eq!((comparison.outliers, comparison.pixels), (256, 65_536));
    assert_eq!((comparison.worst_difference, comparison.worst_px), (255, [0, 0]));
    assert!(!comparison.passes());
    assert!(comparison.to_string().starts_with("256 of 65536 pixels differ by more than 8 (allowed: 65)"));
}

#[test]
fn small_differences_and_few_outliers_pass() {
    let reference = drawing(true);
    let mut picture = reference.clone();
    picture.rgba.iter_mut().for_each(|byte| *byte = byte.saturating_sub(8));
    picture.rgba[(7 * 256 + 5) * 4] = 0;
    let comparison = compare(&picture, &reference, TOLERANCE).unwrap();
    assert_eq!((comparison.outliers, comparison.worst_px), (1, [5, 7]));
    assert!(comparison.passes());
    assert!(compare(&reference, &reference, Tolerance::EXACT).unwrap().passes());
    assert!(!compare(&picture, &reference, Tolerance::EXACT).unwrap().passes());
    let no_number = Tolerance { outlier_share: f64::NAN, ..Tolerance::EXACT };
    assert!(!compare(&picture, &reference, no_number).unwrap().passes());
}

#[test]
fn a_missing_reference_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reference.png");
    let picture = drawing(true);
    let error = compare_with_file(&picture, &path, TOLERANCE).unwrap_err();
    assert!(matches!(error, CompareError::Reference(_)) && error.to_string().contains("reference.png"));
    write_rgba8(&path, 256, 256, &picture.rgba).unwrap();
    assert!(compare_with_file(&picture, &path, Tolerance::EXACT).unwrap().passes());
    let smaller = Picture { width: 256, height: 255, rgba: vec![255; 256 * 255 * 4] };
    assert_eq!(compare_with_file(&smaller, &path, TOLERANCE), Err(CompareError::Size([256, 255], [256, 256])));
    let broken = Picture { width: 2, height: 2, rgba: vec![] };
    assert!(matches!(compare(&broken, &broken, TOLERANCE), Err(CompareError::Bytes { bytes: 0, .. })));
}

#[test]
fn a_pass_that_runs_now_and_then_is_not_stacked_as_if_it_always_ran() {
    // One frame in ten builds horizon maps, which take 100 ms.
    let frame = |frame: u64| {
        let mut passes = vec![("lines/lsa".to_owned(), 2.0)];
        passes.extend(frame.is_multiple_of(10).then(|| ("surface/land/horizons".to_owned(), 100.0)));
        FrameRecord { frame, gpu_ms: Some(2.0), pass_gpu_ms: passes, ..FrameRecord::default() }
    };
    let frames: Vec<FrameRecord> = (0..50).map(frame).collect();
    let run = Run::of_frames("wash", "mono", &frames);
    let of = |name: &str| run.passes.iter().find(|pass| pass.name == name).unwrap();
    let (always, sometimes) = (of("lines/lsa"), of("surface/land/horizons"));
    assert_eq!((always.frames, always.mean_ms), (Some(50), Some(2.0)));
    assert_eq!((sometimes.frames, sometimes.mean_ms), (Some(5), Some(10.0)));
    assert!(
        (sometimes.gpu_ms.unwrap().p50 - 100.0).abs() < 1e-9,
        "percentiles count only the frames that ran the pass"
    );
    let report = Report { runs: vec![run], ..Report::default() };
    let page = html(&report, &[RunFrames { style: "wash".to_owned(), eyes: "mono".to_owned(), frames }]);
    assert!(page.contains(">12.0 ms<") || page.contains(">12 ms<"), "the bar must be as long as the mean frame");
}
