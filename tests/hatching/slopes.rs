//! Which layer takes part where: by slope, and by darkness.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use crate::plane::{Inked, Plane, fixed, style};

/// Azimuths of the two layers.
const AZIMUTHS_DEG: [f64; 2] = [20.0, 110.0];
/// The first is on gentle slopes, the second on steep ones.
const BORDER_DEG: f64 = 25.0;

/// Of all changes of ink, the part that lies across marks of the first azimuth, and of the second; each within 15
/// degrees on the picture.
fn parts(plane: &Plane, shot: &Inked) -> [f64; 2] {
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
    let mut whole = 0.0;
    for slope in shot.slopes() {
        whole += slope.length_squared();
        for (sum, along) in sums.iter_mut().zip(on_picture) {
            let off = (slope.to_angle() - along + FRAC_PI_2).rem_euclid(PI);
            if off.min(PI - off) < 15_f64.to_radians() {
                *sum += slope.length_squared();
            }
        }
    }
    sums.map(|sum| sum / whole)
}

fn layers(slopes_deg: [[f64; 2]; 2], from: f64) -> String {
    let [first, second] = AZIMUTHS_DEG.map(|azimuth_deg| fixed("line", azimuth_deg));
    let [a, b] = slopes_deg.map(|slopes_deg| format!("slope_deg = {slopes_deg:?}\n"));
    format!("{first}{a}{second}{b}from = {from}\n")
}

#[test]
fn look() {
    for tilt_deg in [5.0, 20.0, 23.0, 25.0, 27.0, 30.0, 45.0] {
        let Some(mut plane) = Plane::new(tilt_deg) else { return };
        for scale in ["blend", "add"] {
            for darkness in [0.2, 0.4, 0.6] {
                let style = style(scale, darkness, &layers([[0.0, BORDER_DEG], [BORDER_DEG, 90.0]], 0.0));
                let shot = plane.shoot(plane.eye(7.0, 300.0, 20.0, 30.0, 30.0), [256, 192], &style);
                println!("{scale} {tilt_deg} {darkness}: {:.2?}, {:.3?}", parts(&plane, &shot), shot.worst_window(64, darkness));
            }
        }
    }
    let Some(mut plane) = Plane::new(20.0) else { return };
    for scale in ["blend", "add"] {
        for darkness in [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8] {
            let style = style(scale, darkness, &layers([[0.0, 90.0], [0.0, 90.0]], 0.4));
            let shot = plane.shoot(plane.eye(7.0, 300.0, 20.0, 30.0, 30.0), [256, 192], &style);
            println!("cross {scale} {darkness}: {:.2?}, {:.3?}", parts(&plane, &shot), shot.worst_window(64, darkness));
        }
    }
}
