//! `render --frames`: parts of a film join, and short films and meshes are written.

use glam::DVec3;
use hachure::file::png::{Picture, read_rgba8};
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::dem::{SIZE, SPACING_M, dem};
use crate::{Place, full};

const PATH: &str = "t,x,y,z,yaw,pitch,fov\n0,-300,-900,+200,0,-10,50\n4,200,-500,+150,30,-14,50\n";
const RENDER: [&str; 8] = ["render", "dem.tif", "--path", "path.csv", "--fps", "10", "--size", "64x36"];

/// Returns a folder with a DEM and a path; `None` without a GPU.
fn place() -> Option<Place> {
    if std::env::var_os("HACHURE_REQUIRE_GPU").is_none() && Gpu::open(&AdapterWish::Best).is_err() {
        println!("skipped: no GPU");
        return None;
    }
    let place = Place::empty();
    dem(&place);
    place.file("path.csv", PATH);
    Some(place)
}

/// Draws frames, and returns the frame with a number.
fn frame(place: &Place, number: u32, more: &[&str]) -> Picture {
    place.text(&[&RENDER[..], &["-o", "f%02d.png"], more].concat());
    let picture = read_rgba8(&place.path(&format!("f{number:02}.png"))).unwrap();
    for left in 0..=40 {
        let _ = std::fs::remove_file(place.path(&format!("f{left:02}.png")));
    }
    picture
}

/// Returns the largest difference of a channel.
fn farthest(a: &Picture, b: &Picture) -> u8 {
    a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn a_part_of_a_film_has_the_frames_of_the_whole() {
    let Some(place) = place() else { return };
    // Strokes continue from the first frame on.
    let strokes = ["--style", "strokes"];
    let whole = frame(&place, 14, &[&strokes[..], &["--frames", "..16"]].concat());
    let part = frame(&place, 14, &[&strokes[..], &["--frames", "14..15"]].concat());
    assert!(whole == part, "a stroke style: {}", farthest(&whole, &part));
    let cold = frame(&place, 14, &[&strokes[..], &["--frames", "14..15", "--warm-up", "0"]].concat());
    assert!(farthest(&whole, &cold) > 4, "planted error, a part without the frames before it");
    // Temporal anti-aliasing forgets: after 32 frames, a rounding is left.
    let mean = ["--style", "lsa", "--antialias", "temporal"];
    let whole = frame(&place, 34, &[&mean[..], &["--frames", "..35"]].concat());
    let part = |warm_up: &str| frame(&place, 34, &[&mean[..], &["--frames", "34..35", "--warm-up", warm_up]].concat());
    assert!(farthest(&whole, &part("32")) <= 2, "{}", farthest(&whole, &part("32")));
    assert!(farthest(&whole, &part("0")) > 8, "planted error, a part without the frames before it");
    let all = || frame(&place, 34, &[&mean[..], &["--frames", "34..35"]].concat());
    assert!(!full() || whole == all(), "all frames before it");
}

#[test]
fn parts_are_checked() {
    let place = Place::empty();
    dem(&place);
    place.file("path.csv", PATH);
    for (more, words) in [
        (&["-o", "f%d.png", "--frames", "41..50"][..], "41 frames, with the numbers 0 to 40"),
        (&["-o", "f%d.png", "--frames", "5..5"], "100..200"),
        (&["-o", "f%d.png", "--warm-up", "5"], "requires --frames"),
        (&["-o", "f%d.png", "--mesh-error", "5"], "--mesh-error"),
        (&["-o", "land.stl"], "--fps: does not apply to a mesh"),
    ] {
        let error = place.misuse(&[&RENDER[..], more].concat());
        assert!(error.contains(words), "{error}");
    }
    // A fraction is a frame rate, with the same number of frames.
    let error = place.misuse(&[
        "render",
        "dem.tif",
        "--path",
        "path.csv",
        "--fps",
        "30000/1001",
        "-o",
        "f%d.png",
        "--frames",
        "900..",
    ]);
    assert!(error.contains("the film has 120 frames"), "{error}");
}

#[test]
fn a_short_film_is_a_gif() {
    let Some(place) = place() else { return };
    place.text(&[&RENDER[..], &["--style", "pen", "--frames", "..4", "-o", "film.gif"]].concat());
    let first = frame(&place, 0, &["--style", "pen", "--frames", "..1"]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut film = options.read_info(std::fs::File::open(place.path("film.gif")).unwrap()).unwrap();
    let shown = Picture { width: 96, height: 54, rgba: film.read_next_frame().unwrap().unwrap().buffer.to_vec() };
    assert!(farthest(&shown, &first) < 32, "{}", farthest(&shown, &first));
    let mut frames = 1;
    while film.read_next_frame().unwrap().is_some() {
        frames += 1;
    }
    assert_eq!(frames, 4);
}

/// Reads the triangles of a binary STL.
fn stl(bytes: &[u8]) -> Vec<[DVec3; 3]> {
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let corner = |at: usize| DVec3::new(number(at), number(at + 4), number(at + 8));
    (0..count).map(|i| [1, 2, 3].map(|k| corner(84 + 50 * i + 12 * k))).collect()
}

/// Tests the program's meshes; `src/land_mesh/tests.rs` tests the triangles. The DEM has an area without data.
#[test]
fn the_land_is_a_solid_within_the_error() {
    let place = Place::empty();
    dem(&place);
    let report =
        |file: &str, error: &str| place.json(&["render", "dem.tif", "-o", file, "--mesh-error", error, "--json"]);
    let [fine, coarse] = ["4", "40"].map(|error| report("land.stl", error));
    let count = |report: &serde_json::Value| report["triangles"].as_u64().unwrap();
    assert!(count(&coarse) * 4 < count(&fine), "{fine} {coarse}");
    assert!(fine["error_m"].as_f64().unwrap() <= 4.0 && coarse["error_m"].as_f64().unwrap() > 4.0);
    let triangles = stl(&std::fs::read(place.path("land.stl")).unwrap());
    // Every edge has one partner in the other direction, bit for bit.
    let bits = |at: DVec3| at.to_array().map(f64::to_bits);
    let mut open = std::collections::HashMap::<_, i32>::new();
    for [a, b, c] in &triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (bits(*from), bits(*to));
            *open.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    assert!(open.values().all(|count| *count == 0), "the solid has an open edge");
    let all = || triangles.iter().flatten();
    let size = all().copied().reduce(DVec3::max).unwrap() - all().copied().reduce(DVec3::min).unwrap();
    let land_m = [0, 1].map(|axis| f64::from(SIZE[axis] - 1) * SPACING_M);
    assert!((size.x - land_m[0]).abs() < 0.1 && (size.y - land_m[1]).abs() < 0.1, "{size} instead of {land_m:?}");
    // A part of the land, as glTF.
    place.text(&["render", "dem.tif", "-o", "land.glb", "--map=0,0,600", "--size", "100x50"]);
    let bytes = std::fs::read(place.path("land.glb")).unwrap();
    assert_eq!(&bytes[..4], b"glTF");
    let json = &bytes[20..20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize];
    let json: serde_json::Value = serde_json::from_slice(json).unwrap();
    let bound = |end: &str, axis: usize| json["accessors"][0][end][axis].as_f64().unwrap();
    let [width, depth] = [0, 2].map(|axis| bound("max", axis) - bound("min", axis));
    assert!((width - 600.0).abs() < 6.0 && (depth - 300.0).abs() < 6.0, "{width} x {depth} m");
    assert_eq!(json["asset"]["extras"]["crs"], "EPSG:32632");
}
