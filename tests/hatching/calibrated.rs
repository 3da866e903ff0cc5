//! The mean grey of a hatched area is the tone that was asked for.

use hachure::style::marks;

use crate::plane::{Inked, Off, Plane, fixed, style};

/// Grey that an area of 64 pixels should be away from the tone that was asked for, at most.
const GOAL: f64 = 0.03;
/// The same where the area's border is hard and cuts marks: a row of ink more or less.
const ALLOWED_HARD: f64 = 0.07;

/// What is reached where the goal is not: a known shortfall. Rows of marks of two scales, both of which lie in the same
/// direction, do know of each other; and a tile of long marks is itself even within 0.02 only.
const REACHED: [(&str, &str, f64); 11] = [
    ("blend", "line", 0.055),
    ("blend", "dash", 0.045),
    ("blend", "cross", 0.06),
    ("blend", "pencil", 0.055),
    ("blend", "engraving", 0.06),
    ("blend", "halftone", 0.045),
    ("blend", "hachure", 0.045),
    ("blend", "scribble", 0.045),
    ("blend", "dab", 0.04),
    ("add", "dash", 0.08),
    ("add", "", 0.055),
];

fn allowed(scale: &str, marks: &str) -> f64 {
    let known = REACHED.iter().find(|(of, name, _)| *of == scale && (name.is_empty() || *name == marks));
    known.map_or(GOAL, |(_, _, reached)| *reached)
}

const TONES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

fn holds(off: Off, soft: f64) -> bool {
    off.soft <= soft && off.hard <= ALLOWED_HARD.max(soft)
}

fn of_scale(scale: &str, names: &[&str]) {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let mut failed = Vec::new();
    for name in names {
        let (mut soft, mut hard) = ((0.0, 0.0, 0.0), 0.0_f64);
        for darkness in TONES {
            let style = style(scale, darkness, &fixed(name, 33.0));
            for distance_m in [3.0, 43.0, 620.0, 9000.0] {
                let shot = plane.shoot(plane.eye(7.0, distance_m, 35.0, 20.0, 30.0), [256, 256], &style);
                let off = shot.worst_window(64, darkness);
                if off.soft > soft.0 {
                    soft = (off.soft, darkness, distance_m);
                }
                hard = hard.max(off.hard);
                if !holds(off, allowed(scale, name)) {
                    failed.push(format!("{scale} {name}, darkness {darkness} from {distance_m} m: {off:?}"));
                }
            }
        }
        println!("{scale} {name}: {:.4} at darkness {} from {} m; hard {hard:.4}", soft.0, soft.1, soft.2);
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
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
            let off = shot.worst_window(64, darkness);
            assert!(holds(off, 0.04), "{scale}, two layers, darkness {darkness}: {off:?}");
        }
    }
}

#[test]
fn a_tone_that_is_off_is_seen() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let shot =
        plane.shoot(plane.eye(7.0, 300.0, 35.0, 20.0, 30.0), [256, 256], &style("blend", 0.5, &fixed("stipple", 30.0)));
    assert!(holds(shot.worst_window(64, 0.5), GOAL));
    // Ink that bleeds by a sixth of a pixel's worth, as without the calibration between texels; and one dark corner.
    let bled = Inked { ink: shot.ink.iter().map(|ink| (ink * 1.15).min(1.0)).collect(), ..shot };
    assert!(!holds(bled.worst_window(64, 0.5), 0.05));
    let mut corner = bled;
    corner.ink.iter_mut().for_each(|ink| *ink /= 1.15);
    for y in 0..100 {
        for x in 0..100 {
            let i = y * corner.size_px[0] + x;
            corner.ink[i] = (corner.ink[i] + 0.16).min(1.0);
        }
    }
    assert!(!holds(corner.worst_window(64, 0.5), 0.05));
}
