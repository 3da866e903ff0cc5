//! The axes that marks lie along, and where the camera is on each of them: the phases of hatching, in f64.
//!
//! `shaders/shared/hatch.wgsl` counts the axes in the same order.

use glam::{DVec2, DVec3};

pub use crate::gpu::wgsl::tones::fractal_hatching::Cell;
pub use crate::gpu::wgsl::tones::hatching::Axis;
use crate::style::hatching::{Direction, Layer, MOST_LAYERS};

/// Level axes around the compass, and as many that fall at 45°.
const AZIMUTHS: usize = crate::gpu::wgsl::shared::hatch::AZIMUTHS as usize;

/// The first level of the ladder of scales: a texel of it is 2^(first / 2) metres.
pub const FIRST_LEVEL: i32 = -44;

/// Levels: from 0.2 µm to 47 km for a texel. A lens of 1° sees the former from 0.1 m, one of 150° the latter from
/// space.
pub const LEVELS: usize = 76;

/// Its multiples lie evenly between whole numbers.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The unit vector to an azimuth, clockwise from north.
pub fn to_azimuth(rad: f64) -> DVec2 {
    DVec2::new(rad.sin(), rad.cos())
}

/// The azimuth of a layer's fixed direction: its own, or what it falls back to on level land.
pub fn fixed_rad(layer: &Layer) -> f64 {
    f64::from(if layer.direction == Direction::Fixed { layer.angle_deg } else { layer.level_deg }).to_radians()
}

/// Part of a step that the slow axes have.
const SLOW: f64 = 0.125;

/// All of them in the world: unit, but for the slow ones, which come last.
pub fn axes(layers: &[Layer]) -> Vec<DVec3> {
    let step_rad = std::f64::consts::TAU / AZIMUTHS as f64;
    let compass = || (0..AZIMUTHS).map(move |step| to_azimuth(step as f64 * step_rad));
    let level = compass().map(|to| to.extend(0.0));
    let falling = compass().map(|to| to.extend(-1.0).normalize());
    let along = |i: usize| layers.get(i).map_or(DVec2::Y, |layer| to_azimuth(fixed_rad(layer)));
    let fixed = (0..MOST_LAYERS).flat_map(|i| {
        let along = along(i);
        [DVec2::new(along.y, -along.x).extend(0.0), along.extend(0.0)]
    });
    let slow = (0..MOST_LAYERS).map(|i| SLOW * along(i).extend(0.0));
    level.chain(falling).chain([DVec3::Z]).chain(fixed).chain(slow).collect()
}

/// Where the camera lies on each axis at each level, in texels, 0 to `side`, after which a tile repeats: the levels of
/// the first axis, then those of the next. Each axis and level begins somewhere else, so that scales do not agree at
/// the origin.
pub fn phases(axes: &[DVec3], camera_m: DVec3, side: f64) -> Vec<f32> {
    let mut phases = Vec::with_capacity(axes.len() * LEVELS);
    for (number, axis) in axes.iter().enumerate() {
        let along_m = axis.dot(camera_m);
        for level in 0..LEVELS {
            let texel_m = (0.5 * f64::from(level as i32 + FIRST_LEVEL)).exp2();
            let shift = ((number * LEVELS + level) as f64 * GOLDEN).fract();
            phases.push(((along_m / (texel_m * side) + shift).rem_euclid(1.0) * side) as f32);
        }
    }
    phases
}

/// The axes as the shaders read them.
pub fn directions(axes: &[DVec3]) -> Vec<Axis> {
    axes.iter().map(|axis| Axis { direction: axis.as_vec3().to_array(), pad: 0.0 }).collect()
}

/// The first level of the fractal rule's ladder: a place of it is 2^first metres.
pub const FIRST_OCTAVE: i32 = -22;

/// Its levels.
pub const OCTAVES: usize = 40;

/// The fractal rule's places of an axis begin within so many metres of the origin. It is the place of the coarsest mark
/// of all: if all axes had theirs at the origin, there would be a star of marks.
const BEGINS_WITHIN_M: f64 = 131_072.0;

/// Where the camera lies on each axis at each level of the fractal rule's ladder: the levels of the first axis, then
/// those of the next.
pub fn cells(axes: &[DVec3], camera_m: DVec3) -> Vec<Cell> {
    let place = |along_m: f64, level: usize| {
        let at = along_m / f64::from(level as i32 + FIRST_OCTAVE).exp2();
        let whole = at.floor();
        Cell { index: whole.rem_euclid(f64::from(1 << 30)) as i32, rest: (at - whole) as f32 }
    };
    let along_m = |number: usize| axes[number].dot(camera_m) + BEGINS_WITHIN_M * ((number + 1) as f64 * GOLDEN).fract();
    (0..axes.len()).flat_map(|number| (0..OCTAVES).map(move |level| place(along_m(number), level))).collect()
}
