//! A model that is opened by itself: an OBJ file as WORLD.

use hachure::file::png::{Picture, read_rgba8};
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::Place;

/// A house of 6 × 5 × 8 m with a red roof, far from the origin of its file.
const HOUSE: &str = "mtllib house.mtl\nv 100 20 50\nv 106 20 50\nv 106 20 58\nv 100 20 58\nv 100 23 50\nv 106 23 50\n\
    v 106 23 58\nv 100 23 58\nv 103 25 50\nv 103 25 58\nusemtl wall\nf 1 2 3 4\nf 4 3 7 10 8\nf 2 1 5 9 6\nf 3 2 6 7\n\
    f 1 4 8 5\nusemtl roof\nf 8 10 9 5\nf 10 7 6 9\n";
const MATERIALS: &str = "newmtl wall\nKd 0.8 0.8 0.8\nnewmtl roof\nKd 0.7 0.02 0.02\n";
const SIZE: [usize; 2] = [180, 120];

fn has_gpu() -> bool {
    let has = std::env::var_os("HACHURE_REQUIRE_GPU").is_some() || Gpu::open(&AdapterWish::Best).is_ok();
    if !has {
        println!("skipped: no GPU");
    }
    has
}

fn with_house() -> Place {
    let place = Place::empty();
    place.file("house.obj", HOUSE);
    place.file("house.mtl", MATERIALS);
    place
}

fn drawn(place: &Place, name: &str, options: &[&str]) -> Picture {
    let output = format!("{name}.png");
    place.text(&[&["render"][..], options, &["-o", &output, "--size", "180x120"]].concat());
    read_rgba8(&place.path(&output)).unwrap()
}

/// Returns the first and the last column and row, as parts of the picture, of the pixels where two pictures differ
/// clearly, and which part of the pixels these are.
fn difference(a: &Picture, b: &Picture) -> ([[f64; 2]; 2], f64) {
    let pixels = a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4));
    let differ = |(a, b): (&[u8], &[u8])| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > 24);
    let changed: Vec<usize> = pixels.enumerate().filter(|(_, pair)| differ(*pair)).map(|(at, _)| at).collect();
    let [width, height] = SIZE;
    let span = |of: &dyn Fn(usize) -> usize, side: usize| {
        let (first, last) = changed.iter().fold((side, 0), |(first, last), at| (first.min(of(*at)), last.max(of(*at))));
        [first as f64 / side as f64, (last + 1) as f64 / side as f64]
    };
    let spans = [span(&|at| at % width, width), span(&|at| at / width, height)];
    (spans, changed.len() as f64 / (width * height) as f64)
}

#[test]
fn a_model_is_drawn_in_the_middle_of_the_picture_and_drawn_again() {
    if !has_gpu() {
        return;
    }
    let place = with_house();
    let house = drawn(&place, "a", &["house.obj", "--style", "plain"]);
    // The same ground without the house, which is behind the camera.
    let away = |camera: &str| drawn(&place, "away", &["house.obj", "--style", "plain", &format!("--camera={camera}")]);
    let ground = away("0,-60,12,180,-25,35");
    let ([[left, right], [top, bottom]], part) = difference(&house, &ground);
    assert!((0.55..0.75).contains(&(bottom - top)), "the model fills {} of the height", bottom - top);
    assert!((top + bottom - 1.0).abs() < 0.1 && (left + right - 1.0).abs() < 0.1, "{left} {right} {top} {bottom}");
    assert!(part > 0.1, "{part}");
    // Planted error: two pictures of the ground, which is even.
    assert_eq!(difference(&ground, &away("20,-60,12,90,-25,35")).1, 0.0);

    // Its imprint draws it again, bit for bit.
    let [first, again] = ["a.png", "again.png"].map(|name| place.path(name));
    place.text(&["render", "--like", "a.png", "-o", "again.png"]);
    assert_eq!(std::fs::read(&first).unwrap(), std::fs::read(&again).unwrap());
    // Planted error: the model has changed.
    place.file("house.obj", &HOUSE.replace("v 103 25 50", "v 103 26 50"));
    place.text(&["render", "--like", "a.png", "-o", "again.png", "--overwrite"]);
    assert_ne!(std::fs::read(&first).unwrap(), std::fs::read(&again).unwrap());

    // On a map it is seen from above, with some space around it.
    let map = drawn(&place, "map", &["house.obj", "--style", "plain", "--map"]);
    let ([[left, right], [top, bottom]], part) =
        difference(&map, &drawn(&place, "bare", &["house.obj", "--style", "plain", "--map=300,0,12"]));
    assert!(
        (0.6..0.9).contains(&(bottom - top)) && (0.25..0.6).contains(&(right - left)),
        "{left} {right} {top} {bottom}"
    );
    assert!(part > 0.05, "{part}");
}

#[test]
fn a_model_has_the_colours_of_its_materials() {
    if !has_gpu() {
        return;
    }
    let place = with_house();
    let is_red = |pixel: &[u8]| i32::from(pixel[0]) > i32::from(pixel[1].max(pixel[2])) + 20;
    let red = |picture: &Picture| picture.rgba.chunks_exact(4).filter(|pixel| is_red(pixel)).count();
    let coloured = red(&drawn(&place, "coloured", &["house.obj", "--style", "wash"]));
    assert!(coloured > 300, "{coloured} red pixels");
    // Planted error: no materials.
    place.file("house.mtl", "");
    let plain = red(&drawn(&place, "grey", &["house.obj", "--style", "wash"]));
    assert!(plain < 50, "{plain} red pixels");
}

#[test]
fn small_and_large_models_are_drawn_at_another_scale_and_say_so() {
    if !has_gpu() {
        return;
    }
    let place = with_house();
    let scaled = |power: i32, says: Option<&str>| {
        // Decimal exponents, so that the numbers stay exact.
        let line = |line: &str| match line.strip_prefix("v ") {
            Some(numbers) => {
                let numbers = numbers.split(' ').map(|number| format!("{number}e{power}"));
                format!("v {}\n", numbers.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        };
        place.file("scaled.obj", &HOUSE.lines().map(line).collect::<String>());
        let options = ["--size", "180x120", "--style", "plain", "--overwrite"];
        let output = place.hachure(&[&["render", "scaled.obj", "-o", "b.png"][..], &options].concat());
        let printed = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{printed}");
        let found = printed.lines().filter(|line| line.contains("scaled.obj: is ")).count();
        assert_eq!(found, usize::from(says.is_some()), "{power}: {printed}");
        assert!(says.is_none_or(|factor| printed.contains(&format!("drawn at {factor} times its size"))), "{printed}");
        read_rgba8(&place.path("b.png")).unwrap()
    };
    // Whatever its size, it has its place in the picture. The haze is thinner above 8 km.
    let true_size = drawn(&place, "true", &["house.obj", "--style", "plain"]);
    let large = scaled(4, None);
    for (power, picture, like) in [
        (-3, scaled(-3, Some("100")), &true_size),
        (-1, scaled(-1, None), &true_size),
        (5, scaled(5, Some("0.1")), &large),
    ] {
        let (_, part) = difference(like, &picture);
        assert!(part < 0.01, "{power}: {part} of the picture differ");
    }
    // Planted error: another model.
    place.file("house.obj", &HOUSE.replace("v 103 25 50", "v 103 32 50"));
    let (_, part) = difference(&true_size, &drawn(&place, "other", &["house.obj", "--style", "plain"]));
    assert!(part > 0.02, "{part}");
}

#[test]
fn a_broken_model_is_one_line_with_its_cause() {
    let place = with_house();
    for (text, cause) in [
        ("", "it has no faces"),
        ("v 0 0 0\n", "it has no faces"),
        ("v 0 0 0\nv 1 0 x\n", "line 2: \"x\" is not a number"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n", "line 3: the vertex is not finite"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: the face uses vertex 4, but there are 3"),
    ] {
        place.file("broken.obj", text);
        for command in
            [&["render", "broken.obj", "-o", "a.png"][..], &["bench", "broken.obj", "--path", "p.csv", "-o", "b"]]
        {
            place.file("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+10,0,0,50\n1,0,5,+10,0,0,50\n");
            let error = place.error(command);
            assert!(error.contains("broken.obj: ") && error.ends_with(cause), "{text:?}: {error}");
        }
    }
    let error = place.error(&["render", "gone.obj", "-o", "a.png"]);
    assert!(error.contains("gone.obj: there is no such file"), "{error}");
    // No output replaces the model or its materials.
    for input in ["house.obj", "house.mtl"] {
        std::fs::rename(place.path(input), place.path("kept")).unwrap();
        std::fs::copy(place.path("kept"), place.path(input)).unwrap();
        let link = place.path("out.png");
        std::fs::hard_link(place.path(input), &link).unwrap();
        let error = place.error(&["render", "house.obj", "-o", "out.png", "--overwrite"]);
        assert!(error.contains("is the input"), "{error}");
        std::fs::remove_file(&link).unwrap();
    }
    // Nothing is drawn for a model whose land would have another seed.
    let error = place.misuse(&["render", "house.obj", "-o", "a.png", "--seed", "2"]);
    assert!(error.contains("its land has no seed"), "{error}");
}
