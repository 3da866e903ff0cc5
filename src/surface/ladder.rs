//! Coordinates of solid textures: positions along axes of the world, at a ladder of scales, in f64.
//!
//! A solid texture is fixed to the world, whatever the camera does. Positions on the GPU are relative to the camera, so
//! the position of the camera on each axis and level is computed here, without the whole tiles that it has passed.

use glam::{DVec2, DVec3};

/// The first level of the ladder of scales: the side of its texels is 2^(first / 2) metres.
pub(crate) const FIRST_LEVEL: i32 = -44;

/// Number of levels: texels from 0.2 µm to 47 km. A lens of 1° at 0.1 m needs the former, a lens of 150° in space the
/// latter.
pub(crate) const LEVELS: usize = 76;

/// The golden section, whose multiples are evenly distributed between whole numbers.
pub(crate) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Returns the unit vector toward an azimuth, clockwise from north.
pub(crate) fn to_azimuth(rad: f64) -> DVec2 {
    DVec2::new(rad.sin(), rad.cos())
}

/// Returns the level unit vectors around the compass: north, then clockwise.
pub(crate) fn compass(count: usize) -> impl Iterator<Item = DVec2> {
    let step_rad = std::f64::consts::TAU / count as f64;
    (0..count).map(move |step| to_azimuth(step as f64 * step_rad))
}

/// Returns the position of a rig's origin on each axis at each level, in texels, from 0 to `side`, after which a tile repeats:
/// the levels of the first axis, then those of the next. Each axis and level has its own offset, so that scales do not
/// agree at the origin.
pub(crate) fn phases(axes: &[DVec3], origin_m: DVec3, side: f64) -> Vec<f32> {
    let mut phases = Vec::with_capacity(axes.len() * LEVELS);
    for (number, axis) in axes.iter().enumerate() {
        let along_m = axis.dot(origin_m);
        for level in 0..LEVELS {
            let texel_m = (0.5 * f64::from(level as i32 + FIRST_LEVEL)).exp2();
            let shift = ((number * LEVELS + level) as f64 * GOLDEN).fract();
            phases.push(((along_m / (texel_m * side) + shift).rem_euclid(1.0) * side) as f32);
        }
    }
    phases
}
