//! Tests numbers on contour lines: they are on their lines, which are interrupted there, and state their heights.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{NOON, draw, floats, still};
use common::{World, grid_of};
use glam::DVec2;
use hachure::frame::{LineGap, Renderer};
use hachure::labels::numbers::Number;
use hachure::picture::contour_numbers::{Inputs, Numbers, numbers};
use hachure::scene::map::{Map, MapArea};
use hachure::style::layers::HEIGHT_INK;
use hachure::style::{HeightsOf, Style};

const SIZE_PX: [u32; 2] = [320; 2];
/// Metres per pixel.
const PIXEL_M: f64 = 10.0;
const INTERVAL_M: f64 = 40.0;

/// Lines are at least 13 pixels apart, so that a gap that is shifted by 8 pixels is on no other line.
fn cone_m(x_m: f64, y_m: f64) -> f64 {
    1400.0 - 0.27 * (x_m - 300.0).hypot(y_m + 200.0).hypot(150.0)
}

fn ridge_m(x_m: f64, y_m: f64) -> f64 {
    900.0 - 0.3 * (y_m + 260.0 * (x_m / 700.0).sin()).hypot(120.0) + 0.06 * x_m
}

/// A drawn map of analytic land, and its ink of contour lines without gaps.
struct Drawn {
    world: World,
    style: Style,
    map: Map,
    height_m: fn(f64, f64) -> f64,
    ink: Vec<f32>,
}

impl Drawn {
    fn new(height_m: fn(f64, f64) -> f64) -> Option<Self> {
        let world = World::new(grid_of(401, 401, 10.0, height_m), 0.2)?;
        let mut style = Style::load("pen").unwrap().without(&["drainage", "ground", "strokes", "water"]);
        let lines = style.lowest_height_lines_mut().unwrap();
        lines.interval_m = INTERVAL_M as f32;
        lines.number_px = 7.0;
        let style = style.for_map(PIXEL_M).unwrap();
        let area = MapArea::Around { centre_m: DVec2::ZERO, width_m: PIXEL_M * f64::from(SIZE_PX[0]) };
        let map = Map::new(area, world.surfaces.terrain.corners_m(), SIZE_PX);
        let mut drawn = Self { world, style, map, height_m, ink: Vec::new() };
        drawn.ink = drawn.ink_with(Vec::new());
        Some(drawn)
    }

    /// Draws the map with gaps, and returns the ink of contour lines.
    fn ink_with(&mut self, gaps: Vec<LineGap>) -> Vec<f32> {
        let pose = self.map.pose(self.world.surfaces.terrain.range_m().map(f64::from));
        let mut renderer = Renderer::new(&self.world.gpu).unwrap();
        renderer.set_line_gaps(gaps);
        let (gpu, surfaces) = (&self.world.gpu, &mut self.world.surfaces);
        draw(gpu, surfaces, &mut renderer, &still(pose, SIZE_PX), &self.style, &NOON);
        floats::<1>(gpu, renderer.target(&HEIGHT_INK).unwrap()).into_iter().map(|[ink]| ink).collect()
    }

    fn numbers(&self) -> Numbers {
        let inputs =
            Inputs { map: &self.map, surfaces: &self.world.surfaces, style: &self.style, obstacles_px: &[], px: 1.0 };
        numbers(&inputs).unwrap().unwrap()
    }

    fn height_at(&self, at_px: DVec2) -> f64 {
        let at_m = self.map.world_from_px(at_px);
        (self.height_m)(at_m.x, at_m.y)
    }

    /// Returns the gradient at a point in metres per pixel; y goes down.
    fn uphill(&self, at_px: DVec2) -> DVec2 {
        let rise = |step: DVec2| self.height_at(at_px + step) - self.height_at(at_px - step);
        0.5 * DVec2::new(rise(DVec2::X), rise(DVec2::Y))
    }

    /// Returns the numbers whose text is not the height of the land under them.
    fn wrong_heights(&self, placed: &[Number]) -> usize {
        let is_wrong = |number: &&Number| {
            let stated_m: f64 = number.text.replace('−', "-").parse().unwrap();
            let is_level = (stated_m / INTERVAL_M - (stated_m / INTERVAL_M).round()).abs() < 0.1 / INTERVAL_M;
            !is_level || (self.height_at(number.centre_px) - stated_m).abs() > INTERVAL_M / 3.0
        };
        placed.iter().filter(is_wrong).count()
    }

    /// Returns the number of gaps along whose middle there is no line.
    fn off_line(&self, gaps: &[LineGap]) -> usize {
        let has_line = |gap: &&LineGap| {
            let along = (-4..=4).map(|step| gap.centre_px + f64::from(step) / 5.0 * gap.half_px.x * gap.along);
            let inked = along.filter(|at| darkest(&self.ink, *at) > 0.2).count();
            inked >= 6
        };
        gaps.iter().filter(|gap| !has_line(gap)).count()
    }
}

/// Returns the largest ink of the pixels at most 1.5 pixels away from a point.
fn darkest(ink: &[f32], at_px: DVec2) -> f32 {
    let steps = [-1.0, 0.0, 1.0];
    let around = steps.into_iter().flat_map(|y| steps.map(|x| ink_at(ink, at_px + DVec2::new(x, y))));
    around.fold(0.0, f32::max)
}

fn ink_at(ink: &[f32], at_px: DVec2) -> f32 {
    let last = SIZE_PX.map(|side| f64::from(side - 1));
    let [x, y] = [at_px.x.clamp(0.0, last[0]) as usize, at_px.y.clamp(0.0, last[1]) as usize];
    ink[y * SIZE_PX[0] as usize + x]
}

/// Returns the ink in gaps, more than half a pixel away from their borders.
fn ink_inside(ink: &[f32], gaps: &[LineGap]) -> f64 {
    let width = SIZE_PX[0] as usize;
    let is_inside = |pixel: usize| {
        let at = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
        gaps.iter().any(|gap| {
            let away = DVec2::new((at - gap.centre_px).dot(gap.along), (at - gap.centre_px).dot(gap.along.perp()));
            (gap.half_px - away.abs()).min_element() > 0.6
        })
    };
    (0..ink.len()).filter(|pixel| is_inside(*pixel)).map(|pixel| f64::from(ink[pixel])).sum()
}

/// Returns the corners of a number's text with the given part of its height.
fn corners(number: &Number, part: f64) -> [DVec2; 4] {
    let along = DVec2::from_angle(number.angle);
    let [half, up] = [0.5 * number.size_px.x * along, 0.5 * part * number.size_px.y * along.perp()];
    [-half - up, half - up, half + up, -half + up].map(|corner| number.centre_px + corner)
}

#[test]
fn numbers_are_in_the_gaps_of_their_lines() {
    for (height_m, least) in [(cone_m as fn(f64, f64) -> f64, 3), (ridge_m, 3)] {
        let Some(mut drawn) = Drawn::new(height_m) else { return };
        let numbers = drawn.numbers();
        let (placed, gaps) = (&numbers.placed, numbers.gaps());
        println!("{} numbers, {} gaps", placed.len(), gaps.len());
        assert!(placed.len() >= least && gaps.len() >= placed.len());
        assert_eq!(drawn.wrong_heights(placed), 0);
        assert_eq!(drawn.off_line(&gaps), 0);
        for number in placed {
            let top = -DVec2::from_angle(number.angle).perp();
            assert!(top.dot(drawn.uphill(number.centre_px)) > 0.0, "{number:?}");
        }
        for (i, a) in placed.iter().enumerate() {
            for b in &placed[..i] {
                let apart = corners(a, 1.0).into_iter().all(|at| {
                    let away = at - b.centre_px;
                    let along = DVec2::from_angle(b.angle);
                    away.dot(along).abs() > 0.5 * b.size_px.x || away.dot(along.perp()).abs() > 0.5 * b.size_px.y
                });
                assert!(apart, "{a:?} and {b:?}");
            }
        }
        // Lines have no ink in the gaps, and are otherwise the same.
        let interrupted = drawn.ink_with(gaps.clone());
        let [before, after] = [&drawn.ink, &interrupted].map(|ink| ink_inside(ink, &gaps));
        println!("ink in the gaps: {before:.1} px without numbers, {after:.1} px with them");
        assert!(before > 4.0 * placed.len() as f64 && after == 0.0);
        let wider = gaps.iter().map(|gap| LineGap { half_px: gap.half_px + 2.0, ..*gap });
        let wider: Vec<LineGap> = wider.collect();
        let [all, left] = [&drawn.ink, &interrupted]
            .map(|ink| ink.iter().map(|ink| f64::from(*ink)).sum::<f64>() - ink_inside(ink, &wider));
        assert!((all - left).abs() < 1e-3 * all, "{all} {left}");
        // Letters are within the boxes of their numbers.
        let (_, block) = numbers.letters().remove(0);
        assert!(block.areas.len() + block.strokes.len() >= 3 * placed.len());

        // Planted errors: gaps beside their lines, and texts that are exchanged.
        let shifted = |gap: &LineGap| LineGap { centre_px: gap.centre_px + 8.0 * gap.along.perp(), ..*gap };
        let shifted: Vec<LineGap> = gaps.iter().map(shifted).collect();
        assert!(2 * drawn.off_line(&shifted) > gaps.len());
        let interrupted = drawn.ink_with(shifted);
        assert!(ink_inside(&interrupted, &gaps) > 0.0);
        let mut exchanged = placed.clone();
        let texts: Vec<String> = placed.iter().map(|number| number.text.clone()).collect();
        exchanged.iter_mut().zip(texts.iter().cycle().skip(1)).for_each(|(number, text)| number.text.clone_from(text));
        assert!(drawn.wrong_heights(&exchanged) > 0);
    }
}

#[test]
fn styles_without_numbers_have_no_gaps() {
    let Some(mut drawn) = Drawn::new(cone_m) else { return };
    drawn.style.lowest_height_lines_mut().unwrap().number_px = 0.0;
    let inputs =
        Inputs { map: &drawn.map, surfaces: &drawn.world.surfaces, style: &drawn.style, obstacles_px: &[], px: 1.0 };
    assert!(numbers(&inputs).unwrap().is_none());
    // Without gaps the lines are whole.
    let gap = LineGap { centre_px: DVec2::splat(160.0), along: DVec2::X, half_px: DVec2::splat(60.0) };
    assert_eq!(drawn.ink_with(Vec::new()), drawn.ink);
    assert_ne!(drawn.ink_with(vec![gap]), drawn.ink);
}

#[test]
fn numbers_among_marks_have_a_halo() {
    let Some(mut drawn) = Drawn::new(cone_m) else { return };
    assert!(drawn.numbers().halo().is_none(), "there are no marks");
    let mut style = Style::load("dry-ink").unwrap();
    style.lowest_height_lines_mut().unwrap().interval_m = INTERVAL_M as f32;
    drawn.style = style.for_map(PIXEL_M).unwrap();
    let numbers = drawn.numbers();
    let (halo, letters) = (numbers.halo().unwrap(), numbers.letters().remove(0).1);
    assert_eq!(halo.ink, drawn.style.paper.color);
    assert!(letters.ink != halo.ink && halo.areas.is_empty());
    // Returns whether the halo reaches `margin_px` beyond a point.
    let covers = |at: DVec2, margin_px: f64| {
        halo.strokes.iter().any(|stroke| {
            stroke.points.windows(2).any(|pair| {
                let [a, b] = [pair[0], pair[1]];
                let part = (at - a).dot(b - a) / (b - a).length_squared().max(1e-12);
                (at - a - part.clamp(0.0, 1.0) * (b - a)).length() + margin_px <= 0.5 * stroke.width_px
            })
        })
    };
    let outlines = letters.areas.iter().flat_map(|area| area.outlines().flatten().collect::<Vec<DVec2>>());
    let points: Vec<DVec2> = outlines.chain(letters.strokes.iter().flat_map(|stroke| stroke.points.clone())).collect();
    assert!(!points.is_empty() && points.iter().all(|at| covers(*at, 2.0)));
    // Planted error: a halo that is as narrow as the letters.
    assert!(!points.iter().all(|at| covers(*at, 4.0)));
}

/// Height of the sea, which hides the lower part of the cone.
const SEA_M: f64 = 1213.0;

#[test]
fn numbers_on_depth_contours_are_depths() {
    let Some(mut drawn) = Drawn::new(cone_m) else { return };
    drawn.world.surfaces.set_sea_level(Some(SEA_M));
    drawn.style.lowest_height_lines_mut().unwrap().of = HeightsOf::Sea;
    let numbers = drawn.numbers();
    let off_m = |zero_m: f64| {
        let off = numbers.placed.iter().map(|number| {
            let stated_m: f64 = number.text.parse().unwrap();
            (zero_m - drawn.height_at(number.centre_px) - stated_m).abs()
        });
        off.fold(0.0, f64::max)
    };
    println!("{} depths, at most {:.2} m off", numbers.placed.len(), off_m(SEA_M));
    assert!(numbers.placed.len() >= 3 && off_m(SEA_M) < INTERVAL_M / 3.0);
    let (is_depth, letters) = &numbers.letters()[0];
    assert!(*is_depth && !(letters.areas.is_empty() && letters.strokes.is_empty()));
    // Planted: the sea is half an interval higher.
    assert!(off_m(SEA_M + 0.5 * INTERVAL_M) > INTERVAL_M / 3.0);
    drawn.world.surfaces.set_sea_level(None);
    assert!(drawn.numbers().placed.is_empty(), "a world without a sea has depths");
}
