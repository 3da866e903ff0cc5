//! `bench`: the names in the report, what is null in it, and whether its numbers are measured.

use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use serde_json::Value;

use crate::dem::{SIZE, SPACING_M, every_sample};
use crate::{Place, full};

/// Returns whether there is a GPU; a software driver is enough.
pub(crate) fn has_gpu() -> bool {
    match Gpu::open(&AdapterWish::Best) {
        Ok(_) => true,
        Err(error) if std::env::var_os("HACHURE_REQUIRE_GPU").is_some_and(|wish| wish == "1") => panic!("{error}"),
        Err(error) => {
            println!("skipped: {error}");
            false
        }
    }
}

/// Writes the synthetic DEM and a flight over it.
pub(crate) fn place_with_flight() -> Place {
    flight_over(1)
}

/// Does the same; in the fast tier with a ninth of the samples, for tests that need no more.
pub(crate) fn place_with_quick_flight() -> Place {
    flight_over(if full() { 1 } else { 3 })
}

fn flight_over(step: u32) -> Place {
    let place = Place::empty();
    every_sample(&place, step);
    place.file("flight.csv", "t,x,y,z,yaw,pitch,fov\n0,-900,-900,+150,40,-12,60\n1,300,200,+120,60,-10,60\n");
    place
}

fn keys(value: &Value, expected: &[&str]) -> Result<(), String> {
    let object = value.as_object().ok_or_else(|| format!("{value} is not an object"))?;
    let mut found: Vec<&str> = object.keys().map(String::as_str).collect();
    let mut expected = expected.to_vec();
    found.sort_unstable();
    expected.sort_unstable();
    if found == expected { Ok(()) } else { Err(format!("found the keys {found:?}, expected {expected:?}")) }
}

fn all_numbers(value: &Value, names: &[&str]) -> Result<(), String> {
    keys(value, names)?;
    names.iter().try_for_each(|name| {
        value[name]
            .as_f64()
            .filter(|number| *number >= 0.0)
            .map(drop)
            .ok_or_else(|| format!("{name} is {}", value[name]))
    })
}

fn is_null(value: &Value, name: &str) -> Result<(), String> {
    if value[name].is_null() {
        Ok(())
    } else {
        Err(format!("{name} is {}, expected null, since it was not measured", value[name]))
    }
}

/// Checks the names and types that scripts rely on.
fn check_schema(report: &Value) -> Result<(), String> {
    keys(report, &["adapter", "is_software", "size", "world", "settings", "runs", "comparison"])?;
    let settings = ["version", "program_crc32", "world", "path", "path_crc32", "duration_s", "frames", "real_time"];
    keys(
        &report["settings"],
        &[&settings[..], &["exaggeration", "sea_level", "trees", "seed", "lod_error_px", "tile_memory_mib"]].concat(),
    )?;
    keys(&report["world"], &["samples", "extent_m"])?;
    for run in report["runs"].as_array().ok_or("runs is not a list")? {
        let names = ["style", "eyes", "frames", "frame_ms", "gpu_ms", "passes", "memory", "tiles", "lod_error_px"];
        let more =
            ["antialias", "triangles", "strokes", "strokes_left_out", "temporal", "stereo", "prepare_ms", "hitches"];
        let cost = ["cpu_ms", "work", "untimed", "busy", "start", "caches"];
        keys(run, &[&names[..], &more, &cost, &["allowed_error_px", "over_budget_frames"]].concat())?;
        check_cost(run)?;
        all_numbers(&run["frame_ms"], &["p50", "p95", "p99", "max"])?;
        // Null where the GPU has no timestamp queries.
        if !run["gpu_ms"].is_null() {
            all_numbers(&run["gpu_ms"], &["p50", "p95", "p99", "max"])?;
        }
        for pass in run["passes"].as_array().ok_or("passes is not a list")? {
            keys(pass, &["name", "gpu_ms", "frames", "mean_ms", "bytes_read", "bytes_written", "runs"])?;
            if !pass["gpu_ms"].is_null() {
                all_numbers(&pass["gpu_ms"], &["p50", "p95", "p99"])?;
            }
        }
        keys(&run["memory"], &["gpu_bytes", "drawing_bytes", "tile_cache_bytes", "cpu_tile_bytes", "rss_bytes"])?;
        let counts = ["loaded", "evicted", "cancelled", "failed", "late_frames"];
        keys(&run["tiles"], &[&counts[..], &["late_frames_after_1s", "full_detail_ms", "memory_factor"]].concat())?;
        if let Some(name) = counts.iter().find(|name| !run["tiles"][**name].is_number()) {
            return Err(format!("{name} is not a number"));
        }
        all_numbers(&run["lod_error_px"], &["p50", "p99", "max"])?;
        all_numbers(&run["allowed_error_px"], &["p50", "p99", "max"])?;
        if run["over_budget_frames"] != 0 {
            return Err(format!("{} frames of ordinary land exceed the budget", run["over_budget_frames"]));
        }
        check_steadiness(&run["temporal"], run["style"] == "plain")?;
        ["strokes", "strokes_left_out", "stereo"].into_iter().try_for_each(|name| is_null(run, name))?;
    }
    Ok(())
}

/// Checks what a frame does whatever the GPU.
fn check_cost(run: &Value) -> Result<(), String> {
    keys(&run["cpu_ms"], &["record", "submit", "wait"])?;
    all_numbers(&run["cpu_ms"]["record"], &["p50", "p95", "p99", "max"])?;
    let work = &run["work"];
    let counts = ["bytes_read", "bytes_written", "wgpu_passes", "dispatches", "draws", "copies", "barriers"];
    all_numbers(work, &counts)?;
    let of_passes = |name: &str| {
        let passes = run["passes"].as_array().into_iter().flatten();
        passes.filter_map(|pass| pass[name].as_u64()).sum::<u64>()
    };
    // Of these frames, all run the same passes.
    let sums = [work["bytes_read"].as_u64(), work["bytes_written"].as_u64()];
    if sums != ["bytes_read", "bytes_written"].map(|name| Some(of_passes(name))) {
        return Err(format!("{work} is not the sum of the passes"));
    }
    let [wgpu_passes, dispatches, draws] =
        ["wgpu_passes", "dispatches", "draws"].map(|name| work[name].as_u64().unwrap_or_default());
    if dispatches >= of_passes("runs") || dispatches + draws < of_passes("runs") || wgpu_passes > of_passes("runs") {
        return Err(format!("{work}: the passes run {} times", of_passes("runs")));
    }
    let untimed = ["frames", "throughput_ms", "prepare_ms", "record_ms", "submit_ms", "latency_ms"];
    keys(&run["untimed"], &untimed)?;
    all_numbers(&run["untimed"]["latency_ms"], &["p50", "p95", "p99", "max"])?;
    all_numbers(&run["start"], &["pipelines", "compile_ms", "frame_ms"])?;
    // A frame like the one before looks up no pipeline.
    keys(&run["caches"], &["pipelines", "bind_groups", "buffers", "gpu_tiles", "cpu_tiles"])?;
    let caches = ["bind_groups", "buffers"];
    match caches.into_iter().find(|name| run["caches"][*name]["hits"].as_u64().is_none_or(|hits| hits == 0)) {
        Some(name) => Err(format!("{name}: {}", run["caches"])),
        None => Ok(()),
    }
}

/// Checks that every frame of a table has its times, and that some of each of the runs have their work.
fn check_frames(table: &str, runs: usize) -> Result<(), String> {
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let of = |name: &str| {
        let at = rows[0].iter().position(|column| *column == name).ok_or_else(|| format!("no column {name}"))?;
        Ok::<_, String>(rows[1..].iter().map(|row| row[at]).collect::<Vec<_>>())
    };
    for name in ["frame_ms", "prepare_ms", "record_ms"] {
        if of(name)?.iter().any(|cell| cell.parse::<f64>().is_err()) {
            return Err(format!("{name}: {:?}", of(name)?));
        }
    }
    let traced = of("wgpu_passes")?.iter().filter(|cell| !cell.is_empty()).count();
    if traced < runs || of("bytes_read")?.iter().filter(|cell| !cell.is_empty()).count() != traced {
        return Err(format!("{traced} frames have their work"));
    }
    Ok(())
}

/// Checks the steadiness of styles without strokes; `plain` draws no lines either.
fn check_steadiness(temporal: &Value, is_plain: bool) -> Result<(), String> {
    let lines = ["line_coverage", "line_masked", "flicker", "flicker_births", "flicker_deaths", "flicker_ink"];
    let lines = [&lines[..], &["flicker_ink_births", "flicker_ink_deaths"]].concat();
    let strokes = ["strokes_per_frame", "births_per_frame", "deaths_per_frame", "identity_change"];
    let of_updates = ["flicker_updates", "flicker_between", "identity_updates", "identity_between"];
    let strokes = [&strokes[..], &["slip_px_p50", "slip_px_p95"], &of_updates].concat();
    keys(temporal, &[&["pairs", "e_warp"][..], &lines[..], &strokes[..]].concat())?;
    strokes.iter().try_for_each(|name| is_null(temporal, name))?;
    let is_share = |name: &&str| temporal[*name].as_f64().is_some_and(|share| (0.0..=1.0).contains(&share));
    match lines.iter().find(|name| if is_plain { !temporal[**name].is_null() } else { !is_share(name) }) {
        Some(name) => Err(format!("{name} is {}", temporal[name])),
        None if temporal["pairs"] == 4.0 && temporal["e_warp"].as_f64().is_some_and(|e_warp| e_warp > 0.0) => Ok(()),
        None => Err(format!("{temporal}")),
    }
}

#[test]
fn a_bench_writes_what_scripts_rely_on() {
    if !has_gpu() {
        return;
    }
    let place = place_with_flight();
    let flight = ["bench", "dem.tif", "--path", "flight.csv", "--size", "96x54"];
    let more = ["--frames", "5", "--styles", "lsa,plain", "-o", "deep/out", "--json"];
    let report = place.json(&[&flight[..], &more].concat());
    assert_eq!(check_schema(&report), Ok(()));
    let written = std::fs::read(place.path("deep/out/report.json")).unwrap();
    assert_eq!(serde_json::from_slice::<Value>(&written).unwrap(), report);

    assert_eq!(report["size"], serde_json::json!([96, 54]));
    assert_eq!(report["world"]["samples"], u64::from(SIZE[0] * SIZE[1]));
    let east_m = report["world"]["extent_m"][0].as_f64().unwrap();
    assert!((east_m - f64::from(SIZE[0] - 1) * SPACING_M).abs() < 0.01, "{east_m}");
    let runs = report["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    for (run, name) in runs.iter().zip(["lsa", "plain"]) {
        assert_eq!((&run["style"], &run["eyes"], &run["frames"]), (&name.into(), &"mono".into(), &5.into()));
        assert!(run["triangles"].as_u64().unwrap() > 1000);
        assert!(run["memory"]["gpu_bytes"].as_u64().unwrap() > run["memory"]["tile_cache_bytes"].as_u64().unwrap());
        assert!(run["memory"]["tile_cache_bytes"].as_u64().unwrap() > 0);
        assert_eq!((&run["tiles"]["failed"], &run["tiles"]["late_frames"]), (&0.into(), &0.into()));
        // The last pass writes the picture: 8 bytes per pixel.
        let last = run["passes"].as_array().unwrap().last().unwrap();
        assert_eq!(last["bytes_written"], 96 * 54 * 8);
        assert!(last["bytes_read"].as_u64().unwrap() > 96 * 54 * 8);
        // The passes are those of the style, in order.
        let ran: Vec<_> = run["passes"].as_array().unwrap().iter().map(|pass| pass["name"].as_str().unwrap()).collect();
        assert_eq!((ran[0], ran[ran.len() - 1]), ("surface/land/vertices", "composite/composite"));
        for (pass, of_lsa) in [("lines/lsa", true), ("lines/smooth", true), ("tones/plain", false)] {
            assert_eq!(ran.contains(&pass), of_lsa == (name == "lsa"), "{name}: {ran:?}");
        }
    }
    // Both styles drew the same mesh.
    assert_eq!(runs[0]["triangles"], runs[1]["triangles"]);
    assert_eq!(runs[0]["lod_error_px"], runs[1]["lod_error_px"]);

    let frames = std::fs::read_to_string(place.path("deep/out/frames.csv")).unwrap();
    assert!(frames.starts_with("style,eyes,frame,t_s,frame_ms,gpu_ms,"), "{frames}");
    assert_eq!(frames.lines().count(), 1 + 2 * 5);
    assert!(frames.lines().nth(5).unwrap().starts_with("lsa,mono,4,1,"), "{frames}");
    assert_eq!(check_frames(&frames, 2), Ok(()));
    // Planted: a frame without its time, as one that is traced while it is timed.
    let column = frames.lines().next().unwrap().split(',').position(|name| name == "record_ms").unwrap();
    let mut cells: Vec<&str> = frames.lines().nth(5).unwrap().split(',').collect();
    cells[column] = "";
    assert!(check_frames(&frames.replace(frames.lines().nth(5).unwrap(), &cells.join(",")), 2).is_err());
    let page = std::fs::read_to_string(place.path("deep/out/report.html")).unwrap();
    assert!(
        page.contains("<svg") && !page.contains("http"),
        "the page must contain a diagram and refer to no other site"
    );
    assert!(page.contains("dem.tif along flight.csv (1 s), 5 frames"), "the page must say how it was made");
    assert!(page.contains("Memory by pass") && page.contains("<td>composite/composite</td>"));

    // The same flight again has the same bytes and passes as the report with which it is compared.
    let more = ["--frames", "5", "--styles", "lsa,plain", "--steadiness-pairs", "0", "-o", "again", "--json"];
    let again = place.json(&[&flight[..], &more, &["--compare", "deep/out/report.json"]].concat());
    let changes: Vec<&Value> =
        ["worse", "better"].iter().flat_map(|part| again["comparison"][part].as_array().unwrap()).collect();
    let declared = ["bytes", "wgpu passes", "dispatches", "draws", "copies", "barriers", "runs"];
    let is_declared =
        |change: &&&Value| declared.iter().any(|name| change["figure"].as_str().unwrap().starts_with(name));
    assert_eq!(changes.iter().filter(is_declared).count(), 0, "{changes:?}");
    assert!(again["comparison"]["compared"].as_u64().unwrap() > 60, "{}", again["comparison"]);
    assert_eq!(again["comparison"]["notes"], serde_json::json!([]));
    let over = ["-o", "deep/out", "--overwrite", "--compare", "deep/out/report.json"];
    assert!(place.error(&[&flight[..], &over].concat()).contains("is the input"));

    // Planted errors: a wrong name, and a 0 where nothing was measured.
    let text = report.to_string();
    for (right, wrong) in [
        ("\"frame_ms\"", "\"frame_time\""),
        ("\"strokes\":null", "\"strokes\":0"),
        ("\"strokes_left_out\":null", "\"strokes_left_out\":{\"edges\":0,\"segments\":0,\"strokes\":0}"),
        ("\"slip_px_p50\":null", "\"slip_px_p50\":0"),
        ("\"pairs\":4.0", "\"pairs\":3.0"),
        ("\"barriers\":", "\"fences\":"),
        ("\"wgpu_passes\":", "\"passes\":"),
        ("\"path_crc32\":", "\"crc32\":"),
        ("\"bytes_read\":", "\"bytes_read\":1"),
    ] {
        let planted: Value = serde_json::from_str(&text.replace(right, wrong)).unwrap();
        assert!(check_schema(&planted).is_err(), "{right} → {wrong}");
    }
}

#[test]
fn the_steadiness_of_strokes_is_measured() {
    if !has_gpu() {
        return;
    }
    let place = place_with_quick_flight();
    let (size, frames) = if full() { ("192x108", ["21", "5"]) } else { ("96x54", ["7", "4"]) };
    let flight = ["bench", "dem.tif", "--path", "flight.csv", "--size", size, "--styles", "strokes"];
    let of = |frames: &str, pairs: &str| {
        let more = ["--frames", frames, "--temporal", pairs, "-o", "out", "--json"];
        place.json(&[&flight[..], &more].concat())["runs"][0].clone()
    };
    // The same path in fewer frames has larger steps.
    let [slow, fast] = frames.map(|frames| of(frames, "3"));
    for run in [&slow, &fast] {
        let temporal = &run["temporal"];
        assert_eq!(temporal["pairs"], 3.0);
        assert!(run["strokes"].as_u64().unwrap() > 0);
        assert!(temporal["identity_change"].as_f64().unwrap() < 1.0);
        assert!(temporal["slip_px_p50"].as_f64().unwrap() > 0.0);
    }
    let e_warp = |run: &Value| run["temporal"]["e_warp"].as_f64().unwrap();
    assert!(e_warp(&fast) > 0.0 && e_warp(&slow) > 0.0);
    assert!(of(if full() { "5" } else { "1" }, "0")["temporal"].is_null());
    // With --real-time, pairs of frames are compared too.
    let real_time = place.json(&[&flight[..], &["--real-time", "-o", "out", "--json"]].concat());
    assert!(real_time["runs"][0]["temporal"]["pairs"].as_f64().unwrap() >= 1.0, "{real_time}");
}

#[test]
fn strokes_that_found_no_room_are_reported() {
    if !has_gpu() {
        return;
    }
    let place = place_with_quick_flight();
    let plenty = place.text(&["styles", "show", "strokes"]);
    let is_budget = |line: &&str| line.trim_start().starts_with("budget_px");
    let budget = plenty.lines().find(is_budget);
    let little = match budget {
        Some(line) => plenty.replace(line, "budget_px = 100"),
        None => plenty.replace("kind = \"strokes\"", "kind = \"strokes\"\nbudget_px = 100"),
    };
    assert_ne!(little, plenty);
    place.file("little.toml", &little);
    let frames = if full() { "12" } else { "2" };
    let flight = ["bench", "dem.tif", "--path", "flight.csv", "--size", "192x108", "--styles", "strokes,little.toml"];
    let text = place.text(&[&flight[..], &["--frames", frames, "--temporal", "0", "-o", "out"]].concat());
    let report: Value = serde_json::from_slice(&std::fs::read(place.path("out/report.json")).unwrap()).unwrap();
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    let left_out = |run: usize| report["runs"][run]["strokes_left_out"].clone();
    assert_eq!(left_out(0), serde_json::json!({"edges": 0, "segments": 0, "strokes": 0}));
    assert!(left_out(1)["strokes"].as_u64().unwrap() > 0, "{}", left_out(1));
    assert_eq!((left_out(1)["edges"].as_u64(), left_out(1)["segments"].as_u64()), (Some(0), Some(0)));
    // One line, for the style whose budget is too small.
    for document in [&text, &page] {
        assert_eq!(document.matches("exceed the limits").count(), 1, "{document}");
        assert!(document.contains(&format!("{} strokes exceed the limits", left_out(1)["strokes"])), "{document}");
    }
}

#[test]
fn the_level_of_detail_error_is_measured() {
    if !has_gpu() {
        return;
    }
    let place = place_with_flight();
    let flight =
        ["bench", "dem.tif", "--path", "flight.csv", "--size", "192x108", "--frames", "4", "--styles", "plain"];
    let error_px = |allowed_px: &str| {
        let report = place.json(&[&flight[..], &["-o", "out", "--json", "--lod-error", allowed_px]].concat());
        let error_px = report["runs"][0]["lod_error_px"]["max"].as_f64().unwrap();
        println!("allowed {allowed_px} px, measured {error_px:.3} px");
        error_px
    };
    let (fine_px, coarse_px) = (error_px("1"), error_px("40"));
    assert!(fine_px > 0.0 && fine_px < 1.5, "measured {fine_px} px, allowed 1 px");
    // A mesh with a larger allowed error has a larger error, and the measurement finds it.
    assert!(coarse_px > 3.0 * fine_px, "measured {coarse_px} px with 40 px allowed, {fine_px} px with 1 px");
}

#[test]
fn frames_without_room_for_their_tiles_are_late() {
    if !has_gpu() {
        return;
    }
    let place = place_with_flight();
    let flight = [
        "bench",
        "dem.tif",
        "--path",
        "flight.csv",
        "--size",
        "96x54",
        "--frames",
        "3",
        "--styles",
        "plain",
        "--temporal",
        "0",
    ];
    // 1 MiB has room for three tiles; the view needs four and the one above them.
    let report = place.json(&[&flight[..], &["-o", "out", "--json", "--tile-memory", "1"]].concat());
    assert_eq!(report["runs"][0]["tiles"]["late_frames"], 3, "{report}");
}

#[test]
fn the_table_has_a_row_for_each_style() {
    if !has_gpu() {
        return;
    }
    let place = place_with_quick_flight();
    let style = if full() { "ink" } else { "lsa" };
    let styles = format!("{style},{style}");
    let flight = ["bench", "dem.tif", "--path", "flight.csv", "--size", "64x36", "--styles", &styles];
    let table = place.text(&[&flight[..], &["--frames", "2", "-o", "out"]].concat());
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with(&format!("{style} "))).collect();
    // Two rows of times, two of what frames do, two of hit rates, and two of steadiness.
    assert_eq!(rows.len(), 8, "{table}");
    assert!(rows[0].contains("1.00") && table.contains("report.html"), "{table}");
    assert!(table.contains("flicker %") && table.contains("wgpu passes"), "{table}");
    // Another number of frames and another allowed error are other pictures, so nothing is called unchanged.
    let more = ["--frames", "3", "--lod-error", "2", "-o", "again", "--compare", "out/report.json"];
    let other = place.text(&[&flight[..], &more].concat());
    let notes: Vec<&str> = other.lines().filter(|line| line.starts_with("nothing is compared")).collect();
    assert!(notes.len() == 2 && notes[0].contains("2 frames") && notes[1].contains("--lod-error 1"), "{other}");
    assert!(!other.contains("unchanged") && !other.contains("worse"), "{other}");
}

#[test]
fn a_bench_of_two_eyes_reports_how_they_agree() {
    if !has_gpu() {
        return;
    }
    let place = place_with_flight();
    let flight = ["bench", "dem.tif", "--path", "flight.csv", "--size", "96x54", "--frames", "3", "--temporal", "1"];
    let of = |styles: &str, more: &[&str]| {
        let report = place.json(&[&flight[..], &["--styles", styles, "-o", "out", "--json"], more].concat());
        report["runs"].as_array().unwrap().clone()
    };
    for run in of("lsa,strokes", &["--eyes", "side-by-side", "--ipd", "auto"]) {
        let stereo = &run["stereo"];
        assert_eq!((&run["eyes"], &stereo["pairs"]), (&"side-by-side".into(), &1.0.into()));
        assert_eq!(run["antialias"], "none");
        assert!(stereo["line_correlation"].as_f64().unwrap() > 0.8, "{stereo}");
        assert!(stereo["orphans"].as_f64().unwrap() < 0.02, "{stereo}");
        assert_eq!(stereo["other_identity"].is_number(), run["style"] == "strokes", "{stereo}");
        assert!(stereo["mark_correlation"].is_null(), "{stereo}");
    }
    // Without strokes, a bench has fewer frames.
    let alone = if full() { "lsa,strokes" } else { "lsa" };
    for run in of(alone, &["--antialias", "temporal"]) {
        let passes: Vec<&str> =
            run["passes"].as_array().unwrap().iter().filter_map(|pass| pass["name"].as_str()).collect();
        assert!(run["antialias"] == "temporal" && passes.contains(&"composite/temporal_aa"), "{passes:?}");
        // A single eye has no other eye to agree with.
        assert!(run["stereo"].is_null(), "{run}");
    }
    assert!(!full() || of(alone, &[]).iter().all(|run| run["stereo"].is_null()));
}
