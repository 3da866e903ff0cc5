//! Poses and lenses of the eyes in a frame.

use openxr_sys as xr;

use super::state::State;

/// Returns the eyes of a frame: a head that looks around, nods, and leans.
pub(crate) fn views_at(state: &State, frame: u64, kind: xr::ReferenceSpaceType) -> [xr::View; 2] {
    let t = if state.script.moves { frame as f32 / 90.0 } else { 0.0 };
    let (yaw, pitch, roll) = (0.35 * (0.9 * t).sin(), 0.2 * (1.3 * t).sin() - 0.1, 0.25 * (0.7 * t).sin() + 0.05);
    let [(sy, cy), (sp, cp), (sr, cr)] = [yaw, pitch, roll].map(|angle: f32| (0.5 * angle).sin_cos());
    // Yaw about y, then pitch about x, then roll about z.
    let turn = product([0.0, sy, 0.0, cy], product([sp, 0.0, 0.0, cp], [0.0, 0.0, sr, cr]));
    let head = [0.1 * (0.5 * t).sin(), 1.6 + 0.03 * (2.0 * t).sin(), 0.1 * (0.4 * t).cos()];
    let floor = if kind == xr::ReferenceSpaceType::LOCAL { 1.6 } else { 0.0 };
    [-1.0, 1.0].map(|side: f32| {
        let aside = rotated(turn, [0.5 * side * state.script.ipd_m, 0.0, 0.0]);
        let orientation = xr::Quaternionf { x: turn[0], y: turn[1], z: turn[2], w: turn[3] };
        let position = xr::Vector3f { x: head[0] + aside[0], y: head[1] + aside[1] - floor, z: head[2] + aside[2] };
        let fov = lens(side);
        xr::View { ty: xr::View::TYPE, next: std::ptr::null_mut(), pose: xr::Posef { orientation, position }, fov }
    })
}

/// Returns the lens of an eye: the left one for `side` −1, the right one for 1.
pub(crate) fn lens(side: f32) -> xr::Fovf {
    // The lens sees farther outward than toward the nose.
    let (outward, inward) = (0.9, 0.7);
    let (left, right) = if side < 0.0 { (outward, inward) } else { (inward, outward) };
    xr::Fovf { angle_left: -left, angle_right: right, angle_up: 0.75, angle_down: -0.85 }
}

fn product([ax, ay, az, aw]: [f32; 4], [bx, by, bz, bw]: [f32; 4]) -> [f32; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

fn rotated(q: [f32; 4], [x, y, z]: [f32; 3]) -> [f32; 3] {
    let [x, y, z, _] = product(product(q, [x, y, z, 0.0]), [-q[0], -q[1], -q[2], q[3]]);
    [x, y, z]
}
