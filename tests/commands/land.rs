//! The sea, the trees and the seed of a world on the command line: a scene with the option is the scene file with the key.

use std::fmt::Write as _;

use hachure::file::png::{Picture, read_rgba8};
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::{Place, full};

const SIZE: [&str; 2] = ["--size", "96x54"];

fn has_gpu() -> bool {
    let has = std::env::var_os("HACHURE_REQUIRE_GPU").is_some() || Gpu::open(&AdapterWish::Best).is_ok();
    if !has {
        println!("skipped: no GPU");
    }
    has
}

/// Writes a DEM of a valley between two slopes, `valley.asc`.
fn with_valley(place: Place) -> Place {
    let mut text = "ncols 120\nnrows 100\nxllcorner 0\nyllcorner 0\ncellsize 25\n".to_owned();
    for (row, column) in (0..100).flat_map(|row| (0..120).map(move |column| (row, column))) {
        let (x, y) = (f64::from(column) - 60.0, f64::from(row) - 50.0);
        write!(text, "{:.2} ", 500.0 + 6.0 * x.abs() + 20.0 * (y / 9.0).sin() + 0.7 * y).unwrap();
    }
    place.file("valley.asc", &text);
    place
}

/// Draws a world with options and returns the picture.
fn drawn(place: &Place, name: &str, arguments: &[&str]) -> Picture {
    place.text(&[&["render", "-o", name][..], &SIZE, arguments].concat());
    read_rgba8(&place.path(name)).unwrap()
}

#[test]
fn a_sea_and_trees_are_those_of_a_scene_file() {
    if !has_gpu() {
        return;
    }
    let place = with_valley(Place::empty());
    let view = ["--style", if full() { "ink" } else { "lsa" }, "--camera=0,-1150,+160,0,-8,60"];
    place.file("both.toml", "[world]\ndem = \"valley.asc\"\n[forest]\nseed = 3\n[water]\nsea_level_m = 560\n");
    let draw = |name: &str, world: &str, more: &[&str]| drawn(&place, name, &[&[world][..], &view, more].concat());
    let bare = draw("bare.png", "valley.asc", &[]);
    let both = draw("a.png", "both.toml", &[]);
    assert!(draw("both.png", "valley.asc", &["--sea-level", "560", "--trees", "3"]) == both && both != bare);
    // Planted: another level, another seed.
    let flooded = draw("b.png", "both.toml", &["--trees", "off"]);
    assert!(draw("b.png", "both.toml", &["--sea-level", "540", "--trees", "off"]) != flooded);
    assert!(!full() || draw("b.png", "both.toml", &["--trees", "4"]) != both);
    // Both can be removed.
    assert!(draw("b.png", "both.toml", &["--sea-level", "none", "--trees", "off"]) == bare);

    // A picture records it. `tests/window/land.rs` draws such a picture again, too.
    assert!(!full() || drawn(&place, "again.png", &["--like", "both.png"]) == both);
    let settings = &place.json(&["info", "both.png", "--json"])["settings"];
    assert!(settings["sea_level"] == "560" && settings["trees"] == "3", "{settings}");
    // So does a benchmark.
    place.file("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+300,0,-10,50\n");
    let bench = ["bench", "valley.asc", "--path", "p.csv", "--styles", "plain", "--size", "48x27", "--frames", "1"];
    let trees = if full() { "7" } else { "off" };
    let more = ["-o", "r", "--json", "--steadiness-pairs", "0", "--sea-level", "none", "--trees", trees];
    let settings = &place.json(&[&bench[..], &more].concat())["settings"];
    assert!(settings["sea_level"] == "none" && settings["trees"] == trees && settings["seed"].is_null(), "{settings}");

    for wrong in ["--sea-level=9001", "--sea-level=deep", "--trees=some", "--seed=-1"] {
        let error = place.misuse(&["render", "valley.asc", "-o", "x.png", wrong]);
        assert!(error.contains(wrong.split('=').next().unwrap()), "{error}");
    }
}

#[test]
fn only_grown_land_has_another_seed() {
    let place = with_valley(Place::empty());
    let refused = |arguments: &[&str]| place.misuse(&[&["render", "-o", "x.png"], arguments].concat());
    let error = refused(&["valley.asc", "--seed", "2"]);
    assert!(error.starts_with("--seed 2: valley.asc: its land has no seed; only the built-in world"), "{error}");
    let error = refused(&["hut", "--seed", "2"]);
    assert!(error.starts_with("--seed 2: hut: its models are made for the land of seed 1"), "{error}");
    let error = place.error(&["render", "-o", "x%d.png", "--path", "tour", "--seed", "2"]);
    assert!(error.contains("not for the built-in world with seed 2;"), "{error}");
    assert!(!place.path("x.png").exists());
}

#[test]
fn a_seed_is_that_of_a_scene_file() {
    if !has_gpu() {
        return;
    }
    let place = Place::with_built_in_land();
    place.file("two.toml", "[world]\nprocedural = { seed = 2 }\n");
    let view = ["--style", "plain"];
    let two = drawn(&place, "two.png", &[&["two.toml"][..], &view].concat());
    let seeded = drawn(&place, "seeded.png", &[&view[..], &["--seed", "2"]].concat());
    assert!(seeded == two);
    // Planted: the land of seed 1, from the same camera.
    let camera = place.json(&["info", "seeded.png", "--json"])["camera"].as_str().unwrap().to_owned();
    let one = drawn(&place, "one.png", &[&view[..], &["--camera", &camera]].concat());
    assert!(one != two);

    // A picture records it.
    assert!(!full() || drawn(&place, "again.png", &["--like", "seeded.png"]) == two);
    assert_eq!(place.json(&["info", "seeded.png", "--json"])["settings"]["seed"], 2);
}
