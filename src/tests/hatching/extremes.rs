//! Tests hatching at the ends of its ranges: white stays white and black stays black, every number is finite, and moiré
//! is no worse than in a band-limited picture.

use crate::tests::common::{World, full, grid_of};
use crate::tests::hatching::plane::{Inked, Plane, fixed, shoot, style};

fn all_within(shot: &Inked) -> Result<(), String> {
    let wrong = shot.ink.iter().position(|ink| !(-1e-6..=1.0 + 1e-6).contains(ink));
    wrong.map_or(Ok(()), |i| Err(format!("pixel {i} has ink {}", shot.ink[i])))
}

#[test]
fn white_stays_white_and_black_stays_black() {
    let Some(mut plane) = Plane::new(25.0) else { return };
    let names = if full() { hachure::style::marks::names() } else { vec!["line", "hachure", "stipple"] };
    for scale in ["blend", "add"] {
        for marks in &names {
            for (darkness, wanted) in [(0.0, 0.0), (1.0, 1.0)] {
                for distance_m in [5.0, 7000.0] {
                    let pose = plane.eye(0.0, distance_m, 60.0, 30.0, 40.0);
                    let shot = plane.shoot(pose, [96, 96], &style(scale, darkness, &fixed(marks, 10.0)));
                    let off = shot.ink.iter().position(|ink| (ink - wanted).abs() > 1e-6);
                    assert_eq!(
                        off, None,
                        "{scale} {marks}, {darkness} from {distance_m} m: a pixel whose ink is not {wanted}"
                    );
                }
            }
        }
    }
}

#[test]
fn everything_is_finite_at_the_extremes() {
    // A step of 900 m between two samples, and a plain.
    let grid = grid_of(129, 129, 30.0, |x, _| if x > 0.0 { 900.0 } else { 0.0 });
    let Some(mut world) = World::new(grid, 1.0) else { return };
    let mut renderer = None;
    let layers = ["fixed", "slope", "contour", "sight"]
        .map(|direction| format!("[[hatching.layers]]\nmarks = \"line\"\ndirection = \"{direction}\"\nfrom = 0.2\n"));
    for scale in ["blend", "add"] {
        let style = style(scale, 0.5, &layers.concat());
        for camera in [
            "-300,0,+0.1,90,0,60",
            "-300,0,+0.1,90,-89,60",
            "-1500,0,500,90,-5,1",
            "-1500,0,500,90,-5,150",
            "0,0,1000000,0,-90,1",
            "0,0,1000000,0,-90,60",
            "-5,0,450,90,0,90",
        ] {
            let pose = world.pose(camera);
            let shot = shoot(&mut world, &mut renderer, pose, [160, 90], &style);
            all_within(&shot).unwrap_or_else(|why| panic!("{scale} {camera}: {why}"));
        }
    }
    let Some(mut world) = World::new(grid_of(2, 2, 30.0, |_, _| 5.0), 1.0) else { return };
    let pose = world.pose("0,0,30,0,-90,60");
    shoot(&mut world, &mut None, pose, [64, 64], &style("blend", 0.5, &layers.concat()));
}

#[test]
fn a_number_that_is_not_finite_is_seen() {
    let Some(mut plane) = Plane::new(25.0) else { return };
    let mut shot =
        plane.shoot(plane.eye(0.0, 50.0, 30.0, 0.0, 40.0), [64, 64], &style("add", 0.5, &fixed("line", 0.0)));
    all_within(&shot).unwrap();
    shot.ink[77] = f64::NAN;
    assert!(all_within(&shot).unwrap_err().contains("77"));
    shot.ink[77] = 1.5;
    assert!(all_within(&shot).is_err());
}

/// Returns the standard deviation of means over squares of `side` pixels. It measures waves that are much longer than
/// the spacing of marks; an even tone has none.
fn slow_waves(shot: &Inked, side: usize) -> f64 {
    let [width, height] = shot.size_px;
    let mut means = Vec::new();
    for y in (0..=height - side).step_by(side) {
        for x in (0..=width - side).step_by(side) {
            let sum: f64 =
                (y..y + side).flat_map(|y| (x..x + side).map(move |x| (x, y))).map(|(x, y)| shot.at(x, y)).sum();
            means.push(sum / (side * side) as f64);
        }
    }
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    (means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / means.len() as f64).sqrt()
}

#[test]
fn no_moire_beyond_the_band_limited_reference() {
    let Some(mut plane) = Plane::new(10.0) else { return };
    let mut failed = Vec::new();
    let angles_deg: &[f64] = if full() { &[20.0, 80.0] } else { &[80.0] };
    for scale in ["blend", "add"] {
        // The smallest marks that a style can have: their spacing is a pixel or two.
        let all = [("line", 0.25), ("stipple", 0.25), ("line", 1.0)];
        for (marks, size) in all.into_iter().take(if full() { all.len() } else { 1 }) {
            let layers = |size: f64| format!("{}size = {size}\n", fixed(marks, 31.0));
            for &from_normal_deg in angles_deg {
                let pose = plane.eye(2.0, 500.0, from_normal_deg, 25.0, 30.0);
                let shot = plane.shoot(pose, [192, 192], &style(scale, 0.4, &layers(size)));
                // Reference: the same marks at four times the size and four times the resolution, averaged, which is 16
                // samples per pixel.
                let fine = plane.shoot(pose, [768, 768], &style(scale, 0.4, &layers(size * 4.0)));
                let reference = Inked {
                    size_px: [192, 192],
                    ink: (0..192 * 192)
                        .map(|i| {
                            let (x, y) = (i % 192 * 4, i / 192 * 4);
                            (0..16).map(|k| fine.at(x + k % 4, y + k / 4)).sum::<f64>() / 16.0
                        })
                        .collect(),
                    view: shot.view,
                    place_m: Vec::new(),
                    patch: Vec::new(),
                };
                let (own, limited) = (slow_waves(&shot, 16), slow_waves(&reference, 16));
                println!("{scale} {marks} × {size} at {from_normal_deg}°: slow waves {own:.4}, reference {limited:.4}");
                if own > limited + 0.01 {
                    failed.push(format!("{scale} {marks} × {size} at {from_normal_deg}°: {own}, reference {limited}"));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn a_moire_is_seen() {
    let Some(mut plane) = Plane::new(10.0) else { return };
    let mut shot =
        plane.shoot(plane.eye(2.0, 500.0, 20.0, 25.0, 30.0), [192, 192], &style("blend", 0.4, &fixed("line", 31.0)));
    let before = slow_waves(&shot, 16);
    for (i, ink) in shot.ink.iter_mut().enumerate() {
        *ink = (*ink + 0.1 * (std::f64::consts::TAU * (i % 192) as f64 / 60.0).sin()).clamp(0.0, 1.0);
    }
    assert!(slow_waves(&shot, 16) > before + 0.01);
}
