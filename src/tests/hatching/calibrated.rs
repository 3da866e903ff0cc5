//! Tests that the mean grey of a hatched area is the requested tone.

use hachure::style::{Style, marks};

use crate::tests::common::full;
use crate::tests::hatching::plane::{Inked, Off, Plane, fixed, style};

/// Largest allowed difference in grey between an area of 64 × 64 pixels and the requested tone.
const GOAL: f64 = 0.03;

fn tones() -> &'static [f64] {
    if full() { &[0.1, 0.3, 0.5, 0.7, 0.9] } else { &[0.1, 0.5, 0.9] }
}

/// Returns whether the tone is near enough both in windows with soft borders and in windows with hard borders, which
/// cut marks.
fn holds(off: Off) -> bool {
    off.soft <= GOAL && off.hard <= GOAL
}

fn of_scale(scale: &str, names: &[&str]) {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let mut failed = Vec::new();
    let distances_m: &[f64] = if full() { &[3.0, 43.0, 620.0, 9000.0] } else { &[3.0, 620.0] };
    for name in names {
        let (mut soft, mut hard) = ((0.0, 0.0, 0.0), 0.0_f64);
        for &darkness in tones() {
            let style = style(scale, darkness, &fixed(name, 33.0));
            for distance_m in distances_m {
                let shot = plane.shoot(plane.eye(7.0, *distance_m, 35.0, 20.0, 30.0), [256, 256], &style);
                let off = shot.worst_window(64, darkness);
                if off.soft > soft.0 {
                    soft = (off.soft, darkness, *distance_m);
                }
                hard = hard.max(off.hard);
                if !holds(off) {
                    failed.push(format!(
                        "{scale} {name}, {darkness} from {distance_m} m: off by {off:?}, allowed {GOAL}"
                    ));
                }
            }
        }
        println!("{scale} {name}: {:.4} at darkness {} from {} m; hard {hard:.4}", soft.0, soft.1, soft.2);
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn the_mean_of_blended_marks_is_the_tone() {
    // In the fast tier only marks that other tests need too, because it takes long to make marks.
    of_scale("blend", &if full() { marks::names() } else { vec!["line", "hachure", "stipple", "cross"] });
}

#[test]
fn the_mean_of_added_marks_is_the_tone() {
    let names = ["line", "stipple", "dash", "hachure"];
    of_scale("add", if full() { &names } else { &names[..2] });
}

#[test]
fn the_mean_of_layers_is_the_tone() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    for scale in ["blend", "add"] {
        for &darkness in tones() {
            let second = format!("{}from = 0.3\n", fixed("line", 120.0));
            let style = style(scale, darkness, &format!("{}{second}", fixed("line", 30.0)));
            let shot = plane.shoot(plane.eye(7.0, 300.0, 35.0, 20.0, 30.0), [256, 256], &style);
            let off = shot.worst_window(64, darkness);
            assert!(holds(off), "{scale}, two layers, darkness {darkness}: tone is off by {off:?}, allowed {GOAL}");
        }
    }
}

#[test]
fn a_tone_that_is_off_is_seen() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let shot =
        plane.shoot(plane.eye(7.0, 300.0, 35.0, 20.0, 30.0), [256, 256], &style("blend", 0.5, &fixed("stipple", 30.0)));
    assert!(holds(shot.worst_window(64, 0.5)));
    // Planted errors: ink that bleeds by a twelfth of the white part, then one dark corner.
    let bled = |ink: f64| ink + (1.0 - ink) / 12.0;
    let mut wrong = Inked { ink: shot.ink.iter().map(|ink| bled(*ink)).collect(), ..shot };
    assert!(!holds(wrong.worst_window(64, 0.5)));
    wrong.ink.iter_mut().for_each(|ink| *ink = (*ink - 1.0 / 12.0) * 12.0 / 11.0);
    assert!(holds(wrong.worst_window(64, 0.5)));
    for y in 0..100 {
        for x in 0..100 {
            let i = y * wrong.size_px[0] + x;
            wrong.ink[i] = bled(wrong.ink[i]);
        }
    }
    assert!(!holds(wrong.worst_window(64, 0.5)));
}

#[test]
fn marks_that_are_not_balanced_are_not_even() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let (balanced, mut bare) = (style("blend", 0.5, &fixed("cross", 33.0)), style("blend", 0.5, &fixed("cross", 33.0)));
    bare.hatching_mut().unwrap().balance = false;
    let mut off =
        |style: &Style| plane.shoot(plane.eye(7.0, 9000.0, 35.0, 20.0, 30.0), [256, 256], style).worst_window(64, 0.5);
    let (balanced, bare) = (off(&balanced), off(&bare));
    println!("hard borders: off by {:.4} balanced, {:.4} as the maps say", balanced.hard, bare.hard);
    assert!(holds(balanced) && !holds(bare));
}

#[test]
fn a_share_of_the_darkness_is_drawn() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let mut shoot = |share: f32| {
        let mut style = style("blend", 0.8, &fixed("line", 33.0));
        style.hatching_mut().unwrap().share = share;
        plane.shoot(plane.eye(7.0, 300.0, 35.0, 20.0, 30.0), [256, 256], &style)
    };
    let half = shoot(0.5);
    assert!(holds(half.worst_window(64, 0.4)));
    assert!(!holds(half.worst_window(64, 0.8)), "the whole darkness would be found");
    assert!(shoot(0.0).ink.iter().all(|ink| *ink == 0.0));
}
