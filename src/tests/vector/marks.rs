//! Tests hatching marks as paths: their ink equals the picture's, in layers and with pens.

use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::polylines::Polyline;
use hachure::picture::PictureRequest;
use hachure::picture::strokes::render_strokes;
use hachure::style::Style;
use hachure::style::layers::CUT_INK;
use hachure::surface::rows::ribbons::ROW_INK;
use hachure::tones::balance::MARKS;
use hachure::vector::pens::Pens;
use hachure::vector::sheet::Sheet;
use hachure::vector::{Group, GroupKind, Settings, layers};

use crate::tests::common::draw::{draw, north_west, still};
use crate::tests::common::{World, absolute, full};
use crate::tests::vector::svg::{Read, rasterised_at, read, written_layers};

const SIZE_PX: [u32; 2] = [256, 192];
const WINDOW_PX: usize = 64;
const CAMERA: &str = "-12000,9000,+900,120,-12,50";
const STYLES: [&str; 4] = ["crosshatch", "engraving", "stipple", "hachures"];

/// Returns the ink of a picture's marks.
fn ink_of(world: &mut World, style: &Style) -> Vec<f32> {
    let view = still(world.pose(CAMERA), SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &north_west());
    let marks: Option<Vec<f32>> = renderer.target(&MARKS).map(|ink| read_as(&world.gpu, ink, [0, 0], SIZE_PX).unwrap());
    let rows: Option<Vec<u16>> =
        renderer.target(&ROW_INK).map(|ink| read_as(&world.gpu, ink, [0, 0], SIZE_PX).unwrap());
    let rows = rows.map(|rows| rows.into_iter().map(|bits| half::f16::from_bits(bits).to_f32()).collect());
    // Families of cut lines cross each other.
    let crossed = |texel: [u16; 4]| {
        let light = texel[..3].iter().map(|bits| 1.0 - half::f16::from_bits(*bits).to_f32()).product::<f32>();
        1.0 - light
    };
    let cuts = renderer.target(&CUT_INK).map(|ink| read_as(&world.gpu, ink, [0, 0], SIZE_PX).unwrap());
    let cuts = cuts.map(|texels| texels.into_iter().map(crossed).collect());
    marks.or(rows).or(cuts).unwrap()
}

fn groups_of(world: &mut World, style: &Style) -> Vec<Group> {
    let request = PictureRequest::still(world.pose(CAMERA), SIZE_PX, style, north_west());
    let drawn = render_strokes(&world.gpu, &mut None, &mut world.surfaces, &request, None).unwrap();
    assert!(drawn.strokes.iter().flatten().count() > 5);
    drawn.marks
}

/// Returns the differences of mean ink in windows.
fn windows(ink: &[f32], other: &[f32]) -> Vec<f64> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let corners =
        (0..height / WINDOW_PX).flat_map(|y| (0..width / WINDOW_PX).map(move |x| (x * WINDOW_PX, y * WINDOW_PX)));
    let mean = |ink: &[f32], (x, y): (usize, usize)| {
        let rows = (y..y + WINDOW_PX).flat_map(|row| &ink[row * width + x..row * width + x + WINDOW_PX]);
        rows.map(|ink| f64::from(*ink)).sum::<f64>() / (WINDOW_PX * WINDOW_PX) as f64
    };
    corners.map(|corner| mean(ink, corner) - mean(other, corner)).collect()
}

fn settings() -> Settings {
    Settings { tolerance_px: 0.25, sheet: Sheet::pixels(SIZE_PX), ink: "#14120f".parse().unwrap() }
}

fn paths_of(groups: &[Group], pens: Option<&Pens>) -> Vec<Read> {
    let (layers, _) = layers(groups, &settings(), pens);
    read(&written_layers(layers, &settings()))
}

fn worst(windows: &[f64]) -> f64 {
    windows.iter().map(|window| window.abs()).fold(0.0, f64::max)
}

#[test]
fn paths_of_marks_have_the_ink_of_the_picture() {
    let Some(mut world) = World::real("dem/geotiff/mt_rainier_90m.tif", 1.0) else { return };
    for name in STYLES.into_iter().take(if full() { 4 } else { 1 }) {
        let mut style = absolute(name);
        // Lines of the sky are not marks of the land.
        (style.sky.rules_px, style.sky.clouds) = (0.0, 0.0);
        // Ink that does not fade, so that the ink target equals what is drawn.
        style.hatching_mut().into_iter().for_each(|hatching| hatching.faintest = 1.0);
        style.rows_mut().into_iter().for_each(|rows| rows.faintest = 1.0);
        style.lowest_cuts_mut().into_iter().for_each(|cuts| cuts.faintest = 1.0);
        let ink = ink_of(&mut world, &style);
        let groups = groups_of(&mut world, &style);
        assert!(groups.iter().all(|group| matches!(group.kind, GroupKind::Ink(_)) && !group.lines.is_empty()));
        let of_paths = |paths: &[Read]| windows(&rasterised_at(paths, SIZE_PX), &ink);
        let mut paths = paths_of(&groups, None);
        let again = of_paths(&paths);
        let by_pen = Pens::chosen(2, groups.iter().flat_map(|group| &group.lines));
        let by_pens = of_paths(&paths_of(&groups, Some(&by_pen)));
        let mean = |windows: &[f64]| windows.iter().map(|window| window.abs()).sum::<f64>() / windows.len() as f64;
        println!(
            "{name}: {} lines; windows differ by {:.3}, at most {:.3}; with pens of {:.2?} px by {:.3}, {:.3}",
            groups.iter().map(|group| group.lines.len()).sum::<usize>(),
            mean(&again),
            worst(&again),
            by_pen.widths_px,
            mean(&by_pens),
            worst(&by_pens)
        );
        assert!(worst(&again) < 0.03 && worst(&by_pens) < 0.06, "{name}");
        // Planted: wider paths, then the longest third of the lines missing.
        paths.iter_mut().for_each(|path| path.width *= 1.4);
        assert!(worst(&of_paths(&paths)) > 0.03, "{name}");
        let mut fewer = groups.clone();
        for group in &mut fewer {
            group.lines.sort_by_key(|line: &Polyline| line.points.len());
            group.lines.truncate(group.lines.len() * 2 / 3);
        }
        assert!(worst(&of_paths(&paths_of(&fewer, None))) > 0.03, "{name}");
    }
}
