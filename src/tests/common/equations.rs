//! Zaidi et al., Eqs. 1 to 8, in f64 and on the exported positions and normals: the reference for the shader.
//!
//! Eq. 6 is read as its text has it: the checked pixel is in the numerator, and the opposite control pixel in the
//! denominator. The least and the greatest value on the arc of normals come from the phase of the cosine along the arc.

use glam::DVec3;

use super::shot::Shot;

/// How Eq. 6 is read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reading {
    /// The checked pixel in the numerator, its control in the denominator.
    Text,
    /// The reverse: a planted error.
    Swapped,
}

/// Returns the least and greatest |N · d| for N on the great circle from `a` to `b`.
fn arc(a: DVec3, b: DVec3, d: DVec3) -> (f64, f64) {
    let (a, b) = (a.normalize(), b.normalize());
    let omega = a.cross(b).length().atan2(a.dot(b));
    let ends = [a.dot(d).abs(), b.dot(d).abs()];
    let (mut least, mut greatest) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    if omega > 1e-9 {
        // N(t) = a cos t + e sin t, so N(t) · d = amplitude · cos(t − phase).
        let e = (b - a * a.dot(b)).normalize();
        let (along, across) = (a.dot(d), e.dot(d));
        let (amplitude, phase) = (along.hypot(across), across.atan2(along));
        let inside = |t: f64| t > 0.0 && t < omega;
        let half = std::f64::consts::FRAC_PI_2;
        for k in -4..=4 {
            let t = phase + f64::from(k) * half;
            if inside(t) {
                if k % 2 == 0 { greatest = amplitude } else { least = 0.0 }
            }
        }
    }
    (least, greatest)
}

fn deviation(p: (DVec3, DVec3), q: (DVec3, DVec3), control: (DVec3, DVec3), epsilon_m: f64, reading: Reading) -> f64 {
    let ((at_p, n_p), (at_q, n_q), (at_c, n_c)) = (p, q, control);
    // Eqs. 2 to 5: the sphere through p and the control pixel.
    let radius = (at_c - at_p).length() / (n_c - n_p).length();
    let side = (n_c - n_p).dot(at_c - at_p);
    let kappa = if radius.is_infinite() || side == 0.0 { 0.0 } else { side.signum() / radius };
    let e_curv = (kappa * (at_q - at_p) - (n_q - n_p)).length();
    // Eq. 6.
    let (above, below) = match reading {
        Reading::Text => (arc(n_p, n_q, at_q - at_p).0, arc(n_p, n_c, at_c - at_p).1),
        Reading::Swapped => (arc(n_p, n_c, at_c - at_p).0, arc(n_p, n_q, at_q - at_p).1),
    };
    let e_plane = ((above / (below + epsilon_m) - 50.0) / 100.0).clamp(0.0, 1.0);
    e_curv + e_plane
}

/// Returns E(p) of e_aa (Eq. 8 with `ramp`) as the error that the ramp maps to it, clamped to [0, 1]: as printed, with
/// the lesser of the far errors, and three planted errors: E(p) without Eq. 8, the greater of the far errors, and both
/// terms with the far pixel and its own far control. Returns `None` near the picture's border or the sky.
pub(crate) fn antialiased_errors(shot: &Shot, pixel: usize, epsilon_m: f64, ramp: [f64; 2]) -> Option<[f64; 4]> {
    let without = error(shot, pixel, epsilon_m, Reading::Text)?;
    let sample = |pixel: usize| (shot.position_m[pixel], shot.normal[pixel]);
    let mut worst = [0.0_f64; 3];
    for (dx, dy) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
        let at = |steps: i64| Some(sample(shot.neighbour(pixel, [dx * steps, dy * steps])?));
        let (near, near_control, beyond, beyond_control) = (at(1)?, at(-1)?, at(2)?, at(-2)?);
        let e_sum = |q, control| deviation(sample(pixel), q, control, epsilon_m, Reading::Text);
        let ramped = |error: f64| ((error - ramp[0]) / (ramp[1] - ramp[0])).clamp(0.0, 1.0);
        let nearest = e_sum(near, near_control);
        let (a, b) = (ramped(e_sum(beyond, near_control)), ramped(e_sum(near, beyond_control)));
        let (both, c) = (ramped(e_sum(beyond, beyond_control)), ramped(nearest));
        for (worst, farther) in worst.iter_mut().zip([a.min(b), a.max(b), both]) {
            let merged = ramp[0] + (ramp[1] - ramp[0]) * 0.5 * (farther + c);
            *worst = worst.max(if farther < c { merged } else { nearest });
        }
    }
    let [least, greatest, both] = worst.map(|worst| worst.min(1.0));
    Some([least, without, greatest, both])
}

/// Returns E(p), Eq. 1, clamped to [0, 1]; `None` where the picture's border or the sky is within two pixels.
pub(crate) fn error(shot: &Shot, pixel: usize, epsilon_m: f64, reading: Reading) -> Option<f64> {
    for dy in -2..=2 {
        for dx in -2..=2 {
            if shot.is_sky(shot.neighbour(pixel, [dx, dy])?) {
                return None;
            }
        }
    }
    let sample = |pixel: usize| (shot.position_m[pixel], shot.normal[pixel]);
    let mut worst = 0.0_f64;
    for (dx, dy) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
        let (q, control) = (shot.neighbour(pixel, [dx, dy])?, shot.neighbour(pixel, [-dx, -dy])?);
        worst = worst.max(deviation(sample(pixel), sample(q), sample(control), epsilon_m, reading));
    }
    Some(worst.min(1.0))
}
