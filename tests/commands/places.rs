//! Places by latitude and longitude, the highest point, vertical exaggeration, and paths that suit their world.

use std::fmt::Write as _;

use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use serde_json::Value;

use crate::{Place, full};

const SIDE: usize = 201;
/// Latitude and longitude of the summit, in degrees: 60 columns east and 40 rows south of the north-western corner.
const SUMMIT: [f64; 2] = [46.56, 8.03];
const DEGREE_M: f64 = 111_150.0;

/// Returns a folder with a cone of 900 m in degrees (`hill.asc`), and the same without a reference system
/// (`plain.asc`).
fn place() -> Place {
    let place = Place::empty();
    let mut text = format!("ncols {SIDE}\nnrows {SIDE}\nxllcenter 8.0\nyllcenter 46.48\ncellsize 0.0005\n");
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let north_m = (40.0 - row as f64) * 0.0005 * DEGREE_M;
        let east_m = (column as f64 - 60.0) * 0.0005 * DEGREE_M * SUMMIT[0].to_radians().cos();
        write!(text, "{:.2} ", 1200.0 - 0.25 * east_m.hypot(north_m).max(10.0)).unwrap();
    }
    place.file("hill.asc", &text);
    let wgs84 = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]]"#;
    place.file("hill.prj", wgs84);
    let metres = text.replace("0.0005", "50").replace("8.0\n", "0\n").replace("46.48", "0");
    place.file("plain.asc", &metres);
    place
}

fn has_gpu() -> bool {
    let has = std::env::var_os("HACHURE_REQUIRE_GPU").is_some() || Gpu::open(&AdapterWish::Best).is_ok();
    if !has {
        println!("skipped: no GPU");
    }
    has
}

/// Runs the program, which must fail with one line after the warning that a DEM has no reference system.
fn error_of_plain(place: &Place, arguments: &[&str]) -> String {
    let output = place.hachure(arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
    let lines: Vec<&str> = said.lines().filter(|line| !line.contains("coordinate reference system")).collect();
    assert_eq!(lines.len(), 1, "{arguments:?}: {said}");
    lines[0].strip_prefix("hachure: ").unwrap().to_owned()
}

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_str() {
        Some(text) => text.split(',').map(|number| number.parse().unwrap()).collect(),
        None => value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect(),
    }
}

/// Returns east and north of a place in degrees, from the middle of the grid.
fn metres([latitude, longitude]: [f64; 2]) -> [f64; 2] {
    let [middle_lat, middle_lon] = [46.53, 8.05];
    [(longitude - middle_lon) * DEGREE_M * SUMMIT[0].to_radians().cos() * 1.0018, (latitude - middle_lat) * DEGREE_M]
}

#[test]
fn info_names_the_highest_point() {
    let place = place();
    let of_dem = place.json(&["info", "hill.asc", "--json"]);
    place.json(&["bake", "hill.asc", "-o", "hill.tif", "--json", "--max-error", "0"]);
    let of_pyramid = place.json(&["info", "hill.tif", "--json"]);
    for info in [&of_dem, &of_pyramid] {
        let highest = &info["highest"];
        let found = numbers(&highest["latitude_longitude_deg"]);
        assert!((found[0] - SUMMIT[0]).abs() < 1e-6 && (found[1] - SUMMIT[1]).abs() < 1e-6, "{highest}");
        assert!(
            (highest["height_m"].as_f64().unwrap() - 1197.5).abs() < 0.01 && highest["is_exact"] == true,
            "{highest}"
        );
        let world_m = numbers(&highest["world_m"]);
        let expected = metres(SUMMIT);
        assert!((world_m[0] - expected[0]).abs() < 10.0 && (world_m[1] - expected[1]).abs() < 10.0, "{highest}");
        assert_eq!(numbers(&highest["crs"]).len(), 2, "{highest}");
    }
    let text = place.text(&["info", "hill.asc"]);
    let line = "highest   1197.50 m at latitude, longitude 46.56000,8.03000; coordinates 8.030000, 46.560000; -15";
    assert!(text.contains(line), "{text}");
    let text = place.text(&["info", "plain.asc"]);
    assert!(text.contains("highest   1197.50 m at no latitude and longitude; coordinates 3000.0, 8000.0"), "{text}");
}

#[test]
fn a_place_is_looked_at_by_latitude_and_longitude() {
    if !has_gpu() {
        return;
    }
    let place = place();
    let render = ["render", "hill.asc", "-o", "a.png", "--size", "64x36", "--style", "plain", "--json"];
    let camera = |more: &[&str]| numbers(&place.json(&[&render[..], more].concat())["camera"]);
    // Returns how far a camera looks past a place, in degrees.
    let off_deg = |camera: &[f64], at: [f64; 2]| {
        let [x, y] = metres(at);
        let azimuth_deg = (x - camera[0]).atan2(y - camera[1]).to_degrees();
        ((azimuth_deg - camera[3] + 180.0).rem_euclid(360.0) - 180.0).abs()
    };
    let near = [46.52, 8.07];
    let found = camera(&["--look-at", "46.52,8.07"]);
    assert!(off_deg(&found, near) < 1.0, "{found:?}");
    // Planted: latitude and longitude exchanged are another place.
    assert!(off_deg(&found, [46.55, 8.03]) > 5.0, "{found:?}");
    let found = camera(&["--look-at", "46.52,8.07", "--from", "180,2000"]);
    let [x, y] = metres(near);
    assert!((found[0] - x).abs() < 10.0 && (found[1] - (y - 2000.0)).abs() < 10.0, "{found:?}");
    assert!(found[3].abs() < 0.2 || (found[3] - 360.0).abs() < 0.2, "{found:?}");
    // Without any of them, the summit.
    let found = camera(&[]);
    assert!(off_deg(&found, SUMMIT) < 2.0, "{found:?}");
    // The picture says which camera it was, so that it can be drawn again.
    place.text(&["render", "--like", "a.png", "-o", "b.png"]);
    let [a, b] = ["a.png", "b.png"].map(|name| hachure::file::png::read_rgba8(&place.path(name)).unwrap());
    assert!(a == b);

    let error = place.error(&["render", "hill.asc", "-o", "a.png", "--look-at", "8.07,46.52"]);
    let bounds = "latitudes are 46.4800 to 46.5800 and longitudes 8.0000 to 8.1000";
    assert!(error.starts_with("--look-at 8.07,46.52: outside of ") && error.ends_with(bounds), "{error}");
    let error = error_of_plain(&place, &["render", "plain.asc", "-o", "a.png", "--look-at", "46.52,8.07"]);
    assert_eq!(
        error,
        "--look-at 46.52,8.07: plain.asc has no reference system; give metres, with --camera x,y,z,yaw,pitch,fov"
    );
    let error = place.error(&["render", "-o", "a.png", "--look-at", "46.52,8.07"]);
    assert_eq!(
        error,
        "--look-at 46.52,8.07: the built-in world has no reference system; give metres, with --camera x,y,z,yaw,pitch,fov"
    );
    for (more, words) in [
        (&["--look-at", "1200,-350"][..], "it must be a latitude from -90 to 90"),
        (&["--look-at", "46.5,8", "--camera", "0,0,+9,0,0,50"], "--camera"),
        (&["--look-at", "46.5,8", "--map"], "--look-at: cannot be combined with --map"),
        (&["--from", "180,2000"], "--look-at"),
        (&["--look-at", "46.5,8", "--from", "180"], "it must be an azimuth"),
        (&["--at", "46.5,8"], "--map"),
        (&["--map", "--map-width", "500"], "--at"),
        (&["--map=0,0,500", "--at", "46.5,8"], "--at: cannot be combined with --map=EAST,NORTH"),
    ] {
        let error = place.misuse(&[&["render", "hill.asc", "-o", "a.png"], more].concat());
        assert!(error.contains(words), "{more:?}: {error}");
    }
}

#[test]
fn a_map_is_centred_on_a_latitude_and_longitude() {
    if !has_gpu() {
        return;
    }
    let place = place();
    let draw = |more: &[&str]| {
        place.text(
            &[&["render", "hill.asc", "-o", "m.png", "--size", "64x36", "--style", "plain", "--map"], more].concat(),
        );
        numbers(&place.json(&["info", "m.png", "--json"])["settings"]["map"])
    };
    let [x, y] = metres([46.52, 8.07]);
    let map = draw(&["--at", "46.52,8.07", "--map-width", "1500"]);
    assert!((map[0] - x).abs() < 10.0 && (map[1] - y).abs() < 10.0 && map[2] == 1500.0, "{map:?}");
    // A quarter of the width of the land.
    let map = draw(&["--at", "46.52,8.07"]);
    assert!((map[2] - 0.25 * 0.1 * DEGREE_M * SUMMIT[0].to_radians().cos()).abs() < 30.0, "{map:?}");
    let mesh = |at: &str| {
        place.json(&["render", "hill.asc", "-o", "m.glb", "--map", "--at", at, "--map-width", "900", "--json"])
    };
    let top_m = |mesh: &Value| mesh["heights_m"][1].as_f64().unwrap();
    assert!(top_m(&mesh("46.56,8.03")) > 1190.0 && top_m(&mesh("46.49,8.09")) < 800.0);
    let error = place.error(&["render", "hill.asc", "-o", "m.png", "--map", "--at", "47,8"]);
    assert!(error.starts_with("--at 47,8: outside of "), "{error}");
}

#[test]
fn heights_are_exaggerated_and_keep_their_names() {
    if !has_gpu() {
        return;
    }
    let place = place();
    // Returns the mean distance from the summit of each contour line, by its height.
    let lines = |factor: &str| {
        let style = if full() { "pen" } else { "strokes" };
        let arguments =
            ["render", "hill.asc", "-o", "m.geojson", "--map", "--style", style, "--size", "400x400", "--wgs84"];
        place.text(&[&arguments[..], &["--exaggeration", factor]].concat());
        let json: Value = serde_json::from_slice(&std::fs::read(place.path("m.geojson")).unwrap()).unwrap();
        let mut found = std::collections::BTreeMap::new();
        for feature in json["features"].as_array().unwrap() {
            let Some(height_m) = feature["properties"]["height_m"].as_f64() else { continue };
            let parts = feature["geometry"]["coordinates"].as_array().unwrap();
            let is_multi = feature["geometry"]["type"] == "MultiLineString";
            let points: Vec<&Value> = if is_multi {
                parts.iter().flat_map(|part| part.as_array().unwrap()).collect()
            } else {
                parts.iter().collect()
            };
            for point in points {
                let [x, y] = metres([point[1].as_f64().unwrap(), point[0].as_f64().unwrap()]);
                let [summit_x, summit_y] = metres(SUMMIT);
                let entry: &mut (f64, f64) = found.entry((10.0 * height_m).round() as i64).or_default();
                entry.0 += (x - summit_x).hypot(y - summit_y);
                entry.1 += 1.0;
            }
        }
        found.into_iter().map(|(height, (sum, count))| (height, sum / count)).collect::<Vec<_>>()
    };
    let (once, thrice) = (lines("1"), lines("3"));
    assert!(once.len() > 5, "{once:?}");
    let heights = |lines: &[(i64, f64)]| lines.iter().map(|(height, _)| *height).collect::<Vec<_>>();
    assert_eq!(heights(&once), heights(&thrice), "lines at the same true heights");
    for ((height, away_m), (_, thrice_m)) in once.iter().zip(&thrice) {
        let expected_m = (1200.0 - 0.1 * *height as f64) / 0.25;
        assert!((away_m - expected_m).abs() < 0.05 * expected_m + 60.0, "{height}: {away_m} {expected_m}");
        assert!((away_m - thrice_m).abs() < 0.02 * expected_m + 40.0, "{height}: {away_m} {thrice_m}");
    }
    // About sea level.
    let heights_m = |more: &[&str]| {
        numbers(
            &place.json(&[&["render", "hill.asc", "-o", "m.glb", "--json", "--mesh-error", "1"], more].concat())["heights_m"],
        )
    };
    let (once, thrice) = (heights_m(&[]), heights_m(&["--exaggeration", "3"]));
    assert!((0..2).all(|i| (3.0 * once[i] - thrice[i]).abs() < 5.0), "{once:?} {thrice:?}");
    // A picture records it.
    place.text(&["render", "hill.asc", "-o", "a.png", "--size", "64x36", "--style", "plain", "--exaggeration", "2.5"]);
    assert_eq!(place.json(&["info", "a.png", "--json"])["settings"]["exaggeration"], 2.5);
    place.text(&["render", "--like", "a.png", "-o", "b.png"]);
    place.text(&["render", "--like", "a.png", "-o", "c.png", "--exaggeration", "1"]);
    let [a, b, c] = ["a.png", "b.png", "c.png"].map(|name| hachure::file::png::read_rgba8(&place.path(name)).unwrap());
    assert!(a == b && a != c);
    for wrong in ["0", "-2", "nan", "1001", "x"] {
        let error = place.misuse(&["render", "hill.asc", "-o", "a.png", "--exaggeration", wrong]);
        assert!(error.contains("above 0, at most 1000"), "{wrong}: {error}");
    }
    // So does a benchmark.
    place.file("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+300,0,-10,50\n");
    let bench =
        ["bench", "hill.asc", "--path", "p.csv", "--styles", "plain", "--size", "48x27", "--frames", "1", "-o", "r"];
    let report = place.json(&[&bench[..], &["--exaggeration", "2", "--json", "--steadiness-pairs", "0"]].concat());
    assert_eq!(report["settings"]["exaggeration"], 2.0, "{report}");
}

#[test]
fn a_path_of_another_world_is_refused() {
    if !has_gpu() {
        return;
    }
    let place = place();
    let render = |path: &str| {
        ["render", "plain.asc", "-o", "f%d.png", "--size", "48x27", "--style", "plain", "--path", path]
            .map(str::to_owned)
    };
    let error = |path: &str| error_of_plain(&place, &render(path).iter().map(String::as_str).collect::<Vec<_>>());
    let refused = "--path tour: this built-in path is made for the built-in world and its scenes forest and hut, not for \
                   plain.asc; a path for plain.asc is a CSV file";
    assert!(error("tour").starts_with(refused), "{}", error("tour"));
    assert!(
        error("valley").contains("made for the built-in scene continent, not for plain.asc"),
        "{}",
        error("valley")
    );
    let bench = error_of_plain(&place, &["bench", "plain.asc", "--path", "teleport", "-o", "r", "--styles", "plain"]);
    assert!(bench.starts_with("--path teleport: this built-in path") && !place.path("r").exists(), "{bench}");

    let rows = |rows: &str| format!("t,x,y,z,yaw,pitch,fov\n{rows}");
    place.file("far.csv", &rows("0,0,0,+200,0,0,50\n1,90000,0,+200,0,0,50\n2,95000,0,+200,0,0,50\n"));
    let expected = "far.csv:3: its camera at x 90000, y 0 is 85000 m outside of the world, as are 2 of 3 rows outside or \
                    below; the path is made for another world: the world is from -5000 to 5000 m east";
    assert!(error("far.csv").starts_with(expected), "{}", error("far.csv"));
    place.file("deep.csv", &rows("0,0,0,50,0,0,50\n1,100,0,50,0,0,50\n2,200,0,5000,0,0,50\n"));
    assert!(error("deep.csv").starts_with("deep.csv:2: its camera at x 0, y 0 is "), "{}", error("deep.csv"));
    let bench = error_of_plain(&place, &["bench", "plain.asc", "--path", "deep.csv", "-o", "r", "--styles", "plain"]);
    assert!(bench.starts_with("deep.csv:2: "), "{bench}");
    assert!(place.names().iter().all(|name| !name.starts_with('f') || name == "far.csv"), "{:?}", place.names());

    // One of three is a warning, and none says nothing.
    place.file("some.csv", &rows("0,0,0,+200,0,0,50\n0.1,100,0,+200,0,0,50\n0.2,90000,0,+200,0,0,50\n"));
    place.file("good.csv", &rows("0,0,0,+200,0,0,50\n0.1,100,0,+200,0,0,50\n"));
    let said = |path: &str| {
        let output = place.hachure(&[&render(path).each_ref().map(String::as_str)[..], &["--fps", "20"]].concat());
        assert!(output.status.success(), "{path}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let warned = said("some.csv");
    assert!(
        warned.contains("some.csv:4: its camera at x 90000, y 0 is 85000 m outside of the world; 1 of 3"),
        "{warned}"
    );
    assert!(!said("good.csv").contains("good.csv"), "{}", said("good.csv"));
}
