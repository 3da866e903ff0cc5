//! Windows along a line that may hold its number, and how straight they are.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::DVec2;

use super::Tops;
use super::frame::Frame;
use super::paths::Path;

/// Lines with more samples have no numbers.
const MAX_SAMPLES: f64 = 4e6;
/// Fewest steps of a window.
const MIN_WINDOW: usize = 3;
/// A line must be at least this many times as long as its text. Of a ring a larger part may be interrupted.
const MIN_LENGTH: f64 = 2.5;
const MIN_RING: f64 = 2.0;
/// Sharper bends on the length of a letter exclude a window, in radians. Little less than the 45° that are allowed.
const MAX_BEND: f64 = 40.0 * PI / 180.0;
/// A window whose direction changes by this angle on the length of a letter costs 1, in radians.
const BEND: f64 = 10.0 * PI / 180.0;
/// A window whose directions deviate this much from an arc costs 1, in radians.
const ROUGH: f64 = 10.0 * PI / 180.0;
/// Costs of a number that is read vertically, of one that just begins to be upside down, and of one that is.
const VERTICAL: f64 = 0.7;
const TURNED: f64 = 2.0;
const UPSIDE_DOWN: f64 = 4.5;

/// A line that may have numbers, and its text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Role {
    pub line: usize,
    /// Width of the text and length of its gap, in pixels.
    pub width_px: f64,
    pub gap_px: f64,
    /// Numbers of the same level must keep their distance from each other.
    pub level: usize,
    /// Position of the level in a ladder; `None` for lines outside of ladders, whose numbers need free land.
    pub rung: Option<usize>,
    /// 1 if uphill is to the right of the line, −1 if it is to the left; 0 if it is unknown.
    pub side: f64,
    /// Cost of each number of this line in addition to that of its position.
    pub cost: f64,
}

/// A line sampled at equal steps. A window is named by its first sample.
pub(super) struct Course {
    pub role: Role,
    /// Number of windows.
    pub count: usize,
    /// Distance of the samples, in pixels.
    pub step_px: f64,
    pub is_closed: bool,
    /// Number of steps of a window.
    window: usize,
    samples: Vec<DVec2>,
    /// For each sample, the sums over the steps before it of direction, index times direction, and squared direction.
    sums: Vec<[f64; 3]>,
    /// For each sample, the number of sharp bends before it.
    sharp: Vec<u32>,
}

/// The arc that fits a window, in the reading direction, and its cost as far as it depends only on the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub frame: Frame,
    pub cost: f64,
}

impl Course {
    /// Samples a line at half letters. Returns `None` if there is no room for its number.
    pub(super) fn new(role: Role, path: &Path<'_>, letter_px: f64) -> Option<Self> {
        let length_px = path.length_px();
        let steps = (2.0 * length_px / letter_px).ceil();
        let shortest_px = role.width_px * if path.is_closed { MIN_RING } else { MIN_LENGTH };
        if !(length_px > role.gap_px && length_px >= shortest_px && steps < MAX_SAMPLES) {
            return None;
        }
        let (steps, step_px) = (steps as usize, length_px / steps);
        let window = ((role.gap_px / step_px).round() as usize).max(MIN_WINDOW);
        if window >= steps {
            return None;
        }
        let [count, needed] = if path.is_closed { [steps, steps + window] } else { [steps - window + 1, steps + 1] };
        let mut samples = Vec::with_capacity(needed);
        path.sample(0.0, step_px, needed, &mut samples);
        let (sums, sharp) = (sums(&samples), sharp_bends(&samples));
        Some(Self { role, count, step_px, is_closed: path.is_closed, window, samples, sums, sharp })
    }

    /// Returns the arc length of the middle of a window, in pixels.
    pub(super) fn middle_px(&self, at: usize) -> f64 {
        (at as f64 + 0.5 * self.window as f64) * self.step_px
    }

    /// Returns the point in the middle of a window.
    pub(super) fn middle(&self, at: usize) -> DVec2 {
        self.samples[at + self.window / 2]
    }

    /// Returns the windows whose middles are within a distance of an arc length, in pixels, each once.
    pub(super) fn around(&self, along_px: f64, reach_px: f64) -> impl Iterator<Item = usize> + use<> {
        let center = along_px / self.step_px - 0.5 * self.window as f64;
        let reach = reach_px / self.step_px;
        let [first, last] = [(center - reach).ceil() as i64, (center + reach).floor() as i64];
        let (count, is_closed) = (self.count as i64, self.is_closed);
        let [first, last] =
            if is_closed { [first, last.min(first + count - 1)] } else { [first.max(0), last.min(count - 1)] };
        (first..=last).map(move |at| at.rem_euclid(count) as usize)
    }

    /// Returns the arc that fits a window, or `None` if the line bends too sharply there. The direction of the arc
    /// changes linearly along the window, by least squares.
    pub(super) fn estimate(&self, at: usize, letter_px: f64, tops: Tops) -> Option<Estimate> {
        let end = at + self.window;
        if self.sharp[end + 1] > self.sharp[at] {
            return None;
        }
        let count = self.window as f64;
        let [sum, moment, square] = [0, 1, 2].map(|i| self.sums[end][i] - self.sums[at][i]);
        let mean = sum / count;
        let spread = count * (count * count - 1.0) / 12.0;
        let slope = (moment - (at as f64 + 0.5 * (count - 1.0)) * sum) / spread;
        let variance = ((square - mean * sum - slope * slope * spread) / count).max(0.0);
        let bend = slope / self.step_px;
        let bend_per_letter = (bend * letter_px).abs();
        if bend_per_letter > MAX_BEND {
            return None;
        }
        let frame = Frame { centre: self.middle(at), along: DVec2::from_angle(mean), bend };
        let frame = turned(frame, self.role.side, tops);
        let cost = (bend_per_letter / BEND).powi(2)
            + variance / (ROUGH * ROUGH)
            + slant(frame.along.to_angle().abs())
            + self.role.cost;
        Some(Estimate { frame, cost })
    }
}

/// Turns an arc along a line into the reading direction, for a line with uphill on its right (1), left (−1), or unknown
/// (0).
pub(super) fn turned(frame: Frame, side: f64, tops: Tops) -> Frame {
    let is_turned = match tops {
        Tops::Uphill if side != 0.0 => side > 0.0,
        _ => {
            // A vertical number is read upwards, as on the spine of a European book.
            frame.along.x < -1e-9 || frame.along.x < 1e-9 && frame.along.y > 0.0
        }
    };
    if is_turned { frame.reversed() } else { frame }
}

/// Returns the cost of a reading direction, by its angle to the direction from left to right.
fn slant(turn: f64) -> f64 {
    if turn <= FRAC_PI_4 {
        0.0
    } else if turn <= FRAC_PI_2 * 1.001 {
        VERTICAL * (turn / FRAC_PI_4 - 1.0)
    } else {
        TURNED + (UPSIDE_DOWN - TURNED) * (turn / FRAC_PI_2 - 1.0).min(0.5) / 0.5
    }
}

/// Returns an angle between −π and π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

fn sums(samples: &[DVec2]) -> Vec<[f64; 3]> {
    let mut all = Vec::with_capacity(samples.len());
    let (mut sum, mut before) = ([0.0; 3], 0.0_f64);
    all.push(sum);
    for (i, pair) in samples.windows(2).enumerate() {
        // Directions are continued beyond a full turn, so that they can be averaged.
        let way = pair[1] - pair[0];
        let direction = if way == DVec2::ZERO { before } else { before + wrapped(way.to_angle() - before) };
        before = direction;
        sum = [sum[0] + direction, sum[1] + i as f64 * direction, sum[2] + direction * direction];
        all.push(sum);
    }
    all
}

/// Counts the samples where the line turns by more than [`MAX_BEND`] from one letter to the next.
fn sharp_bends(samples: &[DVec2]) -> Vec<u32> {
    let mut all = Vec::with_capacity(samples.len() + 1);
    let mut sum = 0;
    all.push(sum);
    for i in 0..samples.len() {
        let is_inside = i >= 2 && i + 2 < samples.len();
        if is_inside && is_sharp(samples[i] - samples[i - 2], samples[i + 2] - samples[i]) {
            sum += 1;
        }
        all.push(sum);
    }
    all
}

/// Returns whether two directions differ by more than [`MAX_BEND`].
pub(super) fn is_sharp(a: DVec2, b: DVec2) -> bool {
    a.dot(b) < MAX_BEND.cos() * (a.length_squared() * b.length_squared()).sqrt()
}
