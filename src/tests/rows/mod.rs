//! Tests rows of hachures: marks run down the slope at even distances, taper, do not touch, have the requested
//! darkness, and stick to the land.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;
mod real;

use common::draw::{draw, places_m, still};
use common::{World, grid_of, quantile, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::frame::{Light, Renderer};
use hachure::gpu::readback::read;
use hachure::scene::view::View;
use hachure::style::Style;
use hachure::surface::rows::marks::RowSample;
use hachure::surface::rows::ribbons::ROW_INK;

const SIZE_PX: [u32; 2] = [480, 270];
const SPACING_PX: f64 = 6.0;
/// A map of 31 m per pixel, so that blocks of 64 cells of 4 samples meet in the middle of the picture, and only one
/// level of blocks is visible.
const MAP: &str = "0,0,11000,0,-90,45";
const PIXEL_M: f64 = 31.0;
const DARKNESS: f64 = 0.4;

/// Smooth land that its form reproduces, with slopes of 5 to 15 degrees.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    1000.0 + 0.12 * x_m + 0.07 * y_m + 250.0 * (x_m / 2900.0).sin() + 220.0 * (y_m / 2500.0 + x_m / 6000.0).cos()
}

/// A cone whose tip is off-screen, so rows are arcs.
fn cone_m(x_m: f64, y_m: f64) -> f64 {
    2500.0 - 0.2 * (x_m + 14_000.0).hypot(y_m + 3_000.0)
}

fn gradient(height_m: fn(f64, f64) -> f64, at: DVec2) -> DVec2 {
    let d = 0.5;
    let east = height_m(at.x + d, at.y) - height_m(at.x - d, at.y);
    let north = height_m(at.x, at.y + d) - height_m(at.x, at.y - d);
    DVec2::new(east, north) / (2.0 * d)
}

/// Returns a style with marks of an even tone.
fn style(darkness: f64) -> Style {
    let tone = 1.0 - darkness;
    let text = format!(
        "name = \"rows\"\ndescription = \"\"\n[rows]\nspacing_px = {SPACING_PX}\n[tone]\nkind = \"toon\"\nsteps = 0\n\
         darkest = {tone}\nlightest = {tone}\n"
    );
    Style::parse("rows", &text).unwrap()
}

/// A mark, in the picture and in the world.
#[derive(Clone)]
struct Mark {
    px: Vec<DVec2>,
    place_m: Vec<DVec3>,
    width_px: Vec<f64>,
}

impl Mark {
    fn of(line: &[RowSample], view: &View) -> Self {
        let px: Vec<DVec2> = line.iter().map(|sample| DVec2::new(sample.px[0].into(), sample.px[1].into())).collect();
        let place =
            |(px, sample): (&DVec2, &RowSample)| view.pose.position_m + view.ray(*px) * f64::from(sample.depth_m);
        let place_m = px.iter().zip(line).map(place).collect();
        Self { px, place_m, width_px: line.iter().map(|sample| sample.width_px.into()).collect() }
    }

    fn length_px(&self) -> f64 {
        self.px.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    fn widest_px(&self) -> f64 {
        self.width_px.iter().copied().fold(0.0, f64::max)
    }

    fn is_inside(&self, margin_px: f64) -> bool {
        let [width, height] = SIZE_PX.map(f64::from);
        let inside =
            |px: &DVec2| px.x > margin_px && px.y > margin_px && px.x < width - margin_px && px.y < height - margin_px;
        self.px.iter().all(inside)
    }
}

/// Returns the marks of a map, and the ink of its pixels.
fn map(world: &mut World, style: &Style, camera: &str) -> (Vec<Mark>, Vec<f64>) {
    let view = still(world.pose(camera), SIZE_PX);
    let drawn = marks_of(world, style, &view);
    (drawn.marks, drawn.ink)
}

struct Drawn {
    marks: Vec<Mark>,
    /// Ink of each pixel, from 0 to 1.
    ink: Vec<f64>,
    /// Point of each pixel in the world; `None` for the sky.
    places_m: Vec<Option<DVec3>>,
}

fn marks_of(world: &mut World, style: &Style, view: &View) -> Drawn {
    let size_px = view.part.size_px;
    let light = Light { to_sun: DVec3::Z, haze_m: 1e9, haze_srgb: None, focus: None };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, view, style, &light);
    let lines = renderer.drawn_rows(&world.gpu).unwrap().unwrap();
    let bytes = read(&world.gpu, renderer.target(&ROW_INK).unwrap(), [0, 0], size_px).unwrap();
    let ink = bytes.chunks_exact(2).map(|half| half::f16::from_le_bytes([half[0], half[1]]).to_f64()).collect();
    let marks = lines.iter().filter(|line| line.len() > 1).map(|line| Mark::of(line, view)).collect();
    Drawn { marks, ink, places_m: places_m(&world.gpu, &renderer, view.pose.position_m) }
}

fn world(height_m: fn(f64, f64) -> f64) -> Option<World> {
    World::new(grid_of(513, 513, 60.0, height_m), 1.0)
}

/// Returns the angles between the slope and the marks rotated by `turn_rad`: median and 90th percentile, in degrees.
fn strayed_deg(marks: &[Mark], height_m: fn(f64, f64) -> f64, turn_rad: f64) -> [f64; 2] {
    let mut angles: Vec<f64> = Vec::new();
    for mark in marks.iter().filter(|mark| mark.is_inside(8.0)) {
        for (pair, px) in mark.place_m.windows(2).zip(mark.px.windows(2)) {
            if px[0].distance(px[1]) < 1.0 {
                continue;
            }
            let way = DVec2::from_angle(turn_rad).rotate((pair[1] - pair[0]).truncate());
            let middle = (pair[0] + pair[1]).truncate() * 0.5;
            let angle = way.angle_to(gradient(height_m, middle)).to_degrees().abs();
            angles.push(angle.min(180.0 - angle));
        }
    }
    assert!(angles.len() > 500);
    [quantile(&mut angles, 0.5), quantile(&mut angles, 0.9)]
}

#[test]
fn marks_run_down_the_slope() {
    let Some(mut world) = world(height_m) else { return };
    let (marks, _) = map(&mut world, &style(DARKNESS), MAP);
    let [median, most] = strayed_deg(&marks, height_m, 0.0);
    println!("{} marks; they stray by {median:.2} degrees, 90 % by less than {most:.2}", marks.len());
    assert!(median < 1.0 && most < 4.0);
    // Planted: rotated marks.
    assert!(strayed_deg(&marks, height_m, 0.06)[0] > 1.0);
}

/// Returns the gap from each mark's middle to the next mark on one side, in pixels, with the middle's position. Only
/// marks count that have grown to at least half their width.
fn gaps_px(marks: &[Mark]) -> Vec<(f64, DVec3)> {
    let grown = |mark: &&Mark| mark.widest_px() > 0.5 * DARKNESS * SPACING_PX;
    let marks: Vec<&Mark> = marks.iter().filter(grown).collect();
    let gap = |(number, mark): (usize, &&Mark)| {
        let widest = mark.px.len() / 2;
        let (at, along) = (mark.px[widest], mark.px[widest + 1] - mark.px[widest - 1]);
        let across = DVec2::new(-along.y, along.x).normalize_or_zero();
        let others = marks.iter().enumerate().filter(|(other, _)| *other != number).flat_map(|(_, other)| {
            other.px.windows(2).filter_map(|pair| {
                let (a, b) = ((pair[0] - at).dot(along), (pair[1] - at).dot(along));
                let crosses = (a > 0.0) != (b > 0.0);
                crosses.then(|| (pair[0] + (pair[1] - pair[0]) * (a / (a - b)) - at).dot(across))
            })
        });
        let nearest = others.filter(|gap| *gap > 0.0).fold(f64::INFINITY, f64::min);
        (nearest < 3.0 * SPACING_PX).then_some((nearest, mark.place_m[widest]))
    };
    marks.iter().enumerate().filter(|(_, mark)| mark.px.len() > 4 && mark.is_inside(16.0)).filter_map(gap).collect()
}

/// Returns the mean, and the standard deviation relative to the mean.
fn spread(gaps: &[f64]) -> [f64; 2] {
    let count = gaps.len() as f64;
    let mean = gaps.iter().sum::<f64>() / count;
    let variance = gaps.iter().map(|gap| (gap - mean).powi(2)).sum::<f64>() / count;
    [mean, variance.sqrt() / mean]
}

#[test]
fn marks_stand_at_even_distances_also_where_blocks_meet() {
    for (name, height_m) in [("waves", height_m as fn(f64, f64) -> f64), ("cone", cone_m)] {
        let Some(mut world) = world(height_m) else { return };
        let (marks, _) = map(&mut world, &style(DARKNESS), MAP);
        let gaps = gaps_px(&marks);
        let near_border = |place: &DVec3| place.x.abs().min(place.y.abs()) < 2.0 * SPACING_PX * PIXEL_M;
        let all: Vec<f64> = gaps.iter().map(|(gap, _)| *gap).collect();
        let at_borders: Vec<f64> = gaps.iter().filter(|(_, place)| near_border(place)).map(|(gap, _)| *gap).collect();
        let ([mean, varies], [mean_at_borders, varies_at_borders]) = (spread(&all), spread(&at_borders));
        println!(
            "{name}: {} gaps of {mean:.2} px vary by {varies:.3}; at borders {} of {mean_at_borders:.2} by {varies_at_borders:.3}",
            all.len(),
            at_borders.len()
        );
        // The goal is 0.25; docs/decisions/rows.md says what is missing.
        assert!(varies < 0.36 && (0.8..1.3).contains(&(mean / SPACING_PX)), "{name}");
        assert!(varies_at_borders < 0.39 && (mean_at_borders / mean - 1.0).abs() < 0.1, "{name}");
        // Planted: every fifth mark is missing.
        let fewer: Vec<Mark> =
            marks.iter().enumerate().filter(|(i, _)| i % 5 > 0).map(|(_, mark)| mark.clone()).collect();
        let fewer: Vec<f64> = gaps_px(&fewer).iter().map(|(gap, _)| *gap).collect();
        assert!(spread(&fewer)[1] > 1.1 * varies, "{name}: {:?}", spread(&fewer));
    }
}

/// Returns the part of the ink that two marks cover, if each mark is `wider` times as wide.
fn shared_ink(marks: &[Mark], wider: f64) -> f64 {
    // The raster has four cells per pixel and axis.
    let [width, height] = SIZE_PX.map(|side| 4 * side as usize);
    let mut owner = vec![0_u32; width * height];
    let mut twice = 0;
    for (number, mark) in marks.iter().enumerate() {
        let own = number as u32 + 1;
        let radius = |i: usize| 2.0 * wider * mark.width_px[i];
        for i in 0..mark.px.len() - 1 {
            let (a, b) = (mark.px[i] * 4.0, mark.px[i + 1] * 4.0);
            let reach = radius(i).max(radius(i + 1));
            let (low, high) = (a.min(b) - reach, a.max(b) + reach);
            for y in low.y.max(0.0) as usize..(high.y.max(0.0) as usize + 1).min(height) {
                for x in low.x.max(0.0) as usize..(high.x.max(0.0) as usize + 1).min(width) {
                    let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let t = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-9)).clamp(0.0, 1.0);
                    if at.distance(a + (b - a) * t) < radius(i) + (radius(i + 1) - radius(i)) * t {
                        let place = &mut owner[y * width + x];
                        twice += usize::from(*place != 0 && *place != own && *place != u32::MAX);
                        *place = if *place == 0 || *place == own { own } else { u32::MAX };
                    }
                }
            }
        }
    }
    twice as f64 / owner.iter().filter(|owner| **owner != 0).count() as f64
}

#[test]
fn marks_are_slender_and_do_not_touch() {
    let Some(mut world) = world(height_m) else { return };
    let (marks, _) = map(&mut world, &style(DARKNESS), MAP);
    let blunt = |marks: &[Mark], wider: f64| {
        let is_blunt = |mark: &&Mark| mark.length_px() < 3.99 * wider * mark.widest_px();
        marks.iter().filter(is_blunt).count()
    };
    let (shared, of_wider) = (shared_ink(&marks, 1.0), shared_ink(&marks, 2.0));
    println!(
        "{} of {} marks are blunt; two cover {shared:.5} of the ink, {of_wider:.5} if they are twice as wide",
        blunt(&marks, 1.0),
        marks.len()
    );
    assert_eq!(blunt(&marks, 1.0), 0);
    // Marks hardly overlap.
    assert!(shared < 0.001);
    // Planted: wider marks.
    assert!(blunt(&marks, 3.0) > 0 && of_wider > 0.016);
    // Ends taper to a width of 0.
    let ends = marks.iter().flat_map(|mark| [mark.width_px[0], mark.width_px[mark.px.len() - 1]]);
    assert!(ends.fold(0.0, f64::max) < 0.05);
}

#[test]
fn rows_are_as_dark_as_they_should_be() {
    let Some(mut world) = world(cone_m) else { return };
    let worst = |world: &mut World, asked: f64, drawn: f64| {
        let (_, ink) = map(world, &style(drawn), MAP);
        let [width, height] = SIZE_PX.map(|side| side as usize);
        let mut missed: Vec<f64> = Vec::new();
        for (x, y) in (0..height - 64).step_by(32).flat_map(|y| (0..width - 64).step_by(32).map(move |x| (x, y))) {
            let sum: f64 = (y..y + 64).map(|row| ink[row * width + x..row * width + x + 64].iter().sum::<f64>()).sum();
            missed.push((sum / 4096.0 - asked).abs());
        }
        [quantile(&mut missed, 0.5), quantile(&mut missed, 1.0)]
    };
    let asked: &[f64] = if common::full() { &[0.15, 0.3, 0.5] } else { &[0.3] };
    for &asked in asked {
        let [median, most] = worst(&mut world, asked, asked);
        println!("{asked}: windows miss it by {median:.4}, at most by {most:.4}");
        // The goal is that every window is within 0.03; docs/decisions/rows.md describes the gap.
        assert!(median < 0.03 && most < 0.25, "{asked}: windows miss it by {median} at the median, {most} at most");
    }
    // Planted: another tone.
    assert!(worst(&mut world, 0.3, 0.36)[0] > 0.03);
}

/// Height of the bins in which marks are counted.
const BIN_M: f64 = 10.0;

/// Returns how much the number of marks on an equal piece of land varies from height to height, relative to its mean.
/// `extents_m` are the lowest and the highest point of each mark, and `heights_m` the height of each pixel.
fn varies_by_height(extents_m: &[[f64; 2]], heights_m: &[f64]) -> f64 {
    let bin = |height_m: f64| (height_m / BIN_M).floor() as i64;
    let mut land = std::collections::BTreeMap::new();
    heights_m.iter().for_each(|height_m| *land.entry(bin(*height_m)).or_insert(0.0) += 1.0);
    let most = land.values().copied().fold(0.0, f64::max);
    // Bins at the border of the picture have little land, whose marks may be cut.
    let density = land.iter().filter(|(_, pixels)| **pixels > 0.7 * most).map(|(bin, pixels)| {
        let middle_m = (*bin as f64 + 0.5) * BIN_M;
        extents_m.iter().filter(|[low, high]| (*low..=*high).contains(&middle_m)).count() as f64 / pixels
    });
    spread(&density.collect::<Vec<f64>>())[1]
}

#[test]
fn no_white_lines_run_between_rows() {
    let Some(mut world) = world(cone_m) else { return };
    let view = still(world.pose(MAP), SIZE_PX);
    let Drawn { marks, places_m, .. } = marks_of(&mut world, &style(DARKNESS), &view);
    let heights_m: Vec<f64> = places_m.into_iter().flatten().map(|place_m| place_m.z).collect();
    let extent = |mark: &Mark| {
        let heights = || mark.place_m.iter().map(|place_m| place_m.z);
        [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)]
    };
    let extents_m: Vec<[f64; 2]> = marks.iter().map(extent).collect();
    let mut lengths_m: Vec<f64> = extents_m.iter().map(|[low, high]| high - low).collect();
    let row_m = quantile(&mut lengths_m, 0.5);
    let found = varies_by_height(&extents_m, &heights_m);
    // Planted: marks that end where their rows do, with a tenth of a row between them.
    let aligned = |[low, high]: &[f64; 2]| {
        let begin_m = (0.5 * (low + high) / row_m).floor() * row_m;
        [begin_m + 0.05 * row_m, begin_m + 0.95 * row_m]
    };
    let planted = varies_by_height(&extents_m.iter().map(aligned).collect::<Vec<_>>(), &heights_m);
    println!("rows of {row_m:.0} m: marks vary by {found:.2} from height to height, planted {planted:.2}");
    assert!(found < 0.22 && planted > 0.3, "{found}, planted {planted}");
}

#[test]
fn marks_belong_to_the_land() {
    let Some(mut world) = world(height_m) else { return };
    let (marks, _) = map(&mut world, &style(DARKNESS), MAP);
    let (others, _) = map(&mut world, &style(DARKNESS), "130,-90,11040,3,-88,45");
    // Returns the part of marks, moved by `by_m`, whose middle is that of a mark drawn for the other eye.
    let found = |by_m: f64| {
        let middle = |mark: &Mark| mark.place_m[mark.px.len() / 2].truncate();
        let others: Vec<DVec2> = others.iter().map(middle).collect();
        let inside: Vec<DVec2> = marks.iter().filter(|mark| mark.is_inside(32.0)).map(middle).collect();
        let has = |at: &&DVec2| {
            others.iter().any(|other| other.distance(**at + DVec2::splat(by_m)) < 0.1 * SPACING_PX * PIXEL_M)
        };
        inside.iter().filter(has).count() as f64 / inside.len() as f64
    };
    println!("{:.3} of {} marks are at the same point; {:.3} of moved marks", found(0.0), marks.len(), found(60.0));
    assert!(found(0.0) > 0.78);
    // Planted: marks moved by 60 m.
    assert!(found(60.0) < 0.5);
}

const FARTHEST_M: f64 = 16_000.0;

/// Returns the mean ink of marks in bands of distance, from near to far: of all ink, and of that up to `rubbed_m`.
fn bands(world: &mut World, spacing_px: f64, rubbed_m: f64) -> [Vec<f64>; 2] {
    let mut style = style(DARKNESS);
    style.rows_mut().unwrap().spacing_px = spacing_px as f32;
    let view = still(world.pose("0,-9000,+700,0,-8,60"), SIZE_PX);
    let light = Light { to_sun: DVec3::Z, haze_m: 1e9, haze_srgb: None, focus: None };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &light);
    let bytes = read(&world.gpu, renderer.target(&ROW_INK).unwrap(), [0, 0], SIZE_PX).unwrap();
    let inks = bytes.chunks_exact(2).map(|half| half::f16::from_le_bytes([half[0], half[1]]).to_f64());
    let places = places_m(&world.gpu, &renderer, view.pose.position_m);
    let mut sums = [[0.0; 3]; 4];
    for (ink, place) in inks.zip(places) {
        let away_m = place.map_or(f64::INFINITY, |place| place.distance(view.pose.position_m));
        if away_m <= FARTHEST_M {
            let sums = &mut sums[((away_m / FARTHEST_M * 4.0) as usize).min(3)];
            sums[0] += ink;
            sums[1] += if away_m > rubbed_m { 0.0 } else { ink };
            sums[2] += 1.0;
        }
    }
    [0, 1].map(|kind| sums.iter().map(|sums| sums[kind] / sums[2].max(1.0)).collect())
}

/// Returns whether every band of distance has ink.
fn reach(inks: &[f64]) -> bool {
    inks.iter().all(|ink| *ink > 0.15)
}

#[test]
fn rows_reach_as_far_as_the_land() {
    // Marks this close on a small picture need as many blocks as usual marks on a picture 1440 px wide.
    let Some(mut world) = World::new(grid_of(513, 513, 60.0, rough_height_m), 1.0) else { return };
    let spacings_px: &[f64] = if common::full() { &[6.0, 2.0] } else { &[3.0] };
    for &spacing_px in spacings_px {
        let [inks, rubbed] = bands(&mut world, spacing_px, 0.75 * FARTHEST_M);
        println!("marks {spacing_px} px apart: ink from near to far {inks:.3?}");
        // With the blocks of a single pool, far land has no ink at 2 px.
        assert!(reach(&inks), "{inks:?}");
        // Planted: rows that end at three quarters of the distance.
        assert!(!reach(&rubbed), "{spacing_px} px");
    }
}
