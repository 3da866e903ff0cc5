//! Occlusion of land by land: the skyline around the camera, accumulated from near to far.
//!
//! For each of a few thousand directions (about one per pixel) the skyline has the steepest slope (height over distance, from
//! the camera) up to which the land visited so far certainly blocks the view. A box of land blocks it up to its
//! measured lowest height, in the directions that it fills from side to side; a box whose measured highest height is
//! below the skyline in all of its directions is invisible. Both are bounds, so nothing visible is skipped.
//!
//! Why: `docs/decisions/terrain-occlusion.md`.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec2;

use crate::scene::frustum::Bounds;

/// The smallest and the largest number of directions.
const MIN_DIRECTIONS: usize = 1024;
const MAX_DIRECTIONS: usize = 8192;

/// A part of a patch has to be wider than this many directions to fill any of them from side to side.
const WIDE_ENOUGH: f64 = 2.5;

/// The nearest of the distances by which a skyline is layered, in metres, and their number: the last is 370 km, beyond
/// which the earth's curvature hides land.
const FIRST_LAYER_M: f64 = 64.0;
const LAYERS: usize = 26;

/// The skyline around the camera, over all land added so far.
#[derive(Clone)]
pub(crate) struct Skyline {
    slopes: Vec<f32>,
    /// The skylines of the land within some distances, nearest first, each half an octave farther than the one before:
    /// all directions of the first, then all of the second. Empty unless the skyline is layered.
    layers: Vec<f32>,
    /// The directions in which land may block the view: those that the view sees, of all.
    touched: Range<usize>,
}

/// A corner of land, relative to the camera.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corner {
    /// Position in the plane, in metres.
    pub at_m: DVec2,
    /// Direction from the camera, 0 to 4 ([`direction`]).
    direction: f64,
}

impl Corner {
    /// Creates a corner at a position relative to the camera.
    #[inline]
    pub(crate) fn at(at_m: DVec2) -> Self {
        Self { at_m, direction: direction(at_m) }
    }
}

/// Returns a number from 0 to 4 that grows with the angle of a vector, by one per quarter turn. Opposite directions
/// differ by 2. Only the order of directions counts, and this number needs one division where an angle needs an
/// arctangent.
#[inline]
fn direction(v: DVec2) -> f64 {
    let across = v.y / (v.x.abs() + v.y.abs()).max(f64::MIN_POSITIVE);
    match (v.x >= 0.0, v.y >= 0.0) {
        (true, true) => across,
        (false, _) => 2.0 - across,
        (true, false) => 4.0 + across,
    }
}

/// A box as the camera sees it: its directions, and the squares of its horizontal distances in m².
struct AngularExtent {
    first: f64,
    width: f64,
    near_m2: f64,
    far_m2: f64,
}

impl AngularExtent {
    /// Returns the extent of corners in a box, or `None` for a box around the camera.
    #[inline]
    fn of(bounds: &Bounds, corners: &[Corner; 4]) -> Option<Self> {
        let (low, high) = (bounds.low_m.truncate(), bounds.high_m.truncate());
        let near_m2 = DVec2::ZERO.clamp(low, high).length_squared();
        if near_m2 == 0.0 {
            return None;
        }
        let far_m2 = low.abs().max(high.abs()).length_squared();
        // Seen from outside, a box spans less than half a turn.
        let from = corners[0].direction;
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        for corner in &corners[1..] {
            let turn = corner.direction - from;
            let turn = if turn > 2.0 {
                turn - 4.0
            } else if turn < -2.0 {
                turn + 4.0
            } else {
                turn
            };
            (least, most) = (least.min(turn), most.max(turn));
        }
        Some(Self { first: from + least, width: most - least, near_m2, far_m2 })
    }

    /// Returns the steepest slope at which land of the box up to the height `top_m` can be seen.
    #[inline]
    fn slope_of_top(&self, top_m: f64) -> f32 {
        (top_m / if top_m > 0.0 { self.near_m2 } else { self.far_m2 }.sqrt()) as f32
    }

    /// Returns the slope up to which land of the box of at least the height `land_m` blocks the view.
    #[inline]
    fn slope_of_land(&self, land_m: f64) -> f32 {
        (land_m / if land_m > 0.0 { self.far_m2 } else { self.near_m2 }.sqrt()) as f32
    }

    /// Returns the directions that the box touches, or with `is_filled` those that it fills, as up to two ranges of
    /// indices into a skyline of `count` directions.
    #[inline]
    fn steps(&self, count: usize, is_filled: bool) -> [Range<usize>; 2] {
        let per_turn = 0.25 * count as f64;
        let (first, last) = (self.first * per_turn, (self.first + self.width) * per_turn);
        let (first, last) = if is_filled {
            (ceil(first), floor(last))
        } else {
            let first = floor(first);
            (first, ceil(last).max(first + 1))
        };
        let begin = first.rem_euclid(count as i64) as usize;
        let end = begin + (last - first).clamp(0, count as i64) as usize;
        [begin..end.min(count), 0..end.saturating_sub(count)]
    }
}

/// Returns the largest integer that is at most `x`. The functions of f64 call a library on x86-64 without SSE 4.1, for
/// which the program is compiled.
#[inline]
fn floor(x: f64) -> i64 {
    let truncated = x as i64;
    truncated - i64::from(truncated as f64 > x)
}

#[inline]
fn ceil(x: f64) -> i64 {
    let truncated = x as i64;
    truncated + i64::from((truncated as f64) < x)
}

/// Returns the last layer that is nowhere farther than a distance, whose square is `square_m2`; negative if there is none.
#[inline]
fn layer_within(square_m2: f64) -> i32 {
    // Half an octave of a distance is an octave of its square, and the exponent of a float is its octave.
    ((square_m2 / (FIRST_LAYER_M * FIRST_LAYER_M)).to_bits() >> 52) as i32 - 1023
}

/// Returns the number of directions of a skyline, about one per pixel.
fn directions(focal_px: f64) -> usize {
    // The cast saturates.
    ((TAU * focal_px) as usize).clamp(MIN_DIRECTIONS, MAX_DIRECTIONS)
}

impl Skyline {
    /// Creates a skyline that blocks nothing; `focal_px` is in pixels per radian. A layered one knows the distances of its
    /// land.
    pub(crate) fn new(focal_px: f64, is_layered: bool) -> Self {
        let directions = directions(focal_px);
        let layers = if is_layered { directions * LAYERS } else { 0 };
        Self {
            slopes: vec![f32::NEG_INFINITY; directions],
            layers: vec![f32::NEG_INFINITY; layers],
            touched: directions..0,
        }
    }

    /// Returns a skyline like that of [`Skyline::new`] in the memory of this one, if it has the same size: a layered
    /// skyline takes most of a megabyte, which the system would fill with zeros at each frame.
    pub(crate) fn emptied(mut self, focal_px: f64, is_layered: bool) -> Self {
        let directions = directions(focal_px);
        if self.slopes.len() != directions || self.layers.is_empty() == is_layered {
            return Self::new(focal_px, is_layered);
        }
        if !self.touched.is_empty() {
            for slopes in std::iter::once(&mut self.slopes[..]).chain(self.layers.chunks_exact_mut(directions)) {
                slopes[self.touched.clone()].fill(f32::NEG_INFINITY);
            }
        }
        self.touched = directions..0;
        self
    }

    /// Completes the layers, after all land has been added: each contains the nearer ones.
    pub(crate) fn finish(&mut self) {
        if self.touched.is_empty() {
            return;
        }
        let count = self.slopes.len();
        for from in (count..self.layers.len()).step_by(count) {
            let (nearer, rest) = self.layers.split_at_mut(from);
            let nearer = &nearer[from - count..][self.touched.clone()];
            rest[self.touched.clone()].iter_mut().zip(nearer).for_each(|(slope, nearer)| *slope = slope.max(*nearer));
        }
    }

    /// Returns the number of parts into which a patch in a box is best divided along its sides: 1, 2 or 4.
    pub(crate) fn parts(&self, bounds: &Bounds) -> usize {
        let side_m = (bounds.high_m - bounds.low_m).truncate().min_element();
        let width = side_m / bounds.distance_m() / TAU * self.slopes.len() as f64;
        [4, 2].into_iter().find(|parts| width >= WIDE_ENOUGH * *parts as f64).unwrap_or(1)
    }

    /// Returns whether a box (camera-relative) is hidden by the land added so far, which must be nearer.
    pub(crate) fn hides(&self, bounds: &Bounds) -> bool {
        self.blocks(bounds, bounds.high_m.z)
    }

    /// Returns whether land in a box (camera-relative) up to the height `top_m` is below the skyline in all directions.
    pub(crate) fn blocks(&self, bounds: &Bounds, top_m: f64) -> bool {
        seen_from_all_corners(bounds).is_some_and(|seen| is_below(&self.slopes, &seen, seen.slope_of_top(top_m)))
    }

    /// Returns whether a box (camera-relative) is hidden by nearer land, even if it looked higher by `slack`, in height
    /// per distance. Other land may be farther. The skyline must be layered and finished.
    pub(crate) fn hides_behind(&self, bounds: &Bounds, slack: f64) -> bool {
        let Some(seen) = seen_from_all_corners(bounds) else { return false };
        let Ok(nearer) = usize::try_from(layer_within(seen.near_m2)) else { return false };
        if self.layers.is_empty() {
            return false;
        }
        let from = nearer.min(LAYERS - 1) * self.slopes.len();
        let layer = &self.layers[from..from + self.slopes.len()];
        is_below(layer, &seen, seen.slope_of_top(bounds.high_m.z) + slack as f32)
    }

    /// Adds land without holes: `corners` are its corners in the plane, `bounds` is its box, and all of it is at least
    /// `land_m` high. All are camera-relative, in metres.
    pub(crate) fn add(&mut self, bounds: &Bounds, corners: &[Corner; 4], land_m: f64) {
        let Some(seen) = AngularExtent::of(bounds, corners) else { return };
        let slope = seen.slope_of_land(land_m);
        let count = self.slopes.len();
        let layer = (layer_within(seen.far_m2) + 1).max(0) as usize;
        let layer = (layer < LAYERS && !self.layers.is_empty()).then_some(layer * count);
        for range in seen.steps(count, true).into_iter().filter(|range| !range.is_empty()) {
            self.touched = self.touched.start.min(range.start)..self.touched.end.max(range.end);
            if let Some(from) = layer {
                let of_layer = &mut self.layers[from + range.start..from + range.end];
                of_layer.iter_mut().for_each(|blocked| *blocked = blocked.max(slope));
            }
            self.slopes[range].iter_mut().for_each(|blocked| *blocked = blocked.max(slope));
        }
    }
}

/// Returns the extent of a whole box, or `None` for a box around the camera.
#[inline]
fn seen_from_all_corners(bounds: &Bounds) -> Option<AngularExtent> {
    let (low, high) = (bounds.low_m.truncate(), bounds.high_m.truncate());
    let mixed = [DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)];
    AngularExtent::of(bounds, &[Corner::at(low), Corner::at(high), Corner::at(mixed[0]), Corner::at(mixed[1])])
}

/// Returns whether a slope is below a skyline in all directions that an extent touches.
#[inline]
fn is_below(slopes: &[f32], seen: &AngularExtent, slope: f32) -> bool {
    let steps = seen.steps(slopes.len(), false);
    steps.into_iter().all(|range| slopes[range].iter().all(|blocked| *blocked > slope))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn add(horizon: &mut Skyline, slab: &Bounds) {
        let (low, high) = (slab.low_m.truncate(), slab.high_m.truncate());
        let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)].map(Corner::at);
        horizon.add(slab, &corners, slab.low_m.z);
    }

    fn slab(from: [f64; 2], to: [f64; 2], low_m: f64, high_m: f64) -> Bounds {
        Bounds { low_m: DVec3::new(from[0], from[1], low_m), high_m: DVec3::new(to[0], to[1], high_m) }
    }

    #[test]
    fn a_ridge_hides_what_is_low_behind_it_and_nothing_else() {
        let mut horizon = Skyline::new(200.0, true);
        let behind = slab([-100.0, 3000.0], [100.0, 3200.0], -50.0, 250.0);
        assert!(!horizon.hides(&behind));
        // A ridge of at least 100 m, 900 to 1000 m away, blocks the view up to a slope of 0.1, less at its ends.
        let ridge = slab([-500.0, 900.0], [500.0, 1000.0], 100.0, 150.0);
        add(&mut horizon, &ridge);
        assert!(horizon.hides(&behind), "250 m at 3000 m is below 0.089");
        assert!(!horizon.hides(&slab([-100.0, 3000.0], [100.0, 3200.0], -50.0, 350.0)), "350 m looks over it");
        assert!(!horizon.hides(&slab([1500.0, 3000.0], [1900.0, 3200.0], -50.0, 100.0)), "it is to the side");
        assert!(!horizon.hides(&slab([-100.0, 500.0], [100.0, 600.0], -50.0, 100.0)), "it is in front of the ridge");
        assert!(!horizon.hides(&slab([-100.0, -3200.0], [100.0, -3000.0], -50.0, 10.0)), "it is behind the camera");
        assert!(!horizon.hides(&slab([-9000.0, 3000.0], [9000.0, 3200.0], -50.0, 10.0)), "its ends are visible");
    }

    #[test]
    fn a_finished_skyline_hides_what_is_behind_its_land_and_nothing_in_front_of_it() {
        let mut horizon = Skyline::new(200.0, true);
        add(&mut horizon, &slab([-500.0, 900.0], [500.0, 1000.0], 100.0, 150.0));
        // A mountain behind the ridge.
        add(&mut horizon, &slab([-9000.0, 9000.0], [9000.0, 9900.0], 3000.0, 3500.0));
        horizon.finish();
        let meadow = slab([-100.0, 500.0], [100.0, 600.0], -50.0, 20.0);
        assert!(!horizon.hides_behind(&meadow, 0.0), "it is in front of the ridge");
        // The planted error: without distances, the ridge and the mountain behind it hide the meadow.
        assert!(horizon.hides(&meadow));
        let valley = |high_m| slab([-100.0, 3000.0], [100.0, 3200.0], -50.0, high_m);
        assert!(horizon.hides_behind(&valley(250.0), 0.0), "it is behind the ridge");
        assert!(!horizon.hides_behind(&valley(250.0), 0.02), "a little higher, it looks over the ridge");
        assert!(!horizon.hides_behind(&valley(350.0), 0.0), "it looks over the ridge, and the mountain is behind it");
        assert!(horizon.hides_behind(&slab([-100.0, 20_000.0], [100.0, 20_200.0], -50.0, 4000.0), 0.0), "the mountain");
        assert!(!horizon.hides_behind(&slab([-100.0, 930.0], [100.0, 990.0], -50.0, 20.0), 0.0), "it is on the ridge");
        assert!(!Skyline::new(200.0, false).hides_behind(&meadow, 0.0), "without layers, nothing is hidden");
    }

    #[test]
    fn a_skyline_in_the_memory_of_another_hides_what_a_new_one_hides() {
        let lands = [
            slab([-500.0, 900.0], [500.0, 1000.0], 100.0, 150.0),
            // Across the direction 0, from which directions are counted.
            slab([900.0, -500.0], [1000.0, 500.0], 100.0, 150.0),
            slab([-9000.0, 9000.0], [9000.0, 9900.0], 3000.0, 3500.0),
        ];
        let mut used = Skyline::new(200.0, true);
        lands.iter().for_each(|land| add(&mut used, land));
        used.finish();
        for land in &lands {
            let (mut fresh, mut again) = (Skyline::new(200.0, true), used.clone().emptied(200.0, true));
            // The planted error: without being emptied, it hides what the other land hides.
            let mut stale = used.clone();
            for skyline in [&mut fresh, &mut again, &mut stale] {
                add(skyline, land);
                skyline.finish();
            }
            assert_eq!((&again.slopes, &again.layers), (&fresh.slopes, &fresh.layers));
            assert_ne!(stale.slopes, fresh.slopes);
        }
        let other = used.emptied(300.0, false);
        assert_eq!((other.slopes.len(), other.layers.len()), (directions(300.0), 0));
    }

    #[test]
    fn layers_are_half_an_octave_apart() {
        for (distance_m, layer) in [(63.9, -1), (64.1, 0), (90.4, 0), (90.6, 1), (127.9, 1), (128.1, 2), (64e3, 19)] {
            assert_eq!(layer_within(distance_m * distance_m), layer, "{distance_m}");
        }
        for x in [-2.0, -1.5, -0.0, 0.0, 0.3, 7.0, 7.9] {
            assert_eq!((floor(x), ceil(x)), (x.floor() as i64, x.ceil() as i64));
        }
    }

    #[test]
    fn directions_are_in_the_order_of_angles() {
        let angles = (0..4000).map(|i| f64::from(i) * TAU / 4000.0);
        let directions: Vec<f64> = angles.map(|angle_rad| direction(DVec2::from_angle(angle_rad) * 7.0)).collect();
        assert!(directions.windows(2).all(|pair| pair[0] < pair[1]));
        for i in 0..2000 {
            assert!((directions[i + 2000] - directions[i] - 2.0).abs() < 1e-12, "opposite directions differ by 2");
        }
    }

    #[test]
    fn land_below_the_camera_hides_only_what_is_lower() {
        let mut horizon = Skyline::new(200.0, true);
        let near = slab([-100.0, 100.0], [100.0, 200.0], -30.0, -20.0);
        add(&mut horizon, &near);
        // Slopes up to -0.3 are blocked.
        assert!(!horizon.hides(&slab([-10.0, 400.0], [10.0, 500.0], -90.0, -60.0)));
        assert!(horizon.hides(&slab([-10.0, 400.0], [10.0, 410.0], -190.0, -160.0)));
    }
}
