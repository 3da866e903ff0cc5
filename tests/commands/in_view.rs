//! Drawings of worlds that are mostly no-data, and what the program says about them.

use std::fmt::Write as _;

use hachure::file::png::read_rgba8;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::{Place, full};

/// Columns and rows of the DEM, 30 m apart.
const SIDE: usize = 300;

fn has_gpu() -> bool {
    let has = std::env::var_os("HACHURE_REQUIRE_GPU").is_some() || Gpu::open(&AdapterWish::Best).is_ok();
    if !has {
        println!("skipped: no GPU");
    }
    has
}

/// Writes a DEM with heights only where `is_land` says so; `-9999` elsewhere.
fn dem(place: &Place, name: &str, is_land: impl Fn(usize, usize) -> bool, header: &str) {
    let mut text = format!("ncols {SIDE}\nnrows {SIDE}\nxllcorner 0\nyllcorner 0\ncellsize 30\n{header}");
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let (x, y) = (column as f64 / 9.0, row as f64 / 7.0);
        let height_m = if is_land(column, row) { 400.0 + 60.0 * x.sin() * y.cos() + x } else { -9999.0 };
        write!(text, "{height_m:.1} ").unwrap();
    }
    place.file(name, &text);
}

const NO_DATA: &str = "nodata_value -9999\n";

/// Runs the program, which must succeed; returns what it printed to standard error, without the warning about the
/// reference system.
fn said(place: &Place, arguments: &[&str]) -> Vec<String> {
    let output = place.hachure(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    stderr.lines().filter(|line| !line.contains("coordinate reference system")).map(str::to_owned).collect()
}

/// Returns how many pixels of a picture are darker than paper with its grain.
fn dark(place: &Place, name: &str) -> usize {
    let picture = read_rgba8(&place.path(name)).unwrap();
    picture.rgba.chunks_exact(4).filter(|pixel| pixel[0] < 215).count()
}

#[test]
fn the_default_camera_sees_the_data() {
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place, "corner.asc", |column, row| (4..40).contains(&column) && (250..290).contains(&row), NO_DATA);
    // A strip of LiDAR that is narrower than the samples of a coarse level, and a ring around a hole.
    dem(&place, "strip.asc", |column, row| column.abs_diff(row / 3 + 190) < 3, NO_DATA);
    dem(&place, "ring.asc", |column, row| (110..149).contains(&column.abs_diff(150).max(row.abs_diff(150))), NO_DATA);
    for name in ["strip.asc", "ring.asc", "corner.asc"].into_iter().take(if full() { 3 } else { 2 }) {
        let arguments = ["render", name, "-o", "a.png", "--size", "64x36", "--style", "wash", "--voids", "holes"];
        assert_eq!(said(&place, &arguments), [""; 0], "{name}");
        assert!(dark(&place, "a.png") > 20, "{name}: {} dark pixels", dark(&place, "a.png"));
    }
}

#[test]
fn a_blank_picture_is_reported_once() {
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place, "corner.asc", |column, row| (4..40).contains(&column) && (250..290).contains(&row), NO_DATA);
    place.file("up.csv", "t,x,y,z,yaw,pitch,fov\n0,-4000,-4000,900,0,80,40\n0.04,-4000,-4000,900,0,81,40\n");
    place.file("away.csv", "t,x,y,z,yaw,pitch,fov\n0,-3800,-3800,900,0,-80,40\n0.04,-4000,-4000,900,0,81,40\n");
    let world = ["render", "corner.asc", "--size", "64x36"];
    for (arguments, words) in [
        (&["-o", "a.png", "--camera=0,0,900,0,-30,50"][..], "only sky or no-data is in view: the heights are from"),
        (&["-o", "a.svg", "--style", "strokes", "--camera=0,0,900,0,-30,50"], "only sky or no-data is in view: "),
        (&["-o", "a.exr", "--eyes", "side-by-side", "--camera=0,0,900,0,-30,50"], "only sky or no-data is in view: "),
        (&["-o", "a.png", "--map=0,0,500"], "the map shows only no-data: "),
        (&["-o", "a.tif", "--map=0,0,500"], "the map shows only no-data: "),
        (&["-o", "a%d.png", "--path", "up.csv", "--fps", "50"], "in view in 3 of 3 frames: "),
        (&["-o", "b%d.png", "--path", "away.csv", "--fps", "25"], "in view in 1 of 2 frames: "),
        (&["-o", "a.png", "--camera=0,0,90000000,0,-90,1"], "in view: "),
    ] {
        let is_styled = full() || arguments.contains(&"--style");
        let style = if is_styled { &[][..] } else { &["--style", "plain"] };
        let lines = said(&place, &[&world[..], arguments, style].concat());
        let about: Vec<_> = lines.iter().filter(|line| line.contains(words)).collect();
        assert_eq!(about.len(), 1, "{arguments:?}: {lines:?}");
    }
    // The map that the line proposes shows the heights. Planted: so does not the map elsewhere, above.
    let lines = said(&place, &[&world[..], &["-o", "a.png", "--map=0,0,500"]].concat());
    let map = lines.iter().find_map(|line| line.split("--map=").nth(1)).unwrap().split(' ').next().unwrap();
    let lines = said(&place, &[&world[..], &["-o", "m.png", &format!("--map={map}")]].concat());
    let of_place = "m.png.aux.xml: not written, because the heights have no reference system";
    assert!(lines.len() == 1 && lines[0].contains(of_place), "{lines:?}");
    assert!(dark(&place, "m.png") > 100);
    // Land in view that shows nothing: a slope of a third of a millimetre per metre.
    let heights: String = (0..3600).map(|i| format!("{:.2} ", 100.0 + 0.01 * f64::from(i % 60))).collect();
    place.file("flat.asc", &format!("ncols 60\nnrows 60\nxllcorner 0\nyllcorner 0\ncellsize 30\n{heights}"));
    let flat = ["render", "flat.asc", "-o", "a.png", "--size", "64x36", "--camera=0,0,+300,0,-90,40"];
    let lines = said(&place, &[&flat[..], &["--style", "suggestive"]].concat());
    assert!(lines.len() == 1 && lines[0].contains("nearly blank"), "{lines:?}");
}

#[test]
fn bake_and_info_say_where_the_data_are() {
    let place = Place::empty();
    dem(&place, "corner.asc", |column, row| (4..40).contains(&column) && (250..290).contains(&row), NO_DATA);
    let of_dem = place.json(&["info", "corner.asc", "--json"]);
    let of_bake = place.json(&["bake", "corner.asc", "-o", "b.tif", "--json", "--max-error", "0"]);
    let of_pyramid = place.json(&["info", "b.tif", "--json"]);
    for info in [of_dem, of_bake, of_pyramid] {
        assert_eq!(info["data_samples"], serde_json::json!([[4, 250], [39, 289]]), "{info}");
        // The centre is at column and row 149.5.
        assert_eq!(info["data_extent_m"], serde_json::json!([-4365.0, -4185.0, -3315.0, -3015.0]), "{info}");
        assert!((info["void_share"].as_f64().unwrap() - (1.0 - 36.0 * 40.0 / 90_000.0)).abs() < 1e-9, "{info}");
    }
    let text = place.text(&["info", "b.tif"]);
    assert!(text.contains("data      columns 4 to 39, rows 250 to 289: -4365 to -3315 m east"), "{text}");
    // What is stored without loss has no error.
    assert!(text.lines().any(|line| line.starts_with("level 0") && line.ends_with("largest error 0 m")), "{text}");
    assert!(text.lines().any(|line| line.starts_with("level 1") && !line.ends_with("largest error 0 m")), "{text}");
}

#[test]
fn warnings_about_samples_are_repeated_from_the_cache() {
    if !has_gpu() {
        return;
    }
    let place = Place::empty();
    // No-data that the file does not declare.
    dem(&place, "marks.asc", |column, _| column > 5, "");
    let arguments = ["render", "marks.asc", "-o", "a.png", "--size", "48x27", "--style", "plain"];
    let first = said(&place, &arguments);
    assert!(first.len() == 1 && first[0].contains("marks.asc: 1800 samples are -9999 m"), "{first:?}");
    assert_eq!(said(&place, &arguments), first);
    // With the option, which makes another pyramid, there is nothing to warn about.
    assert_eq!(said(&place, &[&arguments[..], &["--nodata", "-9999"]].concat()), [""; 0]);
    assert_eq!(said(&place, &[&arguments[..], &["--nodata", "-9999"]].concat()), [""; 0]);
}
