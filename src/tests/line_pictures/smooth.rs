//! Tests the anti-aliasing of lines against a CPU twin, and tests its purpose.

use glam::DVec3;
use hachure::lines::smooth::{self, SMOOTHED};
use hachure::lines::threshold::LINE;

use crate::tests::line_pictures::{Bench, SIZE_PX, chance, inside, off, places, view};

fn smoothed(bench: &mut Bench, line: &[f32]) -> Vec<f64> {
    let picture = bench.picture(&LINE, SIZE_PX, line);
    let out = bench.out(&SMOOTHED);
    bench.run(|recorder| {
        let view = &recorder.uniform("view", &view().uniform(DVec3::ZERO));
        smooth::run(recorder, &smooth::Inputs { view, line: &picture, smoothed: &out });
    });
    bench.floats(&out)
}

/// The CPU twin: the average along the direction in which the structure tensor of 3 × 3 pixels changes least, for
/// pixels with more ink within 5 × 5 than a speck has.
fn twin(line: &[f32], speck: [f64; 2]) -> Vec<f64> {
    let load = |x: i64, y: i64| f64::from(line[inside(x, y)]);
    let bilinear = |x: f64, y: f64| {
        let (i, j) = (x.floor(), y.floor());
        let (f, g) = (x - i, y - j);
        let at = |dx: i64, dy: i64| load(i as i64 + dx, j as i64 + dy);
        (at(0, 0) * (1.0 - f) + at(1, 0) * f) * (1.0 - g) + (at(0, 1) * (1.0 - f) + at(1, 1) * f) * g
    };
    let value = |(x, y): (i64, i64)| {
        let square = |reach: i64| (-reach..=reach).flat_map(move |j| (-reach..=reach).map(move |i| (x + i, y + j)));
        if square(1).map(|(i, j)| load(i, j)).sum::<f64>() <= 0.0 {
            return 0.0;
        }
        let ink: f64 = square(2).map(|(i, j)| load(i, j)).sum();
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for (i, j) in square(1) {
            let (dx, dy) = (load(i + 1, j) - load(i - 1, j), load(i, j + 1) - load(i, j - 1));
            (xx, yy, xy) = (xx + dx * dx, yy + dy * dy, xy + dx * dy);
        }
        let difference = (xx - yy).hypot(2.0 * xy);
        let coherence = difference / f64::max(xx + yy, 1e-6);
        let angle = 0.5 * f64::atan2(2.0 * xy, xx - yy) + std::f64::consts::FRAC_PI_2;
        let (way_x, way_y) = (angle.cos() * coherence, angle.sin() * coherence);
        let pair = |far: f64| {
            let [x, y] = [x as f64, y as f64];
            bilinear(x + far * way_x, y + far * way_y) + bilinear(x - far * way_x, y - far * way_y)
        };
        let sum = 0.3 * load(x, y) + 0.2 * pair(1.0) + 0.15 * pair(2.2);
        let t = ((ink - speck[0]) / (speck[1] - speck[0])).clamp(0.0, 1.0);
        (1.25 * sum).min(1.0) * t * t * (3.0 - 2.0 * t)
    };
    places().map(value).collect()
}

/// Returns a line from left to right that rises by `slope`, with hard edges as the threshold makes them.
fn stairs(slope: f64) -> Vec<f32> {
    let is_on = |(x, y): (i64, i64)| (y as f64 - 30.0 + slope * x as f64).abs() < 0.75;
    places().map(|place| f32::from(u8::from(is_on(place)))).collect()
}

#[test]
fn smoothing_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    let noise: Vec<f32> = places()
        .map(|(x, y)| {
            let line = f64::from(u8::from((x + 2 * y) % 19 < 2 || (3 * x - y).rem_euclid(23) == 0));
            (line * (0.3 + 0.7 * chance(x, y, 3))) as f32
        })
        .collect();
    let found = smoothed(&mut bench, &noise);
    // Where the tensor has nearly no direction, rounding chooses one, but the average hardly follows it.
    assert!(off(&found, &twin(&noise, [2.0, 4.5]), 2e-3) <= 5);
    // Planted: specks are not removed.
    assert!(off(&found, &twin(&noise, [0.0, 0.1]), 2e-3) > 100);
}

#[test]
fn smoothing_makes_slopes_of_stairs_and_takes_specks() {
    let Some(mut bench) = Bench::new() else { return };
    for slope in [0.08, 0.3] {
        let line = stairs(slope);
        let found = smoothed(&mut bench, &line);
        // Computes the middle of the line's ink in each column, and its standard deviation from a straight line.
        let roughness = |values: &dyn Fn(usize) -> f64| {
            let [width, height] = SIZE_PX.map(i64::from);
            let middles = (8..width - 8).map(|x| {
                let (mut ink, mut sum) = (0.0, 0.0);
                for y in 0..height {
                    let value = values(inside(x, y));
                    (ink, sum) = (ink + value, sum + value * y as f64);
                }
                sum / ink - (30.0 - slope * x as f64)
            });
            let middles: Vec<f64> = middles.collect();
            let mean = middles.iter().sum::<f64>() / middles.len() as f64;
            (middles.iter().map(|middle| (middle - mean).powi(2)).sum::<f64>() / middles.len() as f64).sqrt()
        };
        let (before, after) = (roughness(&|i| f64::from(line[i])), roughness(&|i| found[i]));
        let (ink_before, ink_after) = (line.iter().sum::<f32>(), found.iter().sum::<f64>());
        println!("slope {slope}: {before:.3} px rough, then {after:.3}; ink {ink_before} and {ink_after:.0}");
        assert!(after < 0.85 * before, "{before} {after}");
        assert!((0.8..1.25).contains(&(ink_after / f64::from(ink_before))), "smoothing must keep the width");
    }
    // A speck of two pixels must disappear.
    let speck: Vec<f32> = places().map(|(x, y)| f32::from(u8::from(y == 20 && (x == 20 || x == 21)))).collect();
    assert!(smoothed(&mut bench, &speck).iter().all(|value| *value < 1e-6));
}
