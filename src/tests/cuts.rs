//! Cut lines: they follow the cuts of planes through the land, at even distances, have the requested tone, and stick to
//! the land.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, still};
use common::{World, grid_of, quantile};
use glam::{DVec2, DVec3};
use hachure::frame::{Light, Renderer};
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::polylines::Polyline;
use hachure::style::Style;
use hachure::style::layers::CUT_INK;
use hachure::vector::trace::{InkPicture, lines};

const SIZE_PX: [u32; 2] = [480, 270];
const SPACING_PX: f64 = 6.0;
/// A view as a map, with a pixel of 31 m.
const HEIGHT_M: f64 = 11_000.0;
const MAP: &str = "0,0,11000,0,-90,45";
const WINDOW_PX: usize = 64;

/// Returns the height of smooth land with slopes of 3 to 17 degrees, which its form shows too.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    1000.0 + 0.16 * x_m + 0.09 * y_m + 250.0 * (x_m / 3900.0).sin() + 220.0 * (y_m / 3500.0 + x_m / 6000.0).cos()
}

/// A family of planes: their tilt and the azimuth of the tilt, in degrees; the darkness from which it is drawn.
type Family = (f64, f64, f64);

/// Returns a style of cut lines with an even tone.
fn style(families: &[Family], darkness: f64) -> Style {
    let tone = 1.0 - darkness;
    let layers: String = families
        .iter()
        .map(|(tilt, azimuth, from)| {
            format!("[[cuts.layers]]\nspacing_px = {SPACING_PX}\ntilt_deg = {tilt}\nazimuth_deg = {azimuth}\nfrom = {from}\nlevel_deg = 0.5\n")
        })
        .collect();
    let text = format!(
        "name = \"cuts\"\ndescription = \"\"\n[cuts]\n{layers}[tone]\nkind = \"toon\"\nsteps = 0\n\
         darkest = {tone}\nlightest = {tone}\n"
    );
    Style::parse("cuts", &text).unwrap()
}

/// Returns the ink of three families on a map.
fn inks(world: &mut World, style: &Style, camera: &str) -> [Vec<f32>; 3] {
    let view = still(world.pose(camera), SIZE_PX);
    let light = Light { to_sun: DVec3::Z, haze_m: 1e9, haze_srgb: None, focus: None };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &light);
    let texels: Vec<[u16; 4]> = read_as(&world.gpu, renderer.target(&CUT_INK).unwrap(), [0, 0], SIZE_PX).unwrap();
    [0, 1, 2].map(|family| texels.iter().map(|texel| half::f16::from_bits(texel[family]).to_f32()).collect())
}

fn world(height_m: fn(f64, f64) -> f64) -> Option<World> {
    World::new(grid_of(513, 513, 60.0, height_m), 1.0)
}

fn picture(ink: &[f32]) -> InkPicture {
    InkPicture { size_px: SIZE_PX, ink: ink.to_vec() }
}

/// Returns east and north of a pixel of the map seen from `eye_m`, by fixed-point iteration on the land's height.
fn place_m(px: [f32; 2], eye_m: DVec3) -> DVec2 {
    let focal_px = f64::from(SIZE_PX[1]) * 0.5 / (22.5_f64).to_radians().tan();
    let ray = DVec2::new(f64::from(px[0]) - 240.0, 135.0 - f64::from(px[1])) / focal_px;
    let mut place = eye_m.truncate();
    for _ in 0..12 {
        place = eye_m.truncate() + ray * (eye_m.z - height_m(place.x, place.y));
    }
    place
}

fn gradient(at: DVec2) -> DVec2 {
    let d = 0.5;
    let east = height_m(at.x + d, at.y) - height_m(at.x - d, at.y);
    let north = height_m(at.x, at.y + d) - height_m(at.x, at.y - d);
    DVec2::new(east, north) / (2.0 * d)
}

/// Returns the gradient, east and north, of the height above a family's planes.
fn rise(family: Family, at: DVec2) -> DVec2 {
    let (sin_tilt, cos_tilt) = family.0.to_radians().sin_cos();
    let to = DVec2::new(family.1.to_radians().sin(), family.1.to_radians().cos());
    gradient(at) * cos_tilt - to * sin_tilt
}

fn is_inside(px: [f32; 2]) -> bool {
    px[0] > 12.0 && px[1] > 12.0 && px[0] < SIZE_PX[0] as f32 - 12.0 && px[1] < SIZE_PX[1] as f32 - 12.0
}

/// Returns the angles between lines, turned by `turn_rad`, and the cuts of planes through the land: median and 90th
/// percentile, in degrees.
fn strayed_deg(lines: &[Polyline], family: Family, turn_rad: f64) -> [f64; 2] {
    let mut angles: Vec<f64> = Vec::new();
    for line in lines {
        // Measured over several pixels, because paths are traced from pixels.
        for pair in line.points.windows(9).filter(|points| points.iter().all(|point| is_inside(point.px))) {
            let eye_m = DVec3::Z * HEIGHT_M;
            let (a, b) = (place_m(pair[0].px, eye_m), place_m(pair[8].px, eye_m));
            let way = DVec2::from_angle(turn_rad).rotate(b - a);
            let angle = way.angle_to(rise(family, (a + b) * 0.5).perp()).to_degrees().abs();
            angles.push(angle.min(180.0 - angle));
        }
    }
    assert!(angles.len() > 500, "{}", angles.len());
    [quantile(&mut angles, 0.5), quantile(&mut angles, 0.9)]
}

const FAMILIES: [Family; 3] = [(0.0, 0.0, 0.0), (60.0, 30.0, 0.0), (90.0, 135.0, 0.0)];

#[test]
fn lines_lie_where_planes_cut_the_land() {
    let Some(mut world) = world(height_m) else { return };
    for family in FAMILIES {
        let [ink, ..] = inks(&mut world, &style(&[family], 0.4), MAP);
        let lines = lines(&picture(&ink));
        let [median, most] = strayed_deg(&lines, family, 0.0);
        println!("{family:?}: {} lines, median error {median:.2} degrees, 90 % less than {most:.2}", lines.len());
        assert!(
            median < 1.0 && most < 4.0,
            "{family:?}: angles to the cuts, median {median}, 90th percentile {most} degrees"
        );
        // Planted error: lines that are turned.
        assert!(strayed_deg(&lines, family, 0.06)[0] > 1.0, "{family:?}: turned lines pass");
    }
}

/// Returns the gaps from points of a line to the next line, in pixels, for lines that have reached their full width.
fn gaps_px(lines: &[Polyline], darkness: f64) -> Vec<f64> {
    let grown = |half_width_px: f32| f64::from(2.0 * half_width_px) > 0.5 * darkness * SPACING_PX;
    let points = |line: &Polyline| -> Vec<(DVec2, bool)> {
        line.points.iter().map(|point| (DVec2::from(point.px.map(f64::from)), grown(point.half_width_px))).collect()
    };
    let all: Vec<Vec<(DVec2, bool)>> = lines.iter().map(points).collect();
    let mut gaps = Vec::new();
    for (number, line) in all.iter().enumerate() {
        for index in (4..line.len().saturating_sub(4)).step_by(8) {
            let (at, is_grown) = line[index];
            let along = (line[index + 4].0 - line[index - 4].0).normalize_or_zero();
            if !is_grown || !is_inside([at.x as f32, at.y as f32]) || along == DVec2::ZERO {
                continue;
            }
            let mut nearest = f64::INFINITY;
            for (other, others) in all.iter().enumerate() {
                for (step, pair) in others.windows(2).enumerate() {
                    if (other == number && step.abs_diff(index) < 24) || !pair[0].1 {
                        continue;
                    }
                    let (a, b) = ((pair[0].0 - at).dot(along), (pair[1].0 - at).dot(along));
                    if (a > 0.0) != (b > 0.0) {
                        let place = pair[0].0 + (pair[1].0 - pair[0].0) * (a / (a - b)) - at;
                        let gap = place.dot(along.perp());
                        nearest = if gap > 0.0 { nearest.min(gap) } else { nearest };
                    }
                }
            }
            gaps.extend((nearest < 3.0 * SPACING_PX).then_some(nearest));
        }
    }
    gaps
}

#[test]
fn lines_stand_at_even_distances() {
    let Some(mut world) = world(height_m) else { return };
    let spread = |gaps: &[f64]| {
        let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
        (mean, (gaps.iter().map(|gap| (gap - mean).powi(2)).sum::<f64>() / gaps.len() as f64).sqrt() / mean)
    };
    for family in FAMILIES.into_iter().skip(if common::full() { 0 } else { 2 }) {
        let [ink, ..] = inks(&mut world, &style(&[family], 0.3), MAP);
        let traced = lines(&picture(&ink));
        let gaps = gaps_px(&traced, 0.3);
        let (mean, varies) = spread(&gaps);
        println!("{family:?}: {} gaps, mean {mean:.2} px, coefficient of variation {varies:.3}", gaps.len());
        // The aim is 0.25. Vertical planes change from one power of two to the next everywhere on this map.
        assert!(
            varies < 0.28 && (0.75..1.35).contains(&(mean / SPACING_PX)),
            "{family:?}: gaps of {mean} px with coefficient of variation {varies}"
        );
        // Planted error: every fifth line is missing.
        let kept = traced.iter().enumerate().filter(|(number, _)| number % 5 > 0);
        let fewer: Vec<Polyline> = kept.map(|(_, line)| line.clone()).collect();
        assert!(spread(&gaps_px(&fewer, 0.3)).1 > 1.1 * varies, "{family:?}: missing lines are not found");
    }
}

/// Returns the largest difference from the requested darkness over windows of the picture.
fn worst(inks: &[Vec<f32>; 3], asked: f64) -> f64 {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let ink = |at: usize| 1.0 - inks.iter().map(|ink| 1.0 - f64::from(ink[at])).product::<f64>();
    let mut worst = 0.0_f64;
    for (x, y) in
        (0..height - WINDOW_PX).step_by(32).flat_map(|y| (0..width - WINDOW_PX).step_by(32).map(move |x| (x, y)))
    {
        let sum: f64 =
            (y..y + WINDOW_PX).flat_map(|row| (x..x + WINDOW_PX).map(move |at| row * width + at)).map(ink).sum();
        worst = worst.max((sum / (WINDOW_PX * WINDOW_PX) as f64 - asked).abs());
    }
    worst
}

#[test]
fn lines_are_as_dark_as_they_should_be() {
    let Some(mut world) = world(height_m) else { return };
    let crossed: &[Family] = &[(0.0, 0.0, 0.0), (70.0, 45.0, 0.3)];
    let (most, tones): (usize, &[f64]) = if common::full() { (3, &[0.15, 0.3, 0.5, 0.7]) } else { (2, &[0.5]) };
    for families in [crossed, &FAMILIES[..1], &FAMILIES[2..]].into_iter().take(most) {
        for &asked in tones {
            let missed = worst(&inks(&mut world, &style(families, asked), MAP), asked);
            println!("{families:?}, {asked}: largest difference of a window {missed:.4}");
            assert!(missed < 0.03, "{families:?}: a window differs from the darkness {asked} by {missed}");
        }
    }
    // Planted error: another tone.
    assert!(worst(&inks(&mut world, &style(crossed, 0.34), MAP), 0.3) > 0.03);
}

#[test]
fn lines_belong_to_the_land() {
    let Some(mut world) = world(height_m) else { return };
    let eye_m = DVec3::new(130.0, -90.0, HEIGHT_M);
    let family = FAMILIES[1];
    let [here, ..] = inks(&mut world, &style(&[family], 0.4), MAP);
    let [there, ..] = inks(&mut world, &style(&[family], 0.4), "130,-90,11000,0,-90,45");
    // Compares points that are in both pictures, in the pixels of the other one, moved by `by_m` on the land.
    let off = |by_m: f64| {
        let focal_px = 135.0 / (22.5_f64).to_radians().tan();
        let mut off: Vec<f64> = Vec::new();
        for (number, ink) in here.iter().enumerate() {
            let px = [(number % 480) as f32 + 0.5, (number / 480) as f32 + 0.5];
            if !is_inside(px) {
                continue;
            }
            let place = place_m(px, DVec3::Z * HEIGHT_M) + DVec2::splat(by_m);
            let away = (place - eye_m.truncate()) * focal_px / (eye_m.z - height_m(place.x, place.y));
            let (x, y) = (240.0 + away.x - 0.5, 135.0 - away.y - 0.5);
            if x < 1.0 || y < 1.0 || x > 478.0 || y > 268.0 {
                continue;
            }
            let (left, top) = (x.floor(), y.floor());
            let at = |i: usize, j: usize| f64::from(there[(top as usize + j) * 480 + left as usize + i]);
            let (u, v) = (x - left, y - top);
            let there = (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v) + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v;
            off.push((there - f64::from(*ink)).abs());
        }
        off.iter().sum::<f64>() / off.len() as f64
    };
    println!("mean difference of ink {:.3}; {:.3} moved by half a pixel, {:.3} by two", off(0.0), off(15.0), off(62.0));
    assert!(off(0.0) < 0.06);
    // Planted errors: lines that are moved on the land.
    assert!(off(15.0) > 1.3 * off(0.0) && off(62.0) > 2.5 * off(0.0));
}
