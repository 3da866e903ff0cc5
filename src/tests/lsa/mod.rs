//! Tests LSA: E(p) agrees with the paper's equations, the interior of a smooth hill has no lines, and its contour is
//! drawn.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

mod scales;

use common::equations::{self, Reading};
use common::hill::Hill;
use common::shot::{Shot, ink, shoot_style};
use common::silhouette::Silhouette;
use common::{World, full};
use glam::DVec2;
use hachure::picture::PartRule;
use rayon::prelude::*;

use crate::tests::helpers::styles::of_outlines;

/// Evaluates an equation for each pixel.
fn of_pixels<T: Send>(shot: &Shot, equation: impl Fn(usize) -> Option<T> + Send + Sync) -> Vec<Option<T>> {
    (0..shot.error.len()).into_par_iter().map(equation).collect()
}

/// Returns the part of the pixels away from sky and border whose E(p), clamped to [0, 1], agrees with `expected` to
/// 1e-3, and the number of these pixels. Only pixels count where E or its expected value is at least `from`.
fn agreement(shot: &Shot, expected: impl Iterator<Item = Option<f64>>, from: f64) -> (f64, usize) {
    let difference = |(expected, &found): (Option<f64>, &f64)| {
        let (expected, found) = (expected?, found.clamp(0.0, 1.0));
        (expected.max(found) >= from).then_some((found - expected).abs())
    };
    let differences: Vec<f64> = expected.zip(&shot.error).filter_map(difference).collect();
    let near = differences.iter().filter(|difference| **difference <= 1e-3).count();
    (near as f64 / differences.len() as f64, differences.len())
}

fn equations_hold(name: &str, world: Option<World>, views: &[&str]) {
    let Some(mut world) = world else { return };
    let (mut renderer, style) = (None, of_outlines(ink("paper")));
    let (mut swapped_agreed, mut edges) = (true, 0);
    for view in views {
        let pose = world.pose(view);
        let shot = shoot_style(&mut world, &mut renderer, pose, pose, [320, 180], &style, &PartRule::default());
        let [text, swapped] = [Reading::Text, Reading::Swapped]
            .map(|reading| of_pixels(&shot, |pixel| equations::error(&shot, pixel, 1e-5, reading)));
        let (part, count) = agreement(&shot, text.iter().copied(), 0.0);
        let (at_lines, lines) = agreement(&shot, text.iter().copied(), 0.1);
        let (swapped, _) = agreement(&shot, swapped.into_iter(), 0.1);
        println!(
            "{name}, {view}: {:.4} % of {count} agree; {:.4} % of the {lines} from 0.1 on, {:.2} % when swapped",
            100.0 * part,
            100.0 * at_lines,
            100.0 * swapped
        );
        assert!(count > 5_000 && part >= 0.999 && (at_lines >= 0.999 || lines < 100), "{name}, {view}");
        swapped_agreed &= swapped >= 0.999 || lines < 100;
        edges += lines;
    }
    assert!(edges > 300, "{name}: {edges} pixels with an error are too few for a test");
    assert!(!swapped_agreed, "{name}: swapping the checked and the control pixel must fail");
}

#[test]
fn errors_follow_the_equations_on_the_hill() {
    let views = ["0,-900,+300,0,-25,50", "-900,-900,+40,45,-2,30", "150,-700,+300,350,-30,20"];
    let count = if full() { 3 } else { 2 };
    equations_hold("hill", World::new(Hill::square(321, 10.0).1, 1.0), &views[..count]);
}

#[test]
fn errors_follow_the_equations_on_mount_rainier() {
    let views = ["-8000,-12000,+1500,30,-12,50", "3000,2000,+200,160,-5,60", "0,-45000,9000,0,-10,35"];
    let count = if full() { 3 } else { 1 };
    equations_hold("Rainier", World::real("dem/geotiff/mt_rainier_90m.tif", 1.0), &views[..count]);
}

fn equation_8_holds(name: &str, world: Option<World>, views: &[&str]) {
    let Some(mut world) = world else { return };
    let mut style = of_outlines(ink("paper"));
    let lines = style.lines_mut().unwrap();
    lines.geometric_antialias = true;
    let ramp = lines.ramp.map(f64::from);
    let (mut renderer, mut counted) = (None, 0);
    let mut planted_agree = [true; 3];
    for view in views {
        let pose = world.pose(view);
        let shot = shoot_style(&mut world, &mut renderer, pose, pose, [320, 180], &style, &PartRule::default());
        let errors = of_pixels(&shot, |pixel| equations::antialiased_errors(&shot, pixel, 1e-5, ramp));
        let of = |i: usize| agreement(&shot, errors.iter().map(|errors| errors.map(|errors| errors[i])), 0.1);
        let (part, count) = of(0);
        // Planted: without Eq. 8; the larger of the far errors; both far pixels at once.
        let planted = [of(1).0, of(2).0, of(3).0];
        println!("{name}, {view}: {:.4} % of {count} agree; planted {planted:.3?}", 100.0 * part);
        assert!(part >= 0.998 || count < 100, "{name}, {view}");
        planted_agree = std::array::from_fn(|i| planted_agree[i] && (planted[i] >= 0.998 || count < 100));
        counted += count;
    }
    assert!(counted > 300, "{name}: {counted} pixels with an error are too few for a test");
    assert_eq!(planted_agree, [false; 3], "{name}: planted errors were not detected");
}

#[test]
fn errors_follow_equation_8_on_the_hill_and_on_mount_rainier() {
    let views = ["0,-900,+300,0,-25,50", "-900,-900,+40,45,-2,30"];
    equation_8_holds("hill", World::new(Hill::square(321, 10.0).1, 1.0), &views);
    if !full() {
        return;
    }
    let views = ["-8000,-12000,+1500,30,-12,50", "0,-45000,9000,0,-10,35"];
    equation_8_holds("Rainier", World::real("dem/geotiff/mt_rainier_90m.tif", 1.0), &views);
}

/// Counts of pixels in a picture of the hill.
#[derive(Debug)]
struct Counts {
    /// Pixels of the surface that are farther than 3 px from a true contour and the picture's border; `wrong` of them
    /// have a line.
    interior: usize,
    wrong: usize,
    /// Pixels of the true contour; `drawn` of them have a line within 2 px.
    contour: usize,
    drawn: usize,
}

fn count(shot: &Shot, truth: &Silhouette, line: &[f64]) -> Counts {
    let near = |pixel: usize, reach: i64, is: &dyn Fn(usize) -> bool| {
        (-reach..=reach).any(|dy| {
            (-reach..=reach)
                .any(|dx| dx * dx + dy * dy <= reach * reach && shot.neighbour(pixel, [dx, dy]).is_some_and(is))
        })
    };
    let mut counts = Counts { interior: 0, wrong: 0, contour: 0, drawn: 0 };
    for pixel in 0..line.len() {
        let is_border = [[-3, -3], [3, 3]].iter().any(|step| shot.neighbour(pixel, *step).is_none());
        if is_border {
            continue;
        }
        if truth.is_contour[pixel] {
            counts.contour += 1;
            counts.drawn += usize::from(near(pixel, 2, &|neighbour| line[neighbour] > 0.5));
        } else if !shot.is_sky(pixel) && !near(pixel, 3, &|neighbour| truth.may_be_contour[neighbour]) {
            counts.interior += 1;
            counts.wrong += usize::from(line[pixel] > 0.5);
        }
    }
    counts
}

impl Counts {
    fn wrong_holds(&self) -> bool {
        self.wrong * 10_000 < self.interior.max(10_000)
    }

    fn drawn_holds(&self) -> bool {
        self.drawn * 100 >= self.contour * 99
    }
}

fn hill_is_drawn(name: &str, hill: Hill, world: Option<World>, half_m: DVec2, views: &[&str]) {
    let Some(mut world) = world else { return };
    let (mut renderer, style) = (None, of_outlines(ink("footprint")));
    let mut failures = Vec::new();
    let (mut interior, mut contour) = (0, 0);
    for (i, view) in views.iter().enumerate() {
        let pose = world.pose(view);
        let size_px = [320, 180];
        let shot = shoot_style(&mut world, &mut renderer, pose, pose, size_px, &style, &PartRule::default());
        let truth = Silhouette::of(&hill, &shot, half_m);
        let counts = count(&shot, &truth, &shot.line);
        println!(
            "{name}, {view}: {} of {} interior pixels with a line, {} of {} contour pixels drawn; {} sky pixels differ",
            counts.wrong, counts.interior, counts.drawn, counts.contour, truth.sky_differs
        );
        shot.keep(&format!("{name}-{i}-line"), |pixel| 1.0 - shot.line[pixel]);
        shot.keep(&format!("{name}-{i}-truth"), |pixel| match (truth.is_contour[pixel], truth.may_be_contour[pixel]) {
            (true, _) => 0.0,
            (false, true) => 0.5,
            (false, false) => 1.0,
        });
        shot.keep(&format!("{name}-{i}-error"), |pixel| 1.0 - shot.error[pixel]);
        if !counts.wrong_holds() || !counts.drawn_holds() {
            failures.push(format!("{view}: {counts:?}"));
        }
        interior += counts.interior;
        contour += counts.contour;
        // Planted: a line across the middle, and a picture without lines.
        let mut line = shot.line.clone();
        let row = size_px[0] as usize * 130;
        line[row..row + size_px[0] as usize].fill(1.0);
        assert!(!count(&shot, &truth, &line).wrong_holds(), "a planted line inside was not detected");
        assert!(
            counts.contour == 0 || !count(&shot, &truth, &vec![0.0; line.len()]).drawn_holds(),
            "missing lines were not detected"
        );
    }
    let least = if full() { [60_000, 500] } else { [10_000, 80].map(|least| least * views.len()) };
    let is_enough = interior > least[0] && contour > least[1];
    assert!(is_enough, "{name}: {interior} interior, {contour} contour pixels are too few");
    assert!(failures.is_empty(), "{name}:\n{}", failures.join("\n"));
}

#[test]
fn the_hill_is_drawn_by_its_contour() {
    let views = [
        "300,-300,+1,200,-30,60",
        "-1200,-1200,+30,45,0,40",
        "300,-500,+1,330,2,60",
        "100,-800,+150,0,-20,60",
        "0,-3000,+200,0,-2,30",
        "-4500,0,+300,90,-3,15",
    ];
    let (hill, grid) = Hill::square(1025, 10.0);
    let count = if full() { 6 } else { 2 };
    hill_is_drawn("hill", hill, World::new(grid, 1.0), DVec2::splat(5_120.0), &views[..count]);
}

/// Returns the hill on a strip of land, far from the origin.
fn strip(away_m: f64, spacing_m: f64) -> (Hill, Option<World>, DVec2) {
    let (hill, grid) = Hill::far(away_m, spacing_m);
    let half_m = DVec2::new(f64::from(grid.width - 1), f64::from(grid.height - 1)) * 0.5 * spacing_m;
    (hill, World::new(grid, 1.0), half_m)
}

#[test]
fn the_hill_is_drawn_far_from_the_origin() {
    let (hill, world, half_m) = strip(100_000.0, 20.0);
    let views = [
        "-99700,-500,+1,330,2,60",
        "-99700,-300,+1,200,-30,60",
        "-101200,-1200,+30,45,0,40",
        "-99900,-800,+150,0,-20,60",
        "-90000,0,+500,270,-2.5,10",
        "-90000,0,+60,270,0,6",
    ];
    hill_is_drawn("hill at 100 km", hill, world, half_m, &views);
}

#[test]
fn the_hill_is_drawn_from_100_km_away() {
    let (hill, world, half_m) = strip(50_000.0, 20.0);
    // The hill is seen against the land behind it and against the sky. (From lower down, the plain turns into the hill
    // within a pixel, which is a line.)
    let views = ["50000,0,4000,270,-2.2,1", "50000,0,9000,270,-5.1,1", "50000,0,1500,270,-0.7,1"];
    let count = if full() { 3 } else { 1 };
    hill_is_drawn("hill from 100 km", hill, world, half_m, &views[..count]);
}
