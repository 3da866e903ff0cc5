//! Measures the sub-pixel position and the width of lines from their ink.

use super::InkPicture;
use super::follow::Chain;
use crate::lines::strokes::polylines::{Polyline, PolylinePoint};

/// Pixels with less ink are ignored.
const MIN_INK: f32 = 0.03;
/// Lines with less ink, in pixels, are dropped as speckle.
const CRUMB_PX: f32 = 0.7;
/// Number of pixels on each side over which position and width of a line are averaged.
const AROUND: usize = 4;
/// Points of a line are at least [`APART_PX`] apart and turn by less than the angle with the cosine [`FORWARD`]; points
/// more than [`TURN_PX`] apart may turn more.
const APART_PX: f32 = 1.5;
const FORWARD: f32 = 0.4;
const TURN_PX: f32 = 2.5;
/// Ink of a round end, divided by its squared width.
const HALF_CAP: f32 = std::f32::consts::FRAC_PI_8;
/// A line shorter than this fraction of its width is a dot.
const DOT_PART: f32 = 0.5;
/// Length of the line that stands for a dot; some programs skip lines of zero length.
const DOT_PX: f32 = 0.1;

/// The ink assigned to a pixel of a line, and the ink-weighted sums of its coordinates.
#[derive(Clone, Copy, Default)]
struct Ink {
    sum: f32,
    x: f32,
    y: f32,
}

impl Ink {
    fn with(self, other: &Self) -> Self {
        Self { sum: self.sum + other.sum, x: self.x + other.x, y: self.y + other.y }
    }
}

/// Returns a line for each chain. Indices of chains are those of a mask with a border of one pixel.
pub(super) fn polylines(picture: &InkPicture, chains: &[Chain]) -> Vec<Polyline> {
    let owned = given(picture, chains);
    let mut first = 0;
    let lines = chains.iter().filter_map(|chain| {
        let ink = &owned[first..first + chain.places.len()];
        first += chain.places.len();
        line(ink, chain.is_closed)
    });
    lines.collect()
}

/// Returns a dot for each area.
pub(super) fn dots(picture: &InkPicture, areas: &[Chain]) -> Vec<Polyline> {
    let owned = given(picture, areas);
    let mut first = 0;
    let dots = areas.iter().filter_map(|area| {
        let ink = &owned[first..first + area.places.len()];
        first += area.places.len();
        let sum = ink.iter().fold(Ink::default(), Ink::with);
        (sum.sum >= CRUMB_PX).then(|| dot(sum))
    });
    dots.collect()
}

/// Returns a dot whose area is its ink.
fn dot(ink: Ink) -> Polyline {
    let [x, y] = [ink.x / ink.sum, ink.y / ink.sum];
    let half_width_px = (ink.sum / std::f32::consts::PI).sqrt();
    let end = |aside: f32| PolylinePoint { px: [x + aside, y], half_width_px, ink: 1.0 };
    Polyline { points: vec![end(-0.5 * DOT_PX), end(0.5 * DOT_PX)], ..Polyline::default() }
}

/// Assigns each pixel of ink to the nearest pixel of a chain, by steps from pixel to pixel. Returns the ink of all
/// pixels of all chains, in order.
fn given(picture: &InkPicture, chains: &[Chain]) -> Vec<Ink> {
    let (width, stride) = (picture.width(), picture.width() + 2);
    let count = chains.iter().map(|chain| chain.places.len()).sum();
    let mut owned = vec![Ink::default(); count];
    let mut is_given = vec![false; picture.ink.len()];
    let places = chains.iter().flat_map(|chain| &chain.places);
    let mut edge: Vec<(usize, u32)> =
        places.zip(0..).map(|(place, owner)| ((place / stride - 1) * width + place % stride - 1, owner)).collect();
    edge.retain(|(pixel, _)| !std::mem::replace(&mut is_given[*pixel], true));
    let rows = picture.ink.len().checked_div(width).unwrap_or(0);
    while !edge.is_empty() {
        let mut next = Vec::new();
        for &(pixel, owner) in &edge {
            let (x, y, ink) = (pixel % width, pixel / width, picture.ink[pixel]);
            let own = &mut owned[owner as usize];
            own.sum += ink;
            own.x += ink * (x as f32 + 0.5);
            own.y += ink * (y as f32 + 0.5);
            for there in y.saturating_sub(1)..(y + 2).min(rows) {
                for across in x.saturating_sub(1)..(x + 2).min(width) {
                    let other = there * width + across;
                    if !is_given[other] && picture.ink[other] > MIN_INK {
                        is_given[other] = true;
                        next.push((other, owner));
                    }
                }
            }
        }
        edge = next;
    }
    owned
}

fn line(ink: &[Ink], is_closed: bool) -> Option<Polyline> {
    let sum = ink.iter().fold(Ink::default(), Ink::with);
    if sum.sum < CRUMB_PX {
        return None;
    }
    let (points, shares) = points(ink, is_closed);
    let lengths = steps(&points, is_closed);
    let length = lengths.iter().sum::<f32>();
    // The mean width, from a line of constant width with round ends: length * width + pi / 4 * width^2 = ink.
    let caps = if is_closed { 0.0 } else { 2.0 * HALF_CAP };
    let mean = if is_closed {
        sum.sum / length.max(1e-3)
    } else {
        ((length * length + 4.0 * caps * sum.sum).sqrt() - length) / (2.0 * caps)
    };
    if length < DOT_PART * mean || points.len() < 2 {
        return Some(dot(sum));
    }
    let widths = widths(&shares, &lengths, is_closed, mean);
    let point = |(px, width): (&[f32; 2], f32)| PolylinePoint { px: *px, half_width_px: 0.5 * width, ink: 1.0 };
    Some(Polyline { points: points.iter().zip(widths).map(point).collect(), is_closed, ..Polyline::default() })
}

/// Returns points at the centroids of the ink along a chain, spaced so that they go forward, and the ink of each point.
fn points(ink: &[Ink], is_closed: bool) -> (Vec<[f32; 2]>, Vec<f32>) {
    let count = ink.len();
    let (mut points, mut shares): (Vec<[f32; 2]>, Vec<f32>) = (Vec::new(), Vec::new());
    for i in 0..count {
        // The window is symmetric, so that the ends of the line do not move.
        let reach = if is_closed { AROUND.min(count / 2) } else { AROUND.min(i).min(count - 1 - i) };
        let near = (0..=2 * reach).map(|k| &ink[(i + count + k - reach) % count]);
        let near = near.fold(Ink::default(), |sum, one| sum.with(one));
        let px = [near.x / near.sum.max(1e-6), near.y / near.sum.max(1e-6)];
        let goes_on = match points.as_slice() {
            [] => true,
            [first] => distance(*first, px) >= APART_PX,
            [.., before, last] => {
                let [a, b] = [way(*before, *last), way(*last, px)];
                let away = distance(*last, px);
                let is_forward = a[0] * b[0] + a[1] * b[1] > FORWARD * away * distance(*before, *last);
                away >= APART_PX && is_forward || away >= TURN_PX
            }
        };
        if goes_on && near.sum > 0.0 {
            points.push(px);
            shares.push(0.0);
        } else if i + 1 == count && !is_closed && near.sum > 0.0 && points.len() > 1 {
            // The end of the line replaces a point that is too close to it.
            let last = points.len() - 1;
            points[last] = px;
        }
        if let Some(share) = shares.last_mut() {
            *share += ink[i].sum;
        }
    }
    (points, shares)
}

fn way(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [b[0] - a[0], b[1] - a[1]]
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    let [x, y] = way(a, b);
    x.hypot(y)
}

/// Returns the distance from each point to the next; for a closed line also from the last to the first.
fn steps(points: &[[f32; 2]], is_closed: bool) -> Vec<f32> {
    let next = points.iter().cycle().skip(1);
    let count = if is_closed { points.len() } else { points.len().saturating_sub(1) };
    points.iter().zip(next).take(count).map(|(a, b)| distance(*a, *b)).collect()
}

/// Returns the width at each point: the ink divided by the length around it, scaled so that the line has all of its
/// ink.
fn widths(shares: &[f32], lengths: &[f32], is_closed: bool, mean: f32) -> Vec<f32> {
    let count = shares.len();
    // Half of the steps on both sides; at an end, the round cap adds some length.
    let own_length = |at: usize| {
        let before =
            if at > 0 { lengths[at - 1] } else { lengths.last().copied().filter(|_| is_closed).unwrap_or(0.0) };
        let after = lengths.get(at).copied().unwrap_or(0.0);
        let is_end = !is_closed && (at == 0 || at + 1 == count);
        0.5 * (before + after) + if is_end { HALF_CAP * mean } else { 0.0 }
    };
    let of = |i: usize| -> f32 {
        let all = if is_closed {
            0..=2 * AROUND
        } else {
            AROUND.saturating_sub(i)..=(AROUND + count - 1 - i).min(2 * AROUND)
        };
        let near = all.map(|k| (i + k + count * AROUND - AROUND) % count);
        let (ink, length) = near.fold((0.0, 0.0), |(ink, length), at| (ink + shares[at], length + own_length(at)));
        ink / length.max(0.25)
    };
    let mut widths: Vec<f32> = (0..count).map(of).collect();
    let next = widths.iter().cycle().skip(1);
    let drawn: f32 = widths.iter().zip(next).zip(lengths).map(|((a, b), length)| 0.5 * (a + b) * length).sum();
    let ends = if is_closed { 0.0 } else { HALF_CAP * (widths[0].powi(2) + widths[count - 1].powi(2)) };
    let gain = shares.iter().sum::<f32>() / (drawn + ends).max(1e-3);
    widths.iter_mut().for_each(|width| *width *= gain.clamp(0.5, 2.0));
    widths
}
