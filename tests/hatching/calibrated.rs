//! The mean grey of a hatched area is the tone that was asked for.

use hachure::style::marks;

use crate::plane::{Inked, Plane, fixed, style};

/// Grey that a square of 64 pixels may be away from the tone that was asked for.
const ALLOWED: f64 = 0.03;

const TONES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

fn worst(shot: &Inked, darkness: f64) -> f64 {
    shot.worst_window(64, darkness)
}

fn of_scale(scale: &str, names: &[&str]) {
    let Some(mut plane) = Plane::new(20.0) else { return };
    for name in names {
        let mut largest: (f64, f64, f64) = (0.0, 0.0, 0.0);
        for darkness in TONES {
            let style = style(scale, darkness, &fixed(name, 33.0));
            for distance_m in [3.0, 43.0, 620.0, 9000.0] {
                let shot = plane.shoot(plane.eye(7.0, distance_m, 35.0, 20.0, 30.0), [256, 256], &style);
                let off = worst(&shot, darkness);
                if off > largest.0 {
                    largest = (off, darkness, distance_m);
                }
            }
        }
        println!("{scale} {name}: {:.4} at darkness {} from {} m", largest.0, largest.1, largest.2);
        assert!(largest.0 <= ALLOWED, "{scale} {name}: {largest:?}");
    }
}

#[test]
fn the_mean_of_blended_marks_is_the_tone() {
    of_scale("blend", &marks::names());
}

#[test]
fn the_mean_of_added_marks_is_the_tone() {
    of_scale("add", &["line", "dash", "hachure", "stipple"]);
}

#[test]
fn the_mean_of_layers_is_the_tone() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    for scale in ["blend", "add"] {
        for darkness in TONES {
            let second = format!("{}from = 0.3\n", fixed("line", 120.0));
            let style = style(scale, darkness, &format!("{}{second}", fixed("line", 30.0)));
            let shot = plane.shoot(plane.eye(7.0, 300.0, 35.0, 20.0, 30.0), [256, 256], &style);
            let off = worst(&shot, darkness);
            assert!(off <= ALLOWED, "{scale}, two layers, darkness {darkness}: {off}");
        }
    }
}

#[test]
fn a_tone_that_is_off_is_seen() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let shot =
        plane.shoot(plane.eye(7.0, 300.0, 35.0, 20.0, 30.0), [256, 256], &style("blend", 0.5, &fixed("line", 30.0)));
    assert!(worst(&shot, 0.5) <= ALLOWED);
    // Ink that bleeds by a sixth of a pixel's worth, as without the calibration between texels; and one dark corner.
    let bled = Inked { ink: shot.ink.iter().map(|ink| (ink * 1.15).min(1.0)).collect(), darkness: Vec::new(), ..shot };
    assert!(worst(&bled, 0.5) > ALLOWED);
    let mut corner = bled;
    corner.ink.iter_mut().for_each(|ink| *ink /= 1.15);
    for y in 0..64 {
        for x in 0..64 {
            let i = y * corner.size_px[0] + x;
            corner.ink[i] = (corner.ink[i] + 0.08).min(1.0);
        }
    }
    assert!(worst(&corner, 0.5) > ALLOWED);
}
