//! Tests warnings and refusals that need a world, or a picture that was drawn.

use std::fmt::Write as _;

use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::Place;

/// Returns a folder with the DEM of a hill from 100 to 400 m high, `hill.asc`; `None` without a GPU.
fn place() -> Option<Place> {
    if std::env::var_os("HACHURE_REQUIRE_GPU").is_none() && Gpu::open(&AdapterWish::Best).is_err() {
        println!("skipped: no GPU");
        return None;
    }
    let place = Place::new();
    let mut text = "ncols 60\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 25\n".to_owned();
    for (row, column) in (0..50).flat_map(|row| (0..60).map(move |column| (row, column))) {
        let from_middle = f64::from(column - 30).hypot(f64::from(row - 25));
        write!(text, "{:.1} ", (400.0 - 10.0 * from_middle).max(100.0)).unwrap();
    }
    place.file("hill.asc", text);
    Some(place)
}

/// Draws a picture with these arguments, and returns what was printed to standard error.
fn drawn(place: &Place, arguments: &[&str]) -> String {
    let output = place.hachure(&[&["render", "--size", "64x36", "-o"], arguments].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {said}");
    said
}

#[test]
fn a_sea_that_changes_nothing_or_leaves_no_land_is_a_warning() {
    let Some(place) = place() else { return };
    let warnings = |level: &str, style: &str| -> Vec<String> {
        let said = drawn(&place, &["sea.png", "hill.asc", "--style", style, &format!("--sea-level={level}")]);
        said.lines().filter(|line| line.contains("--sea-level")).map(str::to_owned).collect()
    };
    for (level, words) in
        [("50", "--sea-level 50: all land is above it"), ("900", "--sea-level 900: no land is above it")]
    {
        let found = warnings(level, "wash");
        assert_eq!(found.len(), 1, "{found:?}");
        let heights = "its heights are from 100.0 to 400.0 m";
        assert!(found[0].contains(words) && found[0].contains(heights), "{found:?}");
    }
    let found = warnings("200", "plain");
    assert!(found.len() == 1 && found[0].contains("style plain draws no water"), "{found:?}");
    // Planted: a sea between the heights, in a style with water, is no warning.
    assert_eq!(warnings("200", "wash"), Vec::<String>::new());
}

#[test]
fn a_picture_of_a_dem_is_not_drawn_again_with_a_seed() {
    let Some(place) = place() else { return };
    drawn(&place, &["hill.png", "hill.asc", "--style", "plain"]);
    let again = ["render", "-o", "again.png", "--like", "hill.png"];
    let words = ["--seed 2", "hill.asc", "its land has no seed; only the built-in world"];
    place.refused(&[&again[..], &["--seed", "2"]].concat(), 2, &words);
    assert!(!place.0.path().join("again.png").exists());
    // Planted: without the seed it is drawn.
    assert!(place.hachure(&again).status.success());
    assert!(place.0.path().join("again.png").exists());
}
