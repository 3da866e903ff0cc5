//! Tests a slow zoom: nothing pops, and with the fractal rule no mark disappears.

use glam::DVec2;

use crate::tests::common::full;
use crate::tests::hatching::plane::{Inked, Plane, fixed, style};

/// Each frame is nearer by this factor.
const ZOOM: f64 = 1.01;
/// Largest allowed change of a neighbourhood's mean ink from one frame to the next.
const ALLOWED: f64 = 0.02;
/// Largest allowed part of the marks that differs in the next frame. Blending marks disappear within the 35 frames of
/// half an octave.
const ALLOWED_CHANGE: f64 = 0.16;
/// Side of the pictures, in pixels.
const SIDE_PX: u32 = 224;
const MIDDLE_PX: f64 = 0.5 * SIDE_PX as f64;
/// Standard deviation of the Gaussian that weights a neighbourhood; it is as wide as a square of 64 pixels.
const SIGMA_PX: f64 = 18.5;

/// Draws the frames of a zoom straight onto the plane.
fn frames(plane: &mut Plane, scale: &str, layers: &str, darkness: f64, count: usize) -> Vec<Inked> {
    let style = style(scale, darkness, layers);
    (0..count)
        .map(|i| {
            let distance_m = 900.0 / ZOOM.powi(i as i32);
            plane.shoot(plane.eye(11.0, distance_m, 0.0, 0.0, 30.0), [SIDE_PX; 2], &style)
        })
        .collect()
}

/// Returns the Gaussian-weighted mean of ink about a point, with ink interpolated between pixels. Both the Gaussian and
/// the interpolation are products of a weight along rows and one along columns.
fn about(shot: &Inked, middle: DVec2) -> f64 {
    let reach = (2.5 * SIGMA_PX) as i64;
    let bell = |step: i64| {
        let is_near = step.abs() <= reach;
        if is_near { (-((step * step) as f64) / (2.0 * SIGMA_PX * SIGMA_PX)).exp() } else { 0.0 }
    };
    let whole = (-reach..=reach).map(bell).sum::<f64>();
    // The first pixel along an axis, and the weights of it and of those after it.
    let along = |middle: f64| {
        let (pixel, part) = ((middle - 0.5).floor() as usize, (middle - 0.5).fract());
        let weights = (-reach..=reach + 1).map(|step| (bell(step) * (1.0 - part) + bell(step - 1) * part) / whole);
        (pixel - reach as usize, weights.collect::<Vec<f64>>())
    };
    let ((left, across), (top, down)) = (along(middle.x), along(middle.y));
    let row = |y: usize| &shot.ink[y * shot.size_px[0] + left..][..across.len()];
    let of_row = |y: usize| row(y).iter().zip(&across).map(|(ink, weight)| ink * weight).sum::<f64>();
    (top..).zip(&down).map(|(y, weight)| weight * of_row(y)).sum()
}

/// Returns the largest change of a neighbourhood's mean from one frame to the next.
fn largest_pop(shots: &[Inked]) -> f64 {
    let mut largest: f64 = 0.0;
    for pair in shots.windows(2) {
        for y in [-48.0, -16.0, 16.0, 48.0] {
            for x in [-48.0, -16.0, 16.0, 48.0] {
                let from_middle = DVec2::new(x, y);
                let change = about(&pair[1], from_middle * ZOOM + MIDDLE_PX) - about(&pair[0], from_middle + MIDDLE_PX);
                largest = largest.max(change.abs());
            }
        }
    }
    largest
}

/// Returns which part of the marks differs in the next frame: the mean difference of ink at points of the ground,
/// blurred by the width of a pen, divided by what it is between independent pictures.
fn largest_change(shots: &[Inked], darkness: f64) -> f64 {
    let blurred = |shot: &Inked, px: DVec2| {
        let taps = (-1..=1).flat_map(|y| (-1..=1).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        taps.filter_map(|tap| shot.between(px + tap * 1.2)).sum::<f64>() / 9.0
    };
    let places: Vec<_> =
        (-24..=24).flat_map(|y| (-24..=24).map(move |x| DVec2::new(f64::from(x), f64::from(y)))).collect();
    let change = |pair: &[Inked]| {
        let off = places.iter().map(|place| {
            let from_middle = *place * 3.7;
            (blurred(&pair[1], from_middle * ZOOM + MIDDLE_PX) - blurred(&pair[0], from_middle + MIDDLE_PX)).abs()
        });
        off.sum::<f64>() / places.len() as f64
    };
    shots.windows(2).map(change).fold(0.0, f64::max) / (2.0 * darkness * (1.0 - darkness))
}

/// Counts inked pixels whose point on the ground has no ink within 1.5 pixels `step` frames later.
fn removed(shots: &[Inked], step: usize) -> usize {
    let zoom = ZOOM.powi(step as i32);
    let mut count = 0;
    for (shot, later) in shots.iter().zip(&shots[step..]) {
        for y in 0..SIDE_PX as usize {
            for x in 0..SIDE_PX as usize {
                if shot.at(x, y) < 0.75 {
                    continue;
                }
                let to = (DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - MIDDLE_PX) * zoom + MIDDLE_PX;
                // A dot of one pixel may cover parts of four. So the sum of ink counts, since samples at pixel centres
                // find more or less of it.
                let [left, top] = [to.x - 2.0, to.y - 2.0].map(|first| first.round() as usize);
                let is_inside = to.min_element() > 2.0 && to.max_element() < f64::from(SIDE_PX) - 2.0;
                let near = || (top..top + 4).flat_map(|y| (left..left + 4).map(move |x| (x, y)));
                if is_inside && near().map(|(x, y)| later.at(x, y)).sum::<f64>() < 0.25 {
                    count += 1;
                }
            }
        }
    }
    count
}

#[test]
fn nothing_pops_while_zooming_through_octaves() {
    let Some(mut plane) = Plane::new(15.0) else { return };
    // Three octaves; in the fast tier a little more than half of one, since all halves are alike.
    let octaves: f64 = if full() { 3.0 } else { 0.52 };
    let count = (octaves * 2.0_f64.ln() / ZOOM.ln()).ceil() as usize + 1;
    let mut failed = Vec::new();
    // In the fast tier only lines that blend: the climb in `seams` has marks that are added.
    let all = [("blend", "line"), ("blend", "stipple"), ("add", "stipple"), ("blend", "hachure"), ("add", "line")];
    for (scale, marks) in all.into_iter().take(if full() { all.len() } else { 1 }) {
        let shots = frames(&mut plane, scale, &fixed(marks, 0.0), 0.4, count);
        let largest = largest_pop(&shots);
        let change = largest_change(&shots, 0.4);
        println!("{scale} {marks}: a neighbourhood's mean changes by {largest:.4} at most, {change:.3} of the marks");
        if largest > ALLOWED || change > ALLOWED_CHANGE {
            failed.push(format!(
                "{scale} {marks}: a neighbourhood's mean changes by {largest}, {change} of the marks change"
            ));
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn a_jump_of_half_an_octave_pops() {
    let Some(mut plane) = Plane::new(15.0) else { return };
    let mut shots = frames(&mut plane, "blend", &fixed("line", 0.0), 0.4, 4);
    assert!(largest_pop(&shots) <= ALLOWED && largest_change(&shots, 0.4) <= ALLOWED_CHANGE);
    // Planted error: a tone that jumps.
    let darker = frames(&mut plane, "blend", &fixed("line", 0.0), 0.43, 1).remove(0);
    assert!(largest_pop(&[frames(&mut plane, "blend", &fixed("line", 0.0), 0.4, 1).remove(0), darker]) > ALLOWED);
    // Planted error: marks that jump while the mean of their ink does not.
    let other = style("blend", 0.4, &format!("{}size = 1.5\n", fixed("line", 0.0)));
    let distance_m = 900.0 / ZOOM.powi(2);
    shots[2] = plane.shoot(plane.eye(11.0, distance_m, 0.0, 0.0, 30.0), [SIDE_PX; 2], &other);
    let change = largest_change(&shots, 0.4);
    println!("of marks that jump {change:.3}");
    assert!(change > 1.5 * ALLOWED_CHANGE);
}

#[test]
fn by_the_fractal_rule_no_mark_goes() {
    let Some(mut plane) = Plane::new(15.0) else { return };
    // A mark that blends has disappeared after ten frames. Dashes are compared with the next frame only: a dash keeps
    // its length in the picture, so within ten frames its ends move on the ground by more than the neighbourhood.
    let all = [("line", 0.2, 10), ("dash", 0.3, 1), ("stipple", 0.5, 10), ("line", 0.6, 10), ("stipple", 0.15, 10)];
    // In the fast tier one darkness of each kind.
    for (marks, darkness, step) in all.into_iter().take(if full() { all.len() } else { 3 }) {
        // About two octaves; in the fast tier a little more than one.
        let shots = frames(&mut plane, "add", &fixed(marks, 20.0), darkness, if full() { 150 } else { 80 });
        assert_eq!(removed(&shots, step), 0, "{marks} at darkness {darkness}: inked pixels lost their ink");
        let (first, last) = (shots[0].mean(), shots[shots.len() - 1].mean());
        assert!((first - last).abs() < 0.03, "{marks}: mean ink changed from {first} to {last}");
    }
    // Blending removes marks, so the count must be able to exceed 0.
    let blended = frames(&mut plane, "blend", &fixed("stipple", 20.0), 0.15, 40);
    println!("blending removes {} pixels' worth in 30 frames", removed(&blended, 10));
    assert!(removed(&blended, 10) > 20);
}
