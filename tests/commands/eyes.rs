//! `render --eyes`: stereo pairs in files.

use exr::prelude::{AttributeValue, MetaData, Text};
use glam::DVec3;
use hachure::file::exr::read_exr;
use hachure::file::png::read_rgba8;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::dem::dem;
use crate::{Place, full};

const SIZE: [usize; 2] = [96, 54];
const RENDER: [&str; 5] = ["render", "dem.tif", "--camera=-900,-900,+150,40,-12,60", "--size", "96x54"];

/// Returns the style of pictures whose style does not matter; the cheaper one has the same colours of paper and ink.
fn any_style() -> &'static str {
    if full() { "ink" } else { "lsa" }
}

fn has_no_gpu() -> bool {
    let none = std::env::var_os("HACHURE_REQUIRE_GPU").is_none() && Gpu::open(&AdapterWish::Best).is_err();
    if none {
        println!("skipped: no GPU");
    }
    none
}

/// Draws into `file` and returns its RGBA bytes, row by row.
fn drawn(place: &Place, file: &str, more: &[&str]) -> Vec<u8> {
    place.text(&[&RENDER[..], &["-o", file], more].concat());
    let picture = read_rgba8(&place.path(file)).unwrap();
    let eyes = if more.contains(&"side-by-side") { 2 } else { 1 };
    assert_eq!([picture.width as usize, picture.height as usize], [SIZE[0] * eyes, SIZE[1]]);
    picture.rgba
}

#[test]
fn a_pair_is_its_eyes_and_eyes_at_one_place_are_mono() {
    if has_no_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place);
    for &style in if full() { &["ink", "strokes"][..] } else { &["strokes"] } {
        let of =
            |eyes: &str, more: &[&str]| drawn(&place, "out.png", &[&["--style", style, "--eyes", eyes], more].concat());
        let wide = ["--ipd", "40", "--convergence", "900"];
        let both = of("side-by-side", &wide);
        let half = |number: usize| -> Vec<u8> {
            both.chunks_exact(8 * SIZE[0])
                .flat_map(|row| &row[4 * SIZE[0] * number..][..4 * SIZE[0]])
                .copied()
                .collect()
        };
        let [left, right] = [of("left", &wide), of("right", &wide)];
        assert!(left == half(0) && right == half(1), "{style}: the halves of the pair differ from single eyes");
        assert!(left != half(1), "{style}: planted error, eyes exchanged");
        let mono = drawn(&place, "out.png", &["--style", style]);
        assert!(left != mono && right != mono, "{style}: an eye of a wide pair equals mono");
        let none = ["--ipd", "0"];
        assert!(
            of("left", &none) == mono && (!full() || of("right", &none) == mono),
            "{style}: eyes with a distance of 0 differ from mono"
        );
    }
}

#[test]
fn a_grey_anaglyph_is_grey_and_eyes_may_follow_the_land() {
    if has_no_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place);
    let of = |eyes: &str| drawn(&place, "out.png", &["--style", any_style(), "--eyes", eyes, "--ipd", "40"]);
    let [grey, coloured, left] = ["grey-anaglyph", "anaglyph", "left"].map(of);
    // Red is the left eye's luma; green and blue are both the right eye's.
    let is_grey = |picture: &[u8]| picture.chunks_exact(4).all(|texel| texel[1] == texel[2]);
    assert!(is_grey(&grey) && !is_grey(&coloured));
    let near = |a: u8, b: u8| a.abs_diff(b) < 16;
    assert!(grey.chunks_exact(4).zip(left.chunks_exact(4)).all(|(grey, left)| near(grey[0], left[1])));
    assert!(
        !grey.chunks_exact(4).zip(left.chunks_exact(4)).all(|(grey, left)| near(grey[1], left[1])),
        "planted error, the left eye in green"
    );
    let ipd_m = |more: &[&str]| {
        let report = place.json(&[&RENDER[..], &["-o", "out.png", "--json", "--style", any_style()], more].concat());
        report["ipd_m"].as_f64()
    };
    // 150 m above the ground, looking 12 degrees down with a field of view of 60 degrees, the nearest land is about 200
    // m away.
    let auto_m = ipd_m(&["--eyes", "left", "--ipd", "auto"]).unwrap();
    assert!((4.0..10.0).contains(&auto_m), "--ipd auto gave {auto_m} m, expected 4 m to 10 m");
    assert_eq!((ipd_m(&["--eyes", "left"]), ipd_m(&[])), (Some(0.065), None));
}

/// Returns the name that OpenEXR gives to a channel of one eye: the left eye is the default view.
fn of_eye(eye: &str, channel: &str) -> String {
    match (channel.split_once('.'), eye) {
        (Some((layer, channel)), _) => format!("{layer}.{eye}.{channel}"),
        (None, "left") => channel.to_owned(),
        (None, _) => format!("{eye}.{channel}"),
    }
}

#[test]
fn the_views_of_a_pair_are_its_eyes() {
    if has_no_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place);
    let of = |file: &str, eyes: &str| {
        let more = ["-o", file, "--style", any_style(), "--aov", "depth,position", "--eyes", eyes, "--ipd", "40"];
        place.text(&[&RENDER[..], &more].concat());
        read_exr(&place.path(file)).unwrap()
    };
    let both = of("both.exr", "side-by-side");
    assert_eq!([both.width as usize, both.height as usize], SIZE);
    for eyes in ["left", "right"] {
        let one = of("one.exr", eyes);
        for channel in ["R", "G", "B", "A", "depth.V", "position.X", "position.Z"] {
            let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let layer = both.f32(&of_eye(eyes, channel)).unwrap();
            assert_eq!(bits(layer), bits(one.f32(channel).unwrap()), "{eyes} {channel}");
        }
    }
    let names: Vec<&str> = both.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert!(names.contains(&"R") && names.contains(&"right.R") && names.contains(&"depth.right.V"), "{names:?}");
    // Positions are relative to the camera, which is 20 m from each eye; the rays are those of yaw 40, pitch -12, 60
    // degrees.
    let (yaw, pitch) = (40_f64.to_radians(), -12_f64.to_radians());
    let forward = DVec3::new(yaw.sin() * pitch.cos(), yaw.cos() * pitch.cos(), pitch.sin());
    let right = DVec3::new(yaw.cos(), -yaw.sin(), 0.0);
    let up = right.cross(forward);
    let farthest_off_m = |eye: &str, aside_m: f64| {
        let channel = |name: &str| both.f32(&of_eye(eye, name)).unwrap();
        let (depth, [x, y, z]) = (channel("depth.V"), ["position.X", "position.Y", "position.Z"].map(channel));
        let focal_px = 0.5 * SIZE[1] as f64 / 30_f64.to_radians().tan();
        let off_m = (0..depth.len()).filter(|i| depth[*i].is_finite()).map(|i| {
            let px = [i % SIZE[0], i / SIZE[0]].map(|at| at as f64 + 0.5);
            let across = [px[0] - 0.5 * SIZE[0] as f64, 0.5 * SIZE[1] as f64 - px[1]].map(|px| px / focal_px);
            let ray = forward + right * across[0] + up * across[1];
            let expected = right * aside_m + ray * f64::from(depth[i]);
            expected.distance(DVec3::new(x[i].into(), y[i].into(), z[i].into()))
        });
        off_m.fold(0.0, f64::max)
    };
    for (eye, aside_m) in [("left", -20.0), ("right", 20.0)] {
        assert!(farthest_off_m(eye, aside_m) < 0.05, "{eye}: {} m", farthest_off_m(eye, aside_m));
        // Planted error: eyes exchanged.
        assert!(farthest_off_m(eye, -aside_m) > 39.0);
    }
}

#[test]
fn an_exr_of_a_pair_has_the_camera_of_each_view() {
    if has_no_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place);
    let more = ["-o", "a.exr", "--aov", "position", "--aov-names", "standard", "--ipd", "40", "--convergence", "700"];
    let read = |eyes: &str| {
        place.text(&[&RENDER[..], &more, &["--style", any_style(), "--eyes", eyes]].concat());
        let found = MetaData::read_from_file(place.path("a.exr"), false).unwrap();
        (read_exr(&place.path("a.exr")).unwrap(), found.headers[0].own_attributes.clone())
    };
    let (both, own) = read("side-by-side");
    let views: Vec<String> = own.multi_view_names.iter().flatten().map(ToString::to_string).collect();
    assert_eq!(views, ["left", "right"]);
    let second = |name: &str| match own.other.get(&Text::from(name)) {
        Some(AttributeValue::Matrix4x4(matrix)) => *matrix,
        other => panic!("{name}: {other:?}"),
    };
    let ndc = [own.world_to_normalized_device.unwrap(), second("right.worldToNDC")];
    // The largest distance of a pixel from where the matrix projects its position in the world.
    let farthest_px = |eye: &str, matrix: [f32; 16]| {
        let [x, y, z] = ["P.X", "P.Y", "P.Z"].map(|name| both.f32(&of_eye(eye, name)).unwrap());
        let off_px = (0..x.len()).filter(|i| [x[*i], y[*i], z[*i]] != [0.0; 3]).map(|i| {
            let at = [x[i], y[i], z[i], 1.0].map(f64::from);
            let [x, y, _, w]: [f64; 4] =
                std::array::from_fn(|to| (0..4).map(|k| at[k] * f64::from(matrix[4 * k + to])).sum());
            let px = [0.5 * (1.0 + x / w) * SIZE[0] as f64, 0.5 * (1.0 - y / w) * SIZE[1] as f64];
            let pixel = [i % SIZE[0], i / SIZE[0]].map(|at| at as f64 + 0.5);
            (px[0] - pixel[0]).hypot(px[1] - pixel[1])
        });
        off_px.fold(0.0, f64::max)
    };
    for (eye, [own, other]) in [("left", [ndc[0], ndc[1]]), ("right", [ndc[1], ndc[0]])] {
        assert!(farthest_px(eye, own) < 0.05, "{eye}: {} px", farthest_px(eye, own));
        assert!(farthest_px(eye, other) > 1.0, "planted error, eyes exchanged");
    }
    // To camera space, the right eye is 40 m to the right of the left one.
    let [left, right] = [own.world_to_camera.unwrap(), second("right.worldToCamera")];
    assert!((left[12] - right[12] - 40.0).abs() < 0.01, "{left:?} {right:?}");
    // A single eye of the pair has its own camera, and an anaglyph has none.
    let (_, of_right) = read("right");
    assert_eq!((of_right.world_to_camera, of_right.multi_view_names), (Some(right), None));
    let place_anaglyph = [&RENDER[..], &["-o", "a.exr", "--eyes", "anaglyph"]].concat();
    place.text(&place_anaglyph);
    let found = MetaData::read_from_file(place.path("a.exr"), false).unwrap();
    assert_eq!(found.headers[0].own_attributes.world_to_camera, None);
}

#[test]
fn a_drawing_of_two_eyes_has_two_inks() {
    if has_no_gpu() {
        return;
    }
    let place = Place::empty();
    dem(&place);
    let of = |eyes: &str| {
        place.text(&[&RENDER[..], &["-o", "a.svg", "--style", "pen", "--ipd", "40", "--eyes", eyes]].concat());
        std::fs::read_to_string(place.path("a.svg")).unwrap()
    };
    // The paths of each layer, without the layer's own attributes.
    let paths = |text: &str| -> Vec<Vec<String>> {
        let layers = text.split("<g id=").skip(1);
        layers
            .map(|layer| layer.lines().filter(|line| line.starts_with("<path")).map(str::to_owned).collect())
            .collect()
    };
    let both = of("anaglyph");
    assert!(both.contains("id=\"left-eye\"") && both.contains("stroke=\"#00ffff\""));
    assert!(both.contains("id=\"right-eye\"") && both.contains("stroke=\"#ff0000\""));
    let inks = paths(&both);
    let [left, right] = ["left", "right"].map(|eye| paths(&of(eye)).concat());
    assert!(!left.is_empty() && inks == [left.clone(), right.clone()]);
    assert!(left != right, "planted error, eyes exchanged");
}

#[test]
fn what_has_no_room_for_two_eyes_is_reported() {
    let place = Place::empty();
    dem(&place);
    for (more, words) in [
        (&["-o", "a.png", "--ipd", "0.1"][..], "--ipd: needs a stereo pair"),
        (&["-o", "a.png", "--convergence", "5"], "--convergence: needs a stereo pair"),
        (&["-o", "a.svg", "--style", "strokes", "--eyes", "side-by-side"], "an .svg shows one eye"),
        (&["-o", "a.png", "--show", "tone", "--eyes", "left"], "--show requires --eyes mono"),
        (&["-o", "a.exr", "--aov", "depth", "--eyes", "anaglyph"], "an anaglyph merges both eyes into one picture"),
        (&["-o", "a.png", "--eyes", "both"], "side-by-side"),
        (&["-o", "a.png", "--eyes", "left", "--convergence", "0"], "--convergence"),
        (&["-o", "a.png", "--eyes", "left", "--ipd", "near"], "or auto"),
    ] {
        let error = place.misuse(&[&RENDER[..], more].concat());
        assert!(error.contains(words), "{error}");
        assert!(!place.path("a.png").exists());
    }
}
