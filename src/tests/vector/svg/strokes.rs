//! Tests that strokes can be read back as they were drawn.

use hachure::lines::strokes::polylines::Polyline;

use super::{Drawn, HILL, SIZE_PX, hill, strokes_of};
use crate::tests::common::{World, grid_of, rough_height_m};

/// Returns the part of the pixels with ink whose stroke passes nearby.
fn owned(drawn: &Drawn, number: impl Fn(u32) -> u32) -> f64 {
    let [width, height] = SIZE_PX;
    let (mut all, mut found) = (0_u32, 0_u32);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let id = drawn.ids[(y * width + x) as usize];
        if id == 0 {
            continue;
        }
        all += 1;
        let own = drawn.polylines.iter().find(|line| line.stroke == number(id));
        let near = |line: &Polyline| {
            // Points are at most 4 px apart.
            line.points
                .iter()
                .any(|at| (at.px[0] - x as f32 - 0.5).hypot(at.px[1] - y as f32 - 0.5) < at.half_width_px + 3.0)
        };
        found += u32::from(own.is_some_and(near));
    }
    f64::from(found) / f64::from(all)
}

#[test]
fn strokes_are_read_back_with_their_numbers() {
    let Some(mut world) = hill() else { return };
    let drawn = strokes_of(&mut world, HILL, |_| {});
    assert!(owned(&drawn, |number| number) > 0.999, "{}", owned(&drawn, |number| number));
    assert!(owned(&drawn, |number| number.wrapping_add(1)) < 0.9, "planted: the number of the next stroke");
    for line in &drawn.polylines {
        assert!(line.points.len() >= 2);
        assert!(line.points.iter().all(|at| at.half_width_px >= 0.4 && (0.0..=1.0).contains(&at.ink)));
    }
}

/// Tests that shorter strokes than the style draws are not read either; pieces of the skyline may be shorter.
#[test]
fn short_strokes_are_not_read_back() {
    let Some(mut world) = World::new(grid_of(257, 257, 60.0, rough_height_m), 1.0) else { return };
    let mut short = |least_px: f32| {
        let drawn = strokes_of(&mut world, "0,-4000,+900,0,-20,50", |strokes| strokes.shortest_px = least_px);
        let length = |line: &Polyline| {
            let step = |pair: &[hachure::lines::strokes::polylines::PolylinePoint]| {
                (pair[1].px[0] - pair[0].px[0]).hypot(pair[1].px[1] - pair[0].px[1])
            };
            line.points.windows(2).map(step).sum::<f32>()
        };
        let all = drawn.polylines.len();
        (drawn.polylines.iter().filter(|line| length(line) < 59.0).count(), all)
    };
    let ((all, _), (left, long)) = (short(4.0), short(60.0));
    println!("{all} strokes shorter than 60 px, {left} with that limit, and {long} in all");
    assert!(all > 10 && long > 0 && 10 * left <= all, "{all}, {left}, {long}");
}

#[test]
fn ink_is_read_back_as_it_is_drawn() {
    let Some(mut world) = hill() else { return };
    let drawn = strokes_of(&mut world, HILL, |strokes| {
        // Strokes so wide that the pixel at a point is fully covered, and hazy.
        (strokes.width_px, strokes.taper_px, strokes.depth_width, strokes.reach) = (8.0, 0.0, 0.0, 0.06);
    });
    let [width, height] = SIZE_PX;
    let agree = |change: &dyn Fn(f32) -> f32| {
        let (mut all, mut found, mut lightest, mut darkest) = (0_u32, 0_u32, 1.0_f32, 0.0_f32);
        for (line, at) in drawn.polylines.iter().flat_map(|line| line.points.iter().map(move |at| (line, at))) {
            let [x, y] = at.px;
            if x < 0.0 || y < 0.0 || x >= width as f32 || y >= height as f32 {
                continue;
            }
            let pixel = (y as u32 * width + x as u32) as usize;
            if drawn.ids[pixel] == line.stroke {
                all += 1;
                found += u32::from((drawn.ink[pixel] - change(at.ink)).abs() < 0.03);
                (lightest, darkest) = (lightest.min(at.ink), darkest.max(at.ink));
            }
        }
        assert!(all > 100 && darkest - lightest > 0.2, "{all} points from {lightest} to {darkest}");
        f64::from(found) / f64::from(all)
    };
    println!("{:.3} of the points have the picture's ink", agree(&|ink| ink));
    // Where strokes cross, the darker ink stays, whichever stroke the number belongs to.
    assert!(agree(&|ink| ink) > 0.9);
    assert!(agree(&|ink| ink * 0.9) < 0.5, "planted: too faint");
}
