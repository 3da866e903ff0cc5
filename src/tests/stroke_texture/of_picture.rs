//! Tests a picture of a stroke as the texture of strokes.

use std::path::Path;

use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::stroke::INK;
use hachure::lines::strokes::texture::{Brush, grow};
use hachure::style::texture::Recipe;
use hachure::style::{Style, preset_text};

use crate::tests::common::World;
use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::hill::Hill;

/// Size of the picture, and the number of rows of paper above and below its stroke.
const SIZE_PX: [u32; 2] = [240, 40];
const PAPER_ROWS: u32 = 8;

/// Returns the bytes of a PNG.
fn encode_rgba8([width, height]: [u32; 2], rgba: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(rgba).unwrap();
    bytes
}

/// Writes a picture of a stroke that is black above, and below has `below` (255 is white); it is interrupted by 40
/// transparent columns.
pub(super) fn write_stroke(path: &Path, below: u8) {
    let [width, height] = SIZE_PX;
    let pixel = |(x, y): (u32, u32)| -> [u8; 4] {
        let is_paper = !(PAPER_ROWS..height - PAPER_ROWS).contains(&y);
        let light = if is_paper {
            255
        } else if y < height / 2 {
            0
        } else {
            below
        };
        [light, light, light, if (100..140).contains(&x) { 0 } else { 255 }]
    };
    let pixels: Vec<u8> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(pixel).collect();
    hachure::file::atomic::write(path, &encode_rgba8(SIZE_PX, &pixels)).unwrap();
}

/// Returns a style whose strokes are 8 px wide and have the texture `scan.png` of a folder.
fn style(folder: &Path) -> Style {
    let mut text: toml_edit::DocumentMut = preset_text("strokes").unwrap().parse().unwrap();
    let layers = text["layers"].as_array_of_tables_mut().unwrap();
    let strokes = layers.iter_mut().find(|layer| layer["kind"].as_str() == Some("strokes")).unwrap();
    strokes["texture"] = toml_edit::value("scan.png");
    strokes["width_px"] = toml_edit::value(8.0);
    for (key, value) in [("faintest", 1.0), ("taper_px", 0.0), ("depth_width", 0.0), ("slender", 0.0)] {
        strokes[key] = toml_edit::value(value);
    }
    let path = folder.join("style.toml");
    hachure::file::atomic::write(&path, text.to_string().as_bytes()).unwrap();
    Style::load(path.to_str().unwrap()).unwrap()
}

#[test]
fn the_stroke_of_a_picture_fills_the_width() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.png");
    write_stroke(&path, 128);
    let style = style(folder.path());
    assert!(style.files.contains(&path), "a changed picture must be noticed");
    let recipe = style.strokes().unwrap().texture.clone().unwrap();
    let brush = Brush::of(&recipe);
    // The stroke of the picture is 24 rows wide, so it is ten times as long: 80 px, of which whole tiles fit into 4096.
    assert!((brush.tile_px[0] - 80.0).abs() < 1.0, "{}", brush.tile_px[0]);
    let ends = [-4.0, 0.0, 4.0].map(|across_px| brush.uv(0.0, across_px, 4.0, 0)[1]);
    assert!(ends[0] < 0.05 && ends[1] == 0.5 && ends[2] > 0.95, "{ends:?}");

    // 1 above, 127/255 below, and a sixth of the length is left out.
    let darkness = 5.0 / 6.0 * 0.5 * (1.0 + 127.0 / 255.0);
    for (level, number) in grow(&recipe).iter().zip(0..) {
        let ink = [1.0, 0.5, 0.25].map(|pressure| level.mean_ink(&brush, pressure));
        println!("level {number}: {ink:?}");
        assert!((ink[0] - darkness).abs() < 0.01, "level {number}: {} is not {darkness}", ink[0]);
        // With less pressure there is less ink, in proportion.
        assert!((ink[1] - 0.5 * darkness).abs() < 0.06 && (ink[2] - 0.25 * darkness).abs() < 0.1, "{ink:?}");
        let rows = |range: std::ops::Range<usize>| {
            let width = level.size_px[0] as usize;
            let texels = &level.texels[range.start * width..range.end * width];
            texels.iter().map(|texel| f64::from(texel[0])).sum::<f64>() / texels.len() as f64
        };
        let half = level.size_px[1] as usize / 2;
        assert!(half == 0 || rows(0..half) > 1.8 * rows(half..2 * half), "the upper half is the darker one");
    }
    // Planted: another darkness of the lower half.
    write_stroke(&path, 0);
    let black = Style::load(folder.path().join("style.toml").to_str().unwrap()).unwrap();
    let black = black.strokes().unwrap().texture.clone().unwrap();
    assert!(black != recipe && (grow(&black)[0].mean_ink(&brush, 1.0) - darkness).abs() > 0.1);
}

#[test]
fn strokes_have_the_ink_of_the_picture() {
    const DRAWN_PX: [u32; 2] = [480, 270];
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut renderer = None;
    let mut ink = |style: &Style| {
        let view = still(world.pose("900,-900,+20,315,3,60"), DRAWN_PX);
        let renderer = Renderer::or_new(&mut renderer, &world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, renderer, &view, style, &NOON);
        let texels: Vec<u16> = read_as(&world.gpu, renderer.target(&INK).unwrap(), [0, 0], DRAWN_PX).unwrap();
        texels.iter().map(|bits| half::f16::from_bits(*bits).to_f64()).sum::<f64>()
    };
    let mut drawn = |below: u8| {
        write_stroke(&folder.path().join("scan.png"), below);
        ink(&style(folder.path()))
    };
    let inks = [128, 0].map(&mut drawn);
    let mut solid = style(folder.path());
    solid.strokes_mut().unwrap().texture = None;
    let solid = ink(&solid);
    let [grey, black] = inks.map(|ink| ink / solid);
    println!("share of the ink of solid strokes: {grey:.3}, all black {black:.3}");
    // A sixth of the length has no ink. Ends of strokes and pixels of their borders have less than the middle.
    assert!((black - 5.0 / 6.0).abs() < 0.08, "{black}");
    assert!((grey / black - 0.749).abs() < 0.04, "{grey} of {black}");
}

#[test]
fn mistakes_in_a_picture_of_a_stroke_are_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let error = |name: &str| Recipe::load(name, folder.path()).unwrap_err().to_string();
    let write = |name: &str, bytes: &[u8]| hachure::file::atomic::write(&folder.path().join(name), bytes).unwrap();
    write("text.png", b"no picture");
    write("small.png", &encode_rgba8([4, 4], &[0; 64]));
    write("white.png", &encode_rgba8([64, 16], &[255; 4 * 64 * 16]));
    let image = |name: &str, size_px: [u32; 2], light: &dyn Fn(u32, u32) -> u8| {
        let pixels = (0..size_px[1]).flat_map(|y| (0..size_px[0]).map(move |x| (x, y)));
        let rgba: Vec<u8> = pixels.flat_map(|(x, y)| [light(x, y), light(x, y), light(x, y), 255]).collect();
        write(name, &encode_rgba8(size_px, &rgba));
    };
    image("inverted.png", [128, 32], &|_, y| if (12..20).contains(&y) { 255 } else { 0 });
    image("upright.png", [32, 128], &|x, _| if (12..20).contains(&x) { 0 } else { 255 });
    for (name, cause) in [
        ("missing.png", "cannot read the picture of a stroke"),
        ("text.png", "cannot read the picture of a stroke"),
        ("small.png", "it is 4 × 4 px; a picture of a stroke must be 8 to 8192 px long and 4 to 2048 px high"),
        ("inverted.png", "its border is darker than its middle"),
        ("upright.png", "the stroke must lie from left to right"),
        ("white.png", "it shows no stroke: draw dark ink on white or transparent paper"),
        ("scan.jpg", "a file name must end with .toml, or .png for a picture of a stroke"),
    ] {
        let error = error(name);
        assert!(error.contains(name) && error.contains(cause) && error.lines().count() == 1, "{error}");
    }
    // A scan: grey paper with noise, and a speck of dust. The stroke is its middle fifth.
    image("scan.png", [200, 50], &|x, y| match (20..30).contains(&y) {
        true => 30,
        false if (x, y) == (7, 3) => 60,
        false => 226 + ((x * 7 + y * 13) % 12) as u8,
    });
    let scan = Recipe::load("scan.png", folder.path()).unwrap().picture.unwrap();
    assert_eq!(scan.length_to_width(), 20.0);
    // A recipe with an image has its own numbers.
    let picture = Path::new("pen.png");
    write_stroke(&folder.path().join(picture), 0);
    let of_picture = include_str!("../../../textures/strokes/of-picture.toml");
    let text = format!("image = \"pen.png\"\n{}", of_picture.replace("softness = 0.15", "softness = 0.4"));
    write("own.toml", text.as_bytes());
    let own = Recipe::load("own.toml", folder.path()).unwrap();
    assert!(own.touch.softness == 0.4 && own.picture == Recipe::load("pen.png", folder.path()).unwrap().picture);
}
