//! Land whose heights are a formula, and the directions of marks in pictures of it.

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::scene::view::Pose;
use hachure::style::Style;

use crate::tests::common::hill::Hill;
use crate::tests::common::{World, grid_of, quantile};
use crate::tests::hatching::plane::{Inked, shoot};

/// Land with heights by a formula.
pub struct Land {
    pub world: World,
    renderer: Option<Renderer>,
    height_m: Box<dyn Fn(f64, f64) -> f64>,
}

/// Size of the pictures, in pixels.
pub const SIZE_PX: [u32; 2] = [256, 192];
/// Side of a window.
pub const WINDOW_PX: usize = 32;
const STEP_PX: usize = 16;
/// Standard deviation of the Gaussian through which ink is seen.
const BELL_PX: f64 = 1.5;
/// Least coherence, of 0 to 1, at which a window has a direction.
const COHERENT: f64 = 0.5;

impl Land {
    /// Makes land on a square grid about the origin.
    pub fn new(samples: u32, spacing_m: f64, height_m: impl Fn(f64, f64) -> f64 + 'static) -> Option<Self> {
        let world = World::new(grid_of(samples, samples, spacing_m, &height_m), 1.0)?;
        Some(Self { world, renderer: None, height_m: Box::new(height_m) })
    }

    /// Makes the hill of the tests, `size` times as large.
    pub fn hill(size: f64) -> Option<Self> {
        let hill = Hill { middle_m: DVec2::ZERO };
        Self::new(641, 10.0 * size, move |x, y| size * hill.height_m(x / size, y / size))
    }

    /// Returns the gradient of the land to the east and to the north.
    pub fn rise(&self, at_m: DVec3) -> DVec2 {
        let height_m = &self.height_m;
        let step_m = 0.5;
        let east = height_m(at_m.x + step_m, at_m.y) - height_m(at_m.x - step_m, at_m.y);
        let north = height_m(at_m.x, at_m.y + step_m) - height_m(at_m.x, at_m.y - step_m);
        DVec2::new(east, north) / (2.0 * step_m)
    }

    /// Returns the unit tangent of the land at a point in the direction `to` of the map.
    pub fn tangent(&self, at_m: DVec3, to: DVec2) -> DVec3 {
        to.extend(to.dot(self.rise(at_m))).normalize()
    }

    pub fn look(&mut self, pose: Pose, style: &Style) -> Inked {
        shoot(&mut self.world, &mut self.renderer, pose, SIZE_PX, style)
    }

    pub fn shoot(&mut self, camera: &str, style: &Style) -> Inked {
        self.look(self.world.pose(camera), style)
    }
}

/// Marks in a square window of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// First pixel (x, y).
    pub first: [usize; 2],
    pub ink: f64,
    /// Point at the window's middle, in the world.
    pub place_m: DVec3,
    /// Points near the window's corners, in the world.
    pub corners_m: [DVec3; 4],
    /// Unit vector along the marks, on the land.
    pub along: DVec3,
    /// From 0 (no direction) to 1 (a single direction).
    pub coherence: f64,
}

impl Inked {
    /// Returns the gradient of ink to the right and down, seen through a Gaussian, so that the steps of pixels do not
    /// rotate lines.
    pub fn slopes(&self) -> Vec<DVec2> {
        let [width, height] = self.size_px;
        let reach = (3.0 * BELL_PX) as i64;
        let bell: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (i as f64 / BELL_PX).powi(2)).exp()).collect();
        let side: Vec<f64> = (-reach..=reach).zip(&bell).map(|(i, bell)| i as f64 * bell).collect();
        let folded = |values: &[f64], weights: &[f64], step: usize, along: fn(usize, usize) -> usize, size: usize| {
            let at = |i: usize, k: usize| {
                let place = (along(i, width) as i64 + k as i64 - reach).clamp(0, size as i64 - 1);
                values[(i as i64 + (place - along(i, width) as i64) * step as i64) as usize]
            };
            (0..values.len())
                .map(|i| weights.iter().enumerate().map(|(k, weight)| weight * at(i, k)).sum())
                .collect::<Vec<f64>>()
        };
        let across = |values: &[f64], weights: &[f64]| folded(values, weights, 1, |i, width| i % width, width);
        let down = |values: &[f64], weights: &[f64]| folded(values, weights, width, |i, width| i / width, height);
        let right = down(&across(&self.ink, &side), &bell);
        let below = across(&down(&self.ink, &side), &bell);
        right.into_iter().zip(below).map(|(x, y)| DVec2::new(x, y)).collect()
    }

    /// Returns the point of the land at a position between pixels.
    fn seen_m(&self, px: DVec2) -> Option<DVec3> {
        let (whole, f) = ((px - 0.5).floor(), (px - 0.5).fract());
        let at = |right: f64, below: f64| {
            let [x, y] = [whole.x + right, whole.y + below].map(|at| at as usize);
            *self.place_m.get(y * self.size_px[0] + x)?
        };
        let upper = at(0.0, 0.0)?.lerp(at(1.0, 0.0)?, f.x);
        Some(upper.lerp(at(0.0, 1.0)?.lerp(at(1.0, 1.0)?, f.x), f.y))
    }

    /// Returns, row by row, how much the ink of each pixel differs from that of the next frame at the same point of the
    /// ground.
    pub fn changes(&self, next: &Inked) -> Vec<Option<f64>> {
        let change = |(ink, place_m): (&f64, &Option<DVec3>)| {
            let px = next.view.place_px((*place_m)? - next.view.pose.position_m)?;
            Some((next.between(px)? - ink).abs())
        };
        self.ink.iter().zip(&self.place_m).map(change).collect()
    }

    /// Returns all windows that contain only land.
    pub fn windows(&self) -> Vec<Window> {
        let slopes = self.slopes();
        let [width, height] = self.size_px;
        let mut windows = Vec::new();
        for y in (0..=height - WINDOW_PX).step_by(STEP_PX) {
            for x in (0..=width - WINDOW_PX).step_by(STEP_PX) {
                windows.extend(self.window([x, y], &slopes));
            }
        }
        windows
    }

    fn window(&self, first: [usize; 2], slopes: &[DVec2]) -> Option<Window> {
        let pixels = || {
            (0..WINDOW_PX * WINDOW_PX).map(|k| (first[1] + k / WINDOW_PX) * self.size_px[0] + first[0] + k % WINDOW_PX)
        };
        if pixels().any(|i| self.place_m[i].is_none()) {
            return None;
        }
        // Angles are doubled, so that both ways along a line are the same direction.
        let (mut doubled, mut whole, mut ink) = (DVec2::ZERO, 0.0, 0.0);
        for i in pixels() {
            let slope = slopes[i];
            doubled += DVec2::new(slope.x * slope.x - slope.y * slope.y, 2.0 * slope.x * slope.y);
            whole += slope.length_squared();
            ink += self.ink[i];
        }
        let along_px = DVec2::from_angle(0.5 * doubled.to_angle()).perp();
        let middle = DVec2::new(first[0] as f64, first[1] as f64) + 0.5 * WINDOW_PX as f64;
        // The land is curved, so the direction is that of a chord through the middle.
        let reach = 0.45 * WINDOW_PX as f64;
        let chord = self.seen_m(middle + along_px * reach)? - self.seen_m(middle - along_px * reach)?;
        let corner = |x: f64, y: f64| self.seen_m(middle + DVec2::new(x, y) * reach);
        Some(Window {
            first,
            corners_m: [corner(-1.0, -1.0)?, corner(1.0, -1.0)?, corner(-1.0, 1.0)?, corner(1.0, 1.0)?],
            ink: ink / (WINDOW_PX * WINDOW_PX) as f64,
            place_m: self.seen_m(middle)?,
            along: chord.normalize(),
            coherence: doubled.length() / whole.max(1e-12),
        })
    }
}

/// Returns the angle between two lines, in degrees.
pub fn between_deg(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b).abs()).to_degrees()
}

/// How far directions are from the wanted ones.
#[derive(Clone, Copy, Debug)]
pub struct Off {
    pub median_deg: f64,
    pub percentile_90_deg: f64,
    pub count: usize,
    /// Number of windows without a direction.
    pub without: usize,
}

impl Off {
    /// Compares windows for which `wanted` returns a direction. `percentile_90_deg` is the 90th percentile.
    pub fn of(windows: &[Window], wanted: impl Fn(&Window) -> Option<DVec3>) -> Self {
        let (mut angles, mut without) = (Vec::new(), 0);
        for window in windows {
            let Some(wanted) = wanted(window) else { continue };
            if window.coherence < COHERENT {
                without += 1;
            } else {
                angles.push(between_deg(window.along, wanted));
            }
        }
        let count = angles.len();
        Self { median_deg: quantile(&mut angles, 0.5), percentile_90_deg: quantile(&mut angles, 0.9), count, without }
    }

    /// Returns whether the directions are within the given bounds, and most windows have one.
    pub fn holds(&self, [median_deg, percentile_90_deg]: [f64; 2]) -> bool {
        self.median_deg <= median_deg
            && self.percentile_90_deg <= percentile_90_deg
            && self.count > 40
            && self.without * 4 < self.count
    }
}
