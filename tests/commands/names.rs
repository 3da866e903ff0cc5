//! Summits in `info`, and names of summits in `render`.

use serde_json::Value;

use crate::Place;
use crate::dem::{SIZE, SPACING_M, dem};

/// A view over the synthetic DEM.
const CAMERA: &str = "--camera=0,-1300,+500,0,-15,60";

/// Returns the summits that `info` lists as JSON.
fn peaks(place: &Place, options: &[&str]) -> Vec<Value> {
    let all = [&["info", "dem.tif", "--json"], options].concat();
    place.json(&all)["peaks"].as_array().unwrap().clone()
}

#[test]
fn info_lists_summits_by_prominence() {
    let place = Place::empty();
    dem(&place);
    let found = peaks(&place, &["--peaks", "6"]);
    let number = |peak: &Value, key: &str| peak[key].as_f64().unwrap();
    let prominences: Vec<f64> = found.iter().map(|peak| number(peak, "prominence_m")).collect();
    assert!(found.len() == 6 && prominences.is_sorted_by(|a, b| a >= b), "{prominences:?}");
    // The first one is the highest point.
    let info = place.json(&["info", "dem.tif", "--json"]);
    assert_eq!(found[0]["height_m"], info["max_m"]);
    assert_eq!(found[0]["world_m"], info["highest"]["world_m"]);
    assert!(found[0]["isolation_m"].is_null() && !found[1]["isolation_m"].is_null(), "{found:?}");
    // Planted: the list by height has another order.
    let found = peaks(&place, &["--peaks", "40"]);
    let mut by_height = found.clone();
    by_height.sort_by(|a, b| number(b, "height_m").total_cmp(&number(a, "height_m")));
    assert_ne!(by_height, found);
    let prominent = peaks(&place, &["--peaks", "1000", "--prominence", "300"]);
    assert!(!prominent.is_empty() && prominent.iter().all(|peak| number(peak, "prominence_m") >= 300.0));
    let text = place.text(&["info", "dem.tif", "--peaks", "2"]);
    assert!(text.contains("summits   the 2 most prominent;"), "{text}");
    let none = place.text(&["info", "dem.tif", "--peaks", "2", "--prominence", "20000"]);
    assert!(none.ends_with("summits   none with a prominence of at least 20000 m\n"), "{none}");
    place.file("style.toml", "extends = \"pen\"\n");
    let error = place.error(&["info", "style.toml", "--peaks", "2"]);
    assert!(error.contains("style.toml: --peaks needs heights"), "{error}");
}

#[test]
fn names_are_groups_of_a_drawing() {
    let place = Place::empty();
    dem(&place);
    let found = peaks(&place, &["--peaks", "4"]);
    // Places of the summits in the reference system of the DEM.
    let feature = |(number, peak): (usize, &Value)| {
        let [column, row] = [0, 1].map(|axis| peak["sample"][axis].as_f64().unwrap());
        let at = [500_000.0 + (column + 0.5) * SPACING_M, 5_200_000.0 - (row + 0.5) * SPACING_M];
        assert!(column < f64::from(SIZE[0]) && row < f64::from(SIZE[1]));
        format!(
            "{{\"type\":\"Feature\",\"properties\":{{\"name\":\"Peak {number}\",\"kind\":\"{}\"}},\
             \"geometry\":{{\"type\":\"Point\",\"coordinates\":[{},{}]}}}}",
            if number == 0 { "main" } else { "other" },
            at[0],
            at[1]
        )
    };
    let features: Vec<String> = found.iter().enumerate().map(feature).collect();
    let crs = "\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"urn:ogc:def:crs:EPSG::32632\"}}";
    let text = format!("{{\"type\":\"FeatureCollection\",{crs},\"features\":[{}]}}", features.join(","));
    place.file("peaks.geojson", &text);
    let draw = |output: &str, options: &[&str]| {
        let all = [&["render", "dem.tif", "--style", "strokes", "--size", "320x200", "-o", output], options].concat();
        place.text(&all);
        std::fs::read_to_string(place.path(output)).unwrap()
    };
    let fills = |svg: &str| {
        svg.split("id=\"names\"")
            .nth(1)
            .map_or(0, |names| names.split("</g>").next().unwrap_or("").matches("<path").count())
    };
    let map = ["--map=0,0,3600"];
    let none = draw("none.svg", &map);
    let all = draw("all.svg", &[map[0], "--names", "peaks.geojson"]);
    let main = draw("main.svg", &[map[0], "--names", "peaks.geojson", "--name-when", "kind == 'main'"]);
    let heights = draw("heights.svg", &[map[0], "--peaks", "3"]);
    assert_eq!(fills(&none), 0);
    assert!(fills(&all) > fills(&main) && fills(&main) > 0, "{} {}", fills(&all), fills(&main));
    assert!(fills(&heights) > 0 && all.contains("id=\"names-halo\""));
    let view = draw("view.svg", &[CAMERA, "--peaks", "5"]);
    assert!(fills(&view) > 0 && !view.contains("id=\"names-halo\""));
    // Everything that labels depend on is in the imprint.
    place.text(&["render", "--like", "main.svg", "-o", "again.svg"]);
    let names =
        |svg: &str| svg.split("id=\"names\"").nth(1).and_then(|names| names.split("</g>").next()).map(str::to_owned);
    assert_eq!(names(&std::fs::read_to_string(place.path("again.svg")).unwrap()), names(&main));
    assert_ne!(names(&all), names(&main));
    // A film of the same view has no labels, and says nothing of options that nobody typed.
    place.file("path.csv", "t,x,y,z,yaw,pitch,fov\n0,0,-1300,+500,0,-15,60\n0.1,0,-1290,+500,0,-15,60\n");
    place.text(&["render", "--like", "main.svg", "--path", "path.csv", "--fps", "10", "-o", "film%d.png"]);
    // Without the file, the error does not say what is in it.
    place.file("peaks.geojson", "secret,more\n1,2\n");
    let error = place.error(&["render", "--like", "main.svg", "-o", "other.svg"]);
    assert!(error.contains("its file of names") && !error.contains("secret"), "{error}");
}

#[test]
fn names_that_cannot_be_drawn_are_one_line() {
    let place = Place::empty();
    dem(&place);
    place.file("codes.csv", "lon,lat,code\n9.0,46.9,3\n");
    fn draw<'a>(options: &[&'a str]) -> Vec<&'a str> {
        [&["render", "dem.tif", "--size", "64x48"], options].concat()
    }
    let missing = place.error(&draw(&["--names", "nothing.gpx", "-o", "a.png"]));
    assert!(missing.contains("nothing.gpx"), "{missing}");
    let unnamed = place.error(&draw(&["--names", "codes.csv", "-o", "a.png"]));
    assert!(unnamed.contains("codes.csv: no attribute is called name, title, label or text; choose one with --name-field: its attributes are code"), "{unnamed}");
    let condition =
        place.error(&draw(&["--names", "codes.csv", "--name-field", "code", "--name-when", "cod > 3", "-o", "a.png"]));
    assert!(condition.contains("column 1: there is no attribute"), "{condition}");
    let wrong = place.misuse(&draw(&["--names", "codes.csv", "--name-when", "code = 3", "-o", "a.png"]));
    assert!(wrong.contains("use =="), "{wrong}");
    let film = place.misuse(&draw(&["--peaks", "3", "-o", "a%d.png", "--path", "tour"]));
    assert!(film.contains("films cannot have labels yet"), "{film}");
    let pair = place.misuse(&draw(&["--peaks", "3", "--eyes", "anaglyph", "-o", "a.png"]));
    assert!(pair.contains("stereo pairs cannot have labels yet"), "{pair}");
    assert_eq!(place.names().iter().filter(|name| name.ends_with(".png")).count(), 0);
}
