//! The axes along which marks run, and the position of the camera on each of them: the phases of hatching, in f64.
//!
//! `shaders/shared/hatch.wgsl` numbers the axes in the same order.

use glam::{DVec2, DVec3};

pub(crate) use crate::gpu::wgsl::shared::hatched_surface::Axis;
pub(crate) use crate::gpu::wgsl::tones::fractal_hatching::Cell;
use crate::style::hatching::{Direction, MAX_SETS, MarkSet};
pub(crate) use crate::surface::ladder::{FIRST_LEVEL, LEVELS, phases, to_azimuth};
use crate::surface::ladder::{GOLDEN, compass};

/// Number of level axes around the compass, and of axes that fall at 45°.
const AZIMUTHS: usize = crate::gpu::wgsl::shared::hatch::AZIMUTHS as usize;

/// Returns the azimuth of a set's fixed direction: its own, or the one that it uses on level land.
pub(crate) fn fixed_rad(set: &MarkSet) -> f64 {
    f64::from(if set.direction == Direction::Fixed { set.angle_deg } else { set.level_deg }).to_radians()
}

/// Length of the slow axes; the others are unit vectors.
const SLOW: f64 = 0.125;

/// Returns all axes in world space, as unit vectors apart from the slow ones, which come last.
pub(crate) fn axes(sets: &[MarkSet]) -> Vec<DVec3> {
    let level = compass(AZIMUTHS).map(|to| to.extend(0.0));
    let falling = compass(AZIMUTHS).map(|to| to.extend(-1.0).normalize());
    let along = |i: usize| sets.get(i).map_or(DVec2::Y, |set| to_azimuth(fixed_rad(set)));
    let fixed = (0..MAX_SETS).flat_map(|i| {
        let along = along(i);
        [DVec2::new(along.y, -along.x).extend(0.0), along.extend(0.0)]
    });
    let slow = (0..MAX_SETS).map(|i| SLOW * along(i).extend(0.0));
    level.chain(falling).chain([DVec3::Z]).chain(fixed).chain(slow).collect()
}

/// Returns the axes in the form that the shaders read.
pub(crate) fn directions(axes: &[DVec3]) -> Vec<Axis> {
    axes.iter().map(|axis| Axis { direction: axis.as_vec3().to_array(), pad: 0.0 }).collect()
}

/// The first level of the fractal rule's ladder: a place of it is 2^first metres.
pub(crate) const FIRST_OCTAVE: i32 = -22;

/// Number of levels of the fractal rule's ladder.
pub(crate) const OCTAVES: usize = 40;

/// The fractal rule's places of an axis begin within this many metres of the origin. The beginning is the place of the
/// coarsest mark of all: if all axes began at the origin, there would be a star of marks.
const BEGINS_WITHIN_M: f64 = 131_072.0;

/// Returns the camera's position on each axis at each level of the fractal rule's ladder: the levels of the first axis,
/// then those of the next.
pub(crate) fn cells(axes: &[DVec3], camera_m: DVec3) -> Vec<Cell> {
    let place = |along_m: f64, level: usize| {
        let at = along_m / f64::from(level as i32 + FIRST_OCTAVE).exp2();
        let whole = at.floor();
        Cell { index: whole.rem_euclid(f64::from(1 << 30)) as i32, rest: (at - whole) as f32 }
    };
    let along_m = |number: usize| axes[number].dot(camera_m) + BEGINS_WITHIN_M * ((number + 1) as f64 * GOLDEN).fract();
    (0..axes.len()).flat_map(|number| (0..OCTAVES).map(move |level| place(along_m(number), level))).collect()
}
