//! Summits in `info`, and names of summits in `render`.

use hachure::file::png::{Picture, read_rgba8};
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
    let saddles = draw("saddles.svg", &[map[0], "--saddles", "2"]);
    let both = draw("both.svg", &[map[0], "--peaks", "3", "--saddles", "2"]);
    assert!(fills(&saddles) > 0 && fills(&both) == fills(&heights) + fills(&saddles));
    let error = place.misuse(&["render", "dem.tif", CAMERA, "--saddles", "2", "-o", "view.png"]);
    assert!(error.contains("--saddles: only maps have labels of saddles"), "{error}");
    let view = draw("view.svg", &[CAMERA, "--peaks", "5"]);
    assert!(fills(&view) > 0 && !view.contains("id=\"names-halo\""));
    // The words of each label are text over its letters; a pen has none.
    let words = |svg: &str| {
        let texts = svg.split("<text ").skip(1).filter_map(|text| text.split_once('>')?.1.split('<').next());
        texts.map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(words(&none).is_empty() && words(&heights).len() == 3, "{:?}", words(&heights));
    assert!(words(&main).iter().all(|text| text.starts_with("Peak 0 ")) && words(&all).len() > words(&main).len());
    let pens = draw("pens.svg", &[map[0], "--names", "peaks.geojson", "--pens", "1"]);
    assert!(words(&pens).is_empty() && pens.contains("id=\"names-pen-1\""));
    // Everything that labels depend on is in the imprint.
    place.text(&["render", "--like", "main.svg", "-o", "again.svg"]);
    let names =
        |svg: &str| svg.split("id=\"names\"").nth(1).and_then(|names| names.split("</g>").next()).map(str::to_owned);
    assert_eq!(names(&std::fs::read_to_string(place.path("again.svg")).unwrap()), names(&main));
    assert_ne!(names(&all), names(&main));
    // A film of the same land has the labels, too.
    place.file("path.csv", "t,x,y,z,yaw,pitch,fov\n0,0,-1300,+500,0,-15,60\n0.1,0,-1290,+500,0,-15,60\n");
    let film = ["render", "--like", "view.svg", "--path", "path.csv", "--fps", "10", "-o"];
    place.text(&[&film[..], &["film%d.svg"]].concat());
    let frame = |number: u32| std::fs::read_to_string(place.path(&format!("film{number}.svg"))).unwrap();
    assert!(fills(&frame(0)) > 0 && fills(&frame(1)) > 0);
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
    let lines = place.misuse(&draw(&["--peaks", "3", "--map", "-o", "a.geojson"]));
    assert!(lines.contains("--peaks") && lines.contains("a .geojson holds only lines"), "{lines}");
    assert_eq!(place.names().iter().filter(|name| name.ends_with(".png")).count(), 0);
}

/// Returns the rows of two pictures that differ by more than 40 levels, and how many pixels do.
fn differing(a: &Picture, b: &Picture) -> (Vec<usize>, usize) {
    let width = a.width as usize;
    let mut rows: Vec<usize> = Vec::new();
    let mut count = 0;
    for (i, (a, b)) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)).enumerate() {
        if a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 40) {
            count += 1;
            rows.push(i / width);
        }
    }
    rows.dedup();
    (rows, count)
}

/// The camera turns, so that summits enter the picture and leave it.
const TURN: &str = "t,x,y,z,yaw,pitch,fov\n0,-300,-1500,+500,-30,-6,50\n4,300,-1300,+500,40,-6,50\n";

#[test]
fn a_film_has_labels_and_its_parts_have_those_of_the_whole() {
    let place = Place::empty();
    dem(&place);
    place.file("turn.csv", TURN);
    let film = ["render", "dem.tif", "--path", "turn.csv", "--fps", "6", "--size", "240x150", "--style", "lsa"];
    let draw = |options: &[&str]| place.text(&[&film[..], options].concat());
    let read = |name: &str| read_rgba8(&place.path(name)).unwrap();
    draw(&["-o", "bare%02d.png", "--frames", "..10"]);
    draw(&["-o", "named%02d.png", "--peaks", "8", "--frames", "..10"]);
    // Labels are in the pixels of all frames, above the land.
    for number in 0..10 {
        let (rows, count) = differing(&read(&format!("bare{number:02}.png")), &read(&format!("named{number:02}.png")));
        assert!(count > 20 && rows[0] < 75, "frame {number}: {count} pixels, rows {rows:?}");
    }
    // A part begins with the labels of the whole.
    draw(&["-o", "part%02d.png", "--peaks", "8", "--frames", "6..10"]);
    let same = |number: u32| read(&format!("part{number:02}.png")) == read(&format!("named{number:02}.png"));
    assert!((6..10).all(same));
    // Planted: without the frames before the part.
    draw(&["-o", "part%02d.png", "--peaks", "8", "--frames", "6..10", "--warm-up", "0", "--overwrite"]);
    assert!(!(6..10).all(same));
    // The film in one file has the letters, too.
    draw(&["-o", "film.gif", "--peaks", "8", "--frames", "..2"]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut shown = options.read_info(std::fs::File::open(place.path("film.gif")).unwrap()).unwrap();
    let frame = Picture { width: 240, height: 150, rgba: shown.read_next_frame().unwrap().unwrap().buffer.to_vec() };
    assert!(differing(&frame, &read("named00.png")).1 < 20 && differing(&frame, &read("bare00.png")).1 > 20);
}

#[test]
fn both_eyes_of_a_picture_have_labels() {
    let place = Place::empty();
    dem(&place);
    let pair = ["render", "dem.tif", CAMERA, "--size", "240x150", "--style", "lsa", "--ipd", "40"];
    let draw = |options: &[&str]| {
        place.text(&[&pair[..], options].concat());
        read_rgba8(&place.path(options[1])).unwrap()
    };
    let half = |both: &Picture, eye: usize| {
        let rows = both.rgba.chunks_exact(4 * 480).flat_map(|row| &row[4 * 240 * eye..][..4 * 240]);
        Picture { width: 240, height: 150, rgba: rows.copied().collect() }
    };
    let both = draw(&["-o", "both.png", "--eyes", "side-by-side", "--peaks", "6"]);
    let bare = draw(&["-o", "bare.png", "--eyes", "side-by-side"]);
    let rows = [0, 1].map(|eye| differing(&half(&both, eye), &half(&bare, eye)).0);
    assert!(!rows[0].is_empty() && rows[0] == rows[1], "{rows:?}");
    // The left eye alone has the picture that the pair has.
    assert!(draw(&["-o", "left.png", "--eyes", "left", "--peaks", "6"]) == half(&both, 0));
    let mixed = draw(&["-o", "mixed.png", "--eyes", "anaglyph", "--peaks", "6"]);
    assert!(differing(&mixed, &draw(&["-o", "plain.png", "--eyes", "anaglyph"])).1 > 20);
    draw_svg(&place, &pair);
}

/// Draws an anaglyph as an SVG, in which each eye has a layer of letters.
fn draw_svg(place: &Place, pair: &[&str]) {
    let strokes: Vec<&str> = pair.iter().map(|word| if *word == "lsa" { "strokes" } else { word }).collect();
    place.text(&[&strokes[..], &["-o", "mixed.svg", "--eyes", "anaglyph", "--peaks", "6"]].concat());
    let svg = std::fs::read_to_string(place.path("mixed.svg")).unwrap();
    assert!(svg.contains("id=\"names-left-eye\"") && svg.contains("id=\"names-right-eye\""));
}

#[test]
fn lakes_have_the_height_of_their_water() {
    let place = Place::empty();
    // Hills with two lakes, and a third one that is too small for a label.
    let lakes = [(432, 15..60, 20..60), (515, 80..100, 30..50), (533, 110..113, 70..72)];
    let height_m = |column: i32, row: i32| {
        let lake = lakes.iter().find(|(_, columns, rows)| columns.contains(&column) && rows.contains(&row));
        lake.map_or_else(|| 600 + 7 * ((column * 7 + row * 13) % 9) + (column - 60).abs(), |(level_m, ..)| *level_m)
    };
    let row = |row: i32| (0..120).map(|column| height_m(column, row).to_string()).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..90).map(row).collect();
    let header = "ncols 120\nnrows 90\nxllcorner 500000\nyllcorner 5200000\ncellsize 30\n";
    place.file("lakes.asc", &format!("{header}{}\n", rows.join("\n")));
    let words = |options: &[&str]| {
        let render = ["render", "lakes.asc", "--map", "--style", "strokes", "--size", "360x270", "-o", "map.svg"];
        place.text(&[&render[..], options].concat());
        let svg = std::fs::read_to_string(place.path("map.svg")).unwrap();
        let texts = svg.split("<text ").skip(1).filter_map(|text| text.split_once('>')?.1.split('<').next());
        texts.map(str::to_owned).collect::<Vec<_>>()
    };
    // As many as asked for, the largest first.
    assert!(words(&[]).is_empty());
    assert_eq!(words(&["--lakes", "1"]), ["432"]);
    assert_eq!(words(&["--lakes", "5"]), ["432", "515"]);
    // Exaggerated land has the same heights, and water at the level of the sea is no lake.
    assert_eq!(words(&["--lakes", "1", "--exaggeration", "2"]), ["432"]);
    assert_eq!(words(&["--lakes", "5", "--sea-level", "432"]), ["515"]);
    // The ground of a sea is below it.
    assert_eq!(words(&["--lakes", "5", "--sea-level", "500"]), ["515"]);
    let error = place.misuse(&["render", "lakes.asc", "--lakes", "2", "-o", "view.png"]);
    assert!(error.contains("--lakes: only maps have labels of lakes"), "{error}");
}
