//! `render --show NAME`: intermediate pictures of a frame, as its passes wrote them.

use hachure::file::exr::read_exr;
use hachure::file::png::read_rgba8;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::Place;
use crate::dem::dem;

const RENDER: [&str; 8] =
    ["render", "dem.tif", "--style", "lsa", "--camera=-900,-900,+150,40,-12,60", "--size", "96x54", "-o"];

#[test]
fn a_picture_of_the_frame_is_written_as_it_stands() {
    if std::env::var_os("HACHURE_REQUIRE_GPU").is_none() && Gpu::open(&AdapterWish::Best).is_err() {
        println!("skipped: no GPU");
        return;
    }
    let place = Place::empty();
    dem(&place);
    place.text(&[&RENDER[..], &["drawn.exr", "--aov", "normal,depth,surface"]].concat());
    let drawn = read_exr(&place.path("drawn.exr")).unwrap();
    let show = |name: &str, file: &str| {
        place.text(&[&RENDER[..], &[file, "--show", name]].concat());
        place.path(file)
    };
    // In an EXR, values are raw and bit-identical to those of the corresponding channels.
    let shown = read_exr(&show("normal", "shown.exr")).unwrap();
    assert_eq!([shown.width, shown.height], [96, 54]);
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    for (channel, name) in [("R", "normal.X"), ("G", "normal.Y")] {
        assert_eq!(bits(shown.f32(channel).unwrap()), bits(drawn.f32(name).unwrap()), "{name}");
    }
    // Planted error: another channel.
    assert_ne!(bits(shown.f32("R").unwrap()), bits(drawn.f32("normal.Y").unwrap()));
    // The distance is 0 in the sky, where the depth is infinite.
    let distances = read_exr(&show("distance", "distance.exr")).unwrap();
    let (distances_m, depths_m) = (distances.f32("Y").unwrap(), drawn.f32("depth.V").unwrap());
    assert!(depths_m.iter().any(|depth_m| depth_m.is_finite()));
    for (distance_m, depth_m) in distances_m.iter().zip(depths_m) {
        let is_same = (distance_m / depth_m - 1.0).abs() < 0.01;
        assert!(if depth_m.is_finite() { is_same } else { *distance_m == 0.0 }, "{distance_m} {depth_m}");
    }
    let ids = read_exr(&show("surface id", "ids.exr")).unwrap();
    assert_eq!(ids.u32("id").unwrap(), drawn.u32("surface.id").unwrap());
    // For a PNG, the name may have a hyphen in place of the space; each id has its own colour.
    let png = read_rgba8(&show("surface-id", "ids.png")).unwrap();
    assert_eq!([png.width, png.height], [96, 54]);
    let color = |i: usize| &png.rgba[4 * i..4 * i + 3];
    let numbers = ids.u32("id").unwrap();
    assert!((1..numbers.len()).all(|i| numbers[i] != numbers[i - 1] || color(i) == color(i - 1)));
    assert!((1..numbers.len()).any(|i| color(i) != color(i - 1)));
    // The final picture is shown as it is rendered.
    place.text(&[&RENDER[..], &["drawn.png"]].concat());
    let picture = read_rgba8(&show("picture", "picture.png")).unwrap();
    assert!(picture == read_rgba8(&place.path("drawn.png")).unwrap());
    // An array shows as many layers as fit into the picture's size: here one of 260 × 260.
    let tiles = read_exr(&show("height tiles", "tiles.exr")).unwrap();
    assert_eq!([tiles.width, tiles.height], [260, 260]);
    assert!(tiles.f32("Y").unwrap().iter().any(|height_m| *height_m > 100.0));

    let unknown = [&RENDER[..], &["none.png", "--show", "norml"]].concat();
    let output = place.hachure(&unknown);
    let (list, line) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.code() == Some(2) && line.lines().count() == 1, "{line}");
    for known in ["--show norml", "normal", "surface id", "height tiles", "smoothed line"] {
        assert!(line.contains(known), "{line}");
    }
    // The list has a sentence about each picture, under headings.
    for known in ["\nSurface:\n", "  Distance along the view axis, in metres; 0 is the sky\n", "\nLines:\n"] {
        assert!(list.contains(known), "{list}");
    }
    assert!(
        list.lines().filter(|line| line.starts_with("  ")).all(|line| line.split_whitespace().count() > 3),
        "{list}"
    );
    assert!(!list.contains("stroke ids"), "the style has no strokes: {list}");
    place.misuse(&[&unknown[..], &["--json"]].concat());
    for wrong in [
        &["o.svg", "--style", "pen"][..],
        &["o.exr", "--style", "lsa", "--aov", "depth"],
        &["o.png", "--style", "lsa", "--size", "9000x9000"],
    ] {
        let render = ["render", "dem.tif", "--camera=-900,-900,+150,40,-12,60", "-o"];
        let line = place.misuse(&[&render[..], wrong, &["--show", "depth"]].concat());
        assert!(line.contains("--show"), "{line}");
    }
    assert!(!place.names().iter().any(|name| name == "none.png" || name.starts_with("o.")));
}
