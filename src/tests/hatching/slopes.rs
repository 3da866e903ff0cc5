//! Tests which hatching layer is drawn where, by slope and by darkness.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use crate::tests::common::full;
use crate::tests::hatching::plane::{Inked, Plane, fixed, style};

/// Azimuths of the two layers' marks.
const AZIMUTHS_DEG: [f64; 2] = [20.0, 110.0];
/// The first layer is on slopes below this, the second on steeper ones.
const BORDER_DEG: f64 = 25.0;

/// Returns the second layer's share of the ink that runs in one of the two directions, estimated from the gradient of
/// ink across each direction. A direction counts within 15 degrees in the picture.
fn second(plane: &Plane, shot: &Inked) -> f64 {
    let middle = DVec2::new(shot.size_px[0] as f64, shot.size_px[1] as f64) * 0.5;
    let at_m = plane.hit(&shot.view, middle);
    let on_picture = AZIMUTHS_DEG.map(|azimuth_deg| {
        let to = DVec2::from_angle((90.0 - azimuth_deg).to_radians());
        let normal = plane.normal();
        let along = to.extend(-to.dot(normal.truncate()) / normal.z).normalize();
        let px = shot.view.place_px(at_m + along * 0.1 - shot.view.pose.position_m).unwrap() - middle;
        px.to_angle()
    });
    let mut sums = [0.0; 2];
    for slope in shot.slopes() {
        for (sum, along) in sums.iter_mut().zip(on_picture) {
            let off = (slope.to_angle() - along + FRAC_PI_2).rem_euclid(PI);
            if off.min(PI - off) < 15_f64.to_radians() {
                *sum += slope.length_squared();
            }
        }
    }
    sums[1] / (sums[0] + sums[1])
}

fn layers(slopes_deg: [[f64; 2]; 2], from: f64) -> String {
    let [first, second] = AZIMUTHS_DEG.map(|azimuth_deg| fixed("line", azimuth_deg));
    let [a, b] = slopes_deg.map(|slopes_deg| format!("slope_deg = {slopes_deg:?}\n"));
    format!("{first}{a}{second}{b}from = {from}\n")
}

/// Layers whose marks a picture contains.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Whose {
    First,
    Second,
    Both,
}

fn is_of(second: f64, whose: Whose) -> bool {
    match whose {
        Whose::First => second < 0.08,
        Whose::Second => second > 0.92,
        Whose::Both => (0.15..0.85).contains(&second),
    }
}

/// Allowed difference in grey in soft windows of 64 pixels.
const ALLOWED: f64 = 0.06;

/// Returns the difference in grey, or an error if the picture has another layer's marks or a wrong tone.
fn check(plane: &mut Plane, scale: &str, darkness: f64, layers: &str, whose: Whose) -> Result<f64, String> {
    let pose = plane.eye(7.0, 300.0, 20.0, 30.0, 30.0);
    let shot = plane.shoot(pose, [256, 192], &style(scale, darkness, layers));
    let (second, off) = (second(plane, &shot), shot.worst_window(64, darkness).soft);
    let is_right = is_of(second, whose) && off <= ALLOWED;
    if is_right { Ok(off) } else { Err(format!("{scale} {darkness}: second {second:.3}, grey off by {off:.3}")) }
}

fn darknesses() -> &'static [f64] {
    if full() { &[0.2, 0.4, 0.6] } else { &[0.4] }
}

#[test]
fn layers_are_on_their_slopes() {
    let slopes_deg = [[0.0, BORDER_DEG], [BORDER_DEG, 90.0]];
    let swapped_deg = [slopes_deg[1], slopes_deg[0]];
    let mut most = 0.0_f64;
    let all =
        [(5.0, Whose::First), (20.0, Whose::First), (25.0, Whose::Both), (30.0, Whose::Second), (50.0, Whose::Second)];
    // In the fast tier slopes near the border and in it.
    for (tilt_deg, whose) in all.into_iter().filter(|(tilt_deg, _)| full() || (20.0..=30.0).contains(tilt_deg)) {
        let Some(mut plane) = Plane::new(tilt_deg) else { return };
        for scale in ["blend", "add"] {
            for &darkness in darknesses() {
                let mut of = |slopes_deg| check(&mut plane, scale, darkness, &layers(slopes_deg, 0.0), whose);
                most = most.max(of(slopes_deg).unwrap_or_else(|why| panic!("{tilt_deg} degrees: {why}")));
                // In the middle of the border it makes no difference which layer is which.
                assert!(
                    whose == Whose::Both || of(swapped_deg).is_err(),
                    "{tilt_deg} degrees: swapped layers were not detected"
                );
            }
        }
    }
    println!("grey is off by {most:.3} at most, in the border too");
}

#[test]
fn tone_holds_all_over_the_border() {
    let slopes_deg = [[0.0, BORDER_DEG], [BORDER_DEG, 90.0]];
    for tilt_deg in [22.5, 24.0, 26.0, 27.5].into_iter().step_by(if full() { 1 } else { 2 }) {
        let Some(mut plane) = Plane::new(tilt_deg) else { return };
        for scale in ["blend", "add"] {
            for &darkness in darknesses() {
                let mut off = |darkness: f64, asked: f64| {
                    let pose = plane.eye(7.0, 300.0, 20.0, 30.0, 30.0);
                    let shot = plane.shoot(pose, [256, 192], &style(scale, darkness, &layers(slopes_deg, 0.0)));
                    shot.worst_window(64, asked).soft
                };
                let right = off(darkness, darkness);
                assert!(right <= ALLOWED, "{scale} {darkness} on {tilt_deg} degrees: grey is off by {right}");
                // Planted error: both layers make the whole tone.
                let doubled = 1.0 - (1.0 - darkness) * (1.0 - darkness);
                assert!(
                    off(doubled, darkness) > ALLOWED,
                    "{scale} {darkness} on {tilt_deg} degrees: a doubled tone was not detected"
                );
            }
        }
    }
}

#[test]
fn the_first_layer_does_what_nobody_likes() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    for scale in ["blend", "add"] {
        for &darkness in darknesses() {
            let gap = layers([[0.0, 10.0], [30.0, 90.0]], 0.0);
            check(&mut plane, scale, darkness, &gap, Whose::First).unwrap();
            let swapped = layers([[30.0, 90.0], [0.0, 25.0]], 0.0);
            assert!(check(&mut plane, scale, darkness, &swapped, Whose::First).is_err());
        }
    }
}

#[test]
fn a_second_direction_comes_in_the_darks() {
    let Some(mut plane) = Plane::new(20.0) else { return };
    let everywhere = [[0.0, 90.0]; 2];
    for scale in ["blend", "add"] {
        for (darkness, whose) in
            [(0.1, Whose::First), (0.25, Whose::First), (0.4, Whose::First), (0.8, Whose::Both), (0.9, Whose::Both)]
        {
            check(&mut plane, scale, darkness, &layers(everywhere, 0.4), whose).unwrap();
            // Planted error: a second layer that is drawn in light tones too, or one that never appears.
            let from = if darkness < 0.5 { 0.0 } else { 0.95 };
            let planted = check(&mut plane, scale, darkness, &layers(everywhere, from), whose);
            assert!(planted.is_err(), "{scale} {darkness}: a layer that begins at {from} was not detected");
        }
    }
}
