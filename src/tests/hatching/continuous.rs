//! A slow zoom: nothing pops, and by the fractal rule nothing goes.

use glam::DVec2;

use crate::tests::hatching::plane::{Inked, Plane, fixed, style};

/// Each frame is nearer by this.
const ZOOM: f64 = 1.01;
/// Change of a neighbourhood's mean in a frame, at most.
const ALLOWED: f64 = 0.02;
/// Part of the marks that another frame's are not: those that blend go within the thirty-five frames of half an octave.
const ALLOWED_CHANGE: f64 = 0.16;
/// Side of the pictures.
const SIDE_PX: u32 = 224;
const MIDDLE_PX: f64 = 0.5 * SIDE_PX as f64;
/// Of a neighbourhood: a bell that spreads as a square of 64 pixels does.
const SIGMA_PX: f64 = 18.5;

/// Frames of a zoom straight onto the plane.
fn frames(plane: &mut Plane, scale: &str, layers: &str, darkness: f64, count: usize) -> Vec<Inked> {
    let style = style(scale, darkness, layers);
    (0..count)
        .map(|i| {
            let distance_m = 900.0 / ZOOM.powi(i as i32);
            plane.shoot(plane.eye(11.0, distance_m, 0.0, 0.0, 30.0), [SIDE_PX; 2], &style)
        })
        .collect()
}

/// The mean of ink about a place, by a bell.
fn about(shot: &Inked, middle: DVec2) -> f64 {
    let reach = (2.5 * SIGMA_PX) as i64;
    let (mut sum, mut weights) = (0.0, 0.0);
    for y in -reach..=reach {
        for x in -reach..=reach {
            let step = DVec2::new(x as f64, y as f64);
            let Some(ink) = shot.between(middle + step) else { continue };
            let weight = (-step.length_squared() / (2.0 * SIGMA_PX * SIGMA_PX)).exp();
            sum += ink * weight;
            weights += weight;
        }
    }
    sum / weights
}

/// The largest change of a neighbourhood's mean from a frame to the next.
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

/// How much of the marks are others in the next frame: the mean difference of ink at places of the ground, blurred as a
/// pen is wide, against what it is between pictures that know nothing of each other.
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

/// Inked pixels whose place on the ground has no ink within 1.5 pixels `step` frames later.
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
                // A dot of one pixel may lie on four: its ink counts, of which
                // samples at pixels' centres find more or less.
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
fn nothing_pops_while_zooming_through_three_octaves() {
    let Some(mut plane) = Plane::new(15.0) else { return };
    let count = (8.0_f64.ln() / ZOOM.ln()).ceil() as usize + 1;
    let mut failed = Vec::new();
    for (scale, marks) in
        [("blend", "line"), ("blend", "stipple"), ("blend", "hachure"), ("add", "line"), ("add", "stipple")]
    {
        let shots = frames(&mut plane, scale, &fixed(marks, 0.0), 0.4, count);
        let largest = largest_pop(&shots);
        let change = largest_change(&shots, 0.4);
        println!("{scale} {marks}: a neighbourhood's mean changes by {largest:.4} at most, {change:.3} of the marks");
        if largest > ALLOWED || change > ALLOWED_CHANGE {
            failed.push(format!("{scale} {marks}: {largest}, {change}"));
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn a_jump_of_half_an_octave_pops() {
    let Some(mut plane) = Plane::new(15.0) else { return };
    let mut shots = frames(&mut plane, "blend", &fixed("line", 0.0), 0.4, 4);
    assert!(largest_pop(&shots) <= ALLOWED && largest_change(&shots, 0.4) <= ALLOWED_CHANGE);
    // A tone that jumps.
    let darker = frames(&mut plane, "blend", &fixed("line", 0.0), 0.43, 1).remove(0);
    assert!(largest_pop(&[frames(&mut plane, "blend", &fixed("line", 0.0), 0.4, 1).remove(0), darker]) > ALLOWED);
    // Marks that do, while the mean of their ink does not.
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
    // A mark that blends is gone after ten frames. By then the ends of a dash have come nearer on the ground by more
    // than its neighbourhood: it is as long on the picture as before.
    let marks = [("line", 0.2, 10), ("line", 0.6, 10), ("dash", 0.3, 1), ("stipple", 0.15, 10), ("stipple", 0.5, 10)];
    for (marks, darkness, step) in marks {
        let shots = frames(&mut plane, "add", &fixed(marks, 20.0), darkness, 150);
        assert_eq!(removed(&shots, step), 0, "{marks} at darkness {darkness}");
        let (first, last) = (shots[0].mean(), shots[149].mean());
        assert!((first - last).abs() < 0.03, "{marks}: ink {first} became {last}");
    }
    // Blending removes marks: the count can be more than nothing. So it is when the camera goes away.
    let blended = frames(&mut plane, "blend", &fixed("stipple", 20.0), 0.15, 40);
    println!("blending removes {} pixels' worth in 30 frames", removed(&blended, 10));
    assert!(removed(&blended, 10) > 20);
}
