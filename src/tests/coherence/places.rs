//! Positions of samples: on the world, evenly along their strokes, and offset by as much as the wobble of the hand
//! allows.

use std::collections::HashMap;

use glam::{DVec2, Vec2, Vec3};
use hachure::lines::strokes::samples::{Sample, SampleCounts};
use hachure::style;

use crate::tests::coherence::checks::{evenly_apart, in_strokes, where_they_say};
use crate::tests::coherence::{Flight, SIZE_PX, mountains, strokes};
use crate::tests::common::draw::places_m;
use crate::tests::common::full;

#[test]
fn between_updates_strokes_stick_to_the_world() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|_| {}));
    let (first, counts, samples) = flight.fly(&mut world, 0);
    assert!(counts.samples > 250 && counts.samples as usize == samples.len());
    for frame in 1..4 {
        let (view, now, moved) = flight.fly(&mut world, frame);
        assert_eq!(now, counts, "an update came between the frames");
        let step_m = first.pose.position_m - view.pose.position_m;
        let far_px = |there: &dyn Fn(&Sample) -> DVec2| {
            let pairs = samples.iter().zip(&moved);
            pairs.map(|(old, new)| (there(old) - Vec2::from(new.px).as_dvec2()).length()).fold(0.0, f64::max)
        };
        // Nothing holds the lines of a first frame.
        let with_world = |old: &Sample| view.place_px(Vec3::from(old.position_m).as_dvec3() + step_m).unwrap();
        assert!(far_px(&with_world) < 0.05, "{}", far_px(&with_world));
        // Planted error: samples that stick to the picture.
        assert!(far_px(&|old| Vec2::from(old.px).as_dvec2()) > 0.4);
    }
}

#[test]
fn samples_are_where_they_say_and_evenly_apart() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|_| {}));
    for frame in 0..if full() { 12 } else { 6 } {
        let (view, counts, samples) = flight.fly(&mut world, frame);
        assert!(counts.strokes > 0);
        assert_eq!(where_they_say(&view, &samples), Ok(()), "frame {frame}");
        assert_eq!(in_strokes(&counts, &samples), Ok(()), "frame {frame}");
        assert_eq!(evenly_apart(&samples), Ok(()), "frame {frame}");
    }
}

#[test]
fn samples_that_are_elsewhere_or_unevenly_apart_are_found() {
    let Some(mut world) = mountains() else { return };
    let (view, counts, samples) = Flight::new(&world, strokes(|_| {})).fly(&mut world, 0);
    // In the middle of a stroke.
    let is_inside = |own: &Sample| own.flags & (Sample::FIRST | Sample::LAST) == 0;
    let at = samples.windows(3).position(|three| three.iter().all(is_inside)).unwrap() + 1;
    let named = format!("sample {at} ");
    let spoiled = |spoil: &dyn Fn(&mut [Sample])| {
        let mut spoiled = samples.clone();
        spoil(&mut spoiled);
        spoiled
    };
    let moved = spoiled(&|all| all[at].px[1] += 0.2);
    let error = where_they_say(&view, &moved).unwrap_err();
    assert!(error.starts_with(&named), "{error}");
    // A gap of 6 px, and two samples at one point; the rest of the stroke keeps its shape.
    let (here, way) = (Vec2::from(samples[at].px), Vec2::from(samples[at + 1].px) - Vec2::from(samples[at].px));
    let [gap, coinciding] = [6.0, 0.0].map(|apart_px| {
        let by = here + way.normalize() * apart_px - Vec2::from(samples[at + 1].px);
        spoiled(&|all| all[at + 1..].iter_mut().for_each(|own| own.px = (Vec2::from(own.px) + by).to_array()))
    });
    for (wrong, expected) in [(gap, "6.00 px"), (coinciding, "0.00 px")] {
        let error = evenly_apart(&wrong).unwrap_err();
        assert!(error.starts_with(&named) && error.contains(expected), "{error}");
    }
    // A stroke that does not end, and a count with more strokes than there are.
    let endless = spoiled(&|all| {
        let last = (at..).find(|i| all[*i].flags & Sample::LAST != 0).unwrap();
        all[last].flags &= !Sample::LAST;
    });
    let error = in_strokes(&counts, &endless).unwrap_err();
    assert!(error.contains("begins within a stroke"), "{error}");
    let more = SampleCounts { strokes: samples.len() as u32, ..counts };
    assert!(in_strokes(&more, &samples).unwrap_err().contains("strokes"));
}

#[test]
fn hands_stray_and_pens_widen_at_bends() {
    let Some(mut world) = mountains() else { return };
    let mut drawn = |change: fn(&mut style::Strokes)| {
        let mut flight = Flight::new(&world, strokes(change));
        flight.fly(&mut world, 0).2
    };
    let plain = drawn(|_| {});
    let apart = |samples: &[Sample]| -> Vec<f32> {
        let nearest = |own: &Sample| {
            plain.iter().map(|it| Vec2::from(it.px).distance(Vec2::from(own.px))).fold(f32::INFINITY, f32::min)
        };
        samples.iter().map(nearest).collect()
    };
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    let strayed = apart(&drawn(|own| own.wobble_px = 4.0));
    // The bound is the amplitude of two octaves plus half of the distance between samples.
    assert!(strayed.iter().all(|apart| *apart < 4.0 * 1.5 + 2.0), "{:?}", strayed.iter().copied().reduce(f32::max));
    assert!(mean(&strayed) > 0.6, "{}", mean(&strayed));
    // A repetition gives the same result: the wobble depends on the position alone.
    if full() {
        let again = apart(&drawn(|own| own.wobble_px = 4.0));
        assert!((mean(&strayed) - mean(&again)).abs() < 1e-3);
    }
    // Planted error: a hand without wobble.
    assert!(mean(&apart(&drawn(|_| {}))) < 0.01);

    let widths = |samples: &[Sample]| mean(&samples.iter().map(|own| own.half_width_px).collect::<Vec<_>>());
    let (wider, thinner) = (drawn(|own| own.curve_width = 1.0), drawn(|own| own.curve_width = -1.0));
    assert!(widths(&wider) > 1.01 * widths(&plain) && widths(&thinner) < 0.99 * widths(&plain));
    // Straight parts keep their width, and most samples are on straight parts.
    let same =
        wider.iter().filter(|own| plain.iter().any(|it| (it.half_width_px / own.half_width_px - 1.0).abs() < 0.01));
    assert!(same.count() > wider.len() / 2);
}

#[test]
fn strokes_have_the_width_of_the_step_behind_them() {
    let Some(mut world) = mountains() else { return };
    let style = strokes(|own| {
        (own.interior_width, own.occluding_width) = (0.33, 0.67);
        (own.depth_width, own.width_px) = (0.0, 4.0);
    });
    let mut flight = Flight::new(&world, style);
    let (view, _, samples) = flight.fly(&mut world, 0);
    let places = places_m(&world.gpu, &flight.renderer, view.pose.position_m);
    // Returns the nearness (1 / depth in metres) at a pixel; the sky has 0.
    let nearness = |px: Vec2| {
        let pixel = px.floor().clamp(Vec2::ZERO, Vec2::from(SIZE_PX.map(|side| side as f32 - 1.0))).as_uvec2();
        let place = places[(pixel.y * SIZE_PX[0] + pixel.x) as usize];
        place.map_or(0.0, |place| 1.0 / (place - view.pose.position_m).dot(view.pose.forward))
    };
    // Returns the step behind a line. Both sides are extrapolated to the line, so that oblique slopes are no steps.
    let step = |px: Vec2, toward: Vec2| {
        let sides = [1.0, -1.0].map(|side| {
            let [beside, farther] = [3.0, 6.0].map(|apart_px| nearness(px + side * apart_px * toward));
            beside + (beside - farther).clamp(-0.25 * beside, 0.25 * beside)
        });
        1.0 - sides[0].min(sides[1]) / sides[0].max(sides[1]).max(1e-12)
    };
    let width = |step: f64| {
        let part = ((step - 0.12) / 0.12).clamp(0.0, 1.0);
        let hiding = 0.33 + 0.34 * part * part * (3.0 - 2.0 * part);
        hiding + (1.0 - hiding) * ((step - 0.3) / 0.6).clamp(0.0, 1.0)
    };
    // The mean step behind each stroke. With a small one it may be a fold of a slope, which has 0.7 of the width of lines
    // within slopes; a sample does not know whether another line continues its stroke.
    let mut steps: HashMap<u32, (f64, f64)> = HashMap::new();
    for own in samples.windows(2).filter(|own| own[0].stroke == own[1].stroke && own[0].px != own[1].px) {
        let [a, b] = [Vec2::from(own[0].px), Vec2::from(own[1].px)];
        let (sum, count) = steps.entry(own[0].stroke).or_default();
        *sum += step(a, (b - a).normalize().perp());
        *count += 1.0;
    }
    let folded = |stroke: u32| {
        let mean = steps.get(&stroke).map_or(1.0, |(sum, count)| sum / count);
        let part = ((mean - 0.15) / 0.15).clamp(0.0, 1.0);
        1.0 - part * part * (3.0 - 2.0 * part)
    };
    // Measures how far widths are from those expected of the depth steps along direction `turn` of the stroke, in the
    // mean of seven places 8 px apart: the median error, and the fraction of samples that are wrong.
    let misses = |turn: fn(Vec2) -> Vec2| {
        let inner = samples.windows(33).filter(|own| own.iter().all(|it| it.stroke == own[0].stroke));
        let mut misses: Vec<f64> = inner
            .map(|own| {
                let px = |i: usize| Vec2::from(own[i].px);
                let places = (1..8).map(|i| step(px(4 * i), turn((px(4 * i + 4) - px(4 * i - 4)).normalize())));
                let expected = places.map(width).sum::<f64>() / 7.0;
                let of_fold = expected.min(0.7 * 0.33);
                let of_fold = expected + (of_fold - expected) * folded(own[0].stroke);
                let drawn = f64::from(own[16].half_width_px) / 2.0;
                (drawn - expected).abs().min((drawn - of_fold).abs())
            })
            .collect();
        misses.sort_by(f64::total_cmp);
        assert!(misses.len() > 100, "{}", misses.len());
        (misses[misses.len() / 2], misses.iter().filter(|miss| **miss > 0.15).count() as f64 / misses.len() as f64)
    };
    let (median, wrong) = misses(Vec2::perp);
    assert!(median < 0.02 && wrong < 0.1, "{median} {wrong}");
    // Planted error: steps measured along strokes instead of across them.
    let (median, wrong) = misses(|way| way);
    assert!(median > 0.1 || wrong > 0.3, "{median} {wrong}");
    let widths: Vec<f32> = samples.iter().map(|own| own.half_width_px).collect();
    let thinnest = widths.iter().copied().fold(f32::INFINITY, f32::min);
    let widest = widths.iter().copied().fold(0.0, f32::max);
    assert!(thinnest < 1.0 && widest > 1.99, "{thinnest} to {widest}");
}
