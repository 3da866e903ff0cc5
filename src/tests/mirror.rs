//! Tests that still water mirrors the tone of the land behind it, as colour and as strokes, where reflection about its
//! level predicts.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{draw, floats, halves, north_west, still};
use common::{World, full, grid_of};
use glam::DVec3;
use hachure::frame::{Light, Renderer};
use hachure::style::Style;
use hachure::surface::water::WATER;
use hachure::tones::water::{WATER_INK, WATERED};

const SIZE_PX: [u32; 2] = [320, 200];
const CAMERA: &str = "0,-1500,560,0,-5,30";
const LEVEL_M: f64 = 500.0;
const CREST_M: f64 = 300.0;
const SHORE_Y_M: f64 = 500.0;
const SLOPE: f64 = 1.2;

/// Height of a lake with a cliff of 50 degrees behind it, and level land above the cliff.
fn cliff_m(x_m: f64, y_m: f64) -> f64 {
    let cliff_m = (SLOPE * (y_m - SHORE_Y_M)).clamp(0.0, CREST_M);
    let banks_m = 0.15 * (x_m.abs() - 1500.0).max(-2000.0 - y_m).max(0.0);
    LEVEL_M + cliff_m.max(banks_m)
}

/// Returns a style in which steep land is black, and level land white.
fn style(water: &str) -> Style {
    let text = format!(
        "name = \"mirror\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\n[light]\nslope = 1.0\n\
         [water]\n{water}"
    );
    Style::parse("mirror", &text).unwrap()
}

/// A picture of the lake: for each pixel of water its lightness and its ink.
struct Drawn {
    water: Vec<Option<[f64; 2]>>,
    /// Returns the row of the picture in which a point at this height above the crest's position is.
    row_of: Box<dyn Fn(f64) -> f64>,
}

fn drawn(water: &str) -> Option<Drawn> {
    // The fast tier has land of one tile, and draws it once.
    let (samples, draws) = if full() { (257, 2) } else { (255, 1) };
    let mut world = World::new(grid_of(samples, samples, 20.0, cliff_m), 1.0)?;
    let style = style(water);
    let pose = world.pose(CAMERA);
    let view = still(pose, SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let light = Light { haze_m: 1e9, ..north_west() };
    for _ in 0..draws {
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &light);
    }
    let away = floats::<1>(&world.gpu, renderer.target(&WATER).unwrap());
    let tone = halves(&world.gpu, renderer.target(&WATERED).unwrap());
    let ink = floats::<1>(&world.gpu, renderer.target(&WATER_INK).unwrap());
    let of = |((away, tone), ink): (([f32; 1], [f64; 4]), [f32; 1])| (away[0] > 0.0).then(|| [tone[0], ink[0].into()]);
    let water = away.into_iter().zip(tone).zip(ink).map(of).collect();
    let focal_px = view.focal_px();
    let row_of = move |z_m: f64| {
        let to_m = DVec3::new(0.0, SHORE_Y_M + CREST_M / SLOPE, z_m) - pose.position_m;
        0.5 * f64::from(SIZE_PX[1]) - focal_px * to_m.dot(pose.up) / to_m.dot(pose.forward)
    };
    Some(Drawn { water, row_of: Box::new(row_of) })
}

/// Columns in the middle of the picture.
fn columns() -> std::ops::Range<usize> {
    60..260
}

/// Returns the share of columns whose mirrored crest is within 2.5 pixels of the reflection about `level_m`.
fn share_right(drawn: &Drawn, level_m: f64) -> f64 {
    let wanted = (drawn.row_of)(2.0 * level_m - (LEVEL_M + CREST_M));
    let last_dark = |column: usize| {
        let rows = (0..SIZE_PX[1] as usize)
            .filter(|row| drawn.water[row * SIZE_PX[0] as usize + column].is_some_and(|[light, _]| light < 0.65));
        rows.max().map(|row| row as f64 + 0.5)
    };
    let right = columns().filter(|column| last_dark(*column).is_some_and(|row| (row - wanted).abs() < 2.5));
    right.count() as f64 / columns().len() as f64
}

/// Returns the means of a channel over water that mirrors the cliff, and over water that mirrors the sky.
fn means(drawn: &Drawn, channel: usize) -> [f64; 2] {
    let crest = (drawn.row_of)(LEVEL_M - CREST_M);
    let mean = |rows: std::ops::Range<usize>| {
        let all = rows.flat_map(|row| columns().map(move |column| row * SIZE_PX[0] as usize + column));
        let values: Vec<f64> = all.filter_map(|i| drawn.water[i].map(|pixel| pixel[channel])).collect();
        assert!(values.len() > 2000, "{}", values.len());
        values.iter().sum::<f64>() / values.len() as f64
    };
    let crest = crest as usize;
    [mean(0..crest - 4), mean(crest + 4..SIZE_PX[1] as usize)]
}

#[test]
fn a_cliff_is_mirrored_where_geometry_says() {
    let Some(mirror) = drawn("tint = \"#ffffff\"\nmirror = 1.0\n") else { return };
    let right = share_right(&mirror, LEVEL_M);
    let [cliff, sky] = means(&mirror, 0);
    println!(
        "{:.0} % of the columns have the crest where it belongs; {cliff:.2} of light in it, {sky:.2} below",
        100.0 * right
    );
    assert!(right > 0.95 && cliff < 0.35 && sky > 0.95, "{right} {cliff} {sky}");
    // Planted: reflection about a level that is 20 m higher or lower, and water without reflection.
    assert!(share_right(&mirror, LEVEL_M + 20.0) < 0.1 && share_right(&mirror, LEVEL_M - 20.0) < 0.1);
    let plain = drawn("tint = \"#ffffff\"\n").unwrap();
    assert!(share_right(&plain, LEVEL_M) < 0.1);
}

#[test]
fn strokes_are_as_dark_as_what_is_mirrored() {
    let Some(mirror) = drawn("rules = true\nspacing_px = 4\nmirror = 1.0\n") else { return };
    let plain = drawn("rules = true\nspacing_px = 4\n").unwrap();
    let ([cliff, sky], [plain_cliff, plain_sky]) = (means(&mirror, 1), means(&plain, 1));
    println!(
        "ink {cliff:.2} where a cliff is mirrored, {sky:.2} where the sky is; without {plain_cliff:.2}, {plain_sky:.2}"
    );
    assert!(cliff > plain_cliff + 0.2 && (sky - plain_sky).abs() < 0.02);
    // The colours stay the same.
    assert!(means(&mirror, 0) == means(&plain, 0));
}
