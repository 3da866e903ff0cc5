//! Lines along which land drains: the samples through which a large area drains, as smooth curves.
//!
//! Each line follows, from its mouth upward, the neighbour through which the larger area drains, so that a main stream is
//! one line, and its tributaries end on it. The eight directions of the flow make stairs; the curves are smoothed over
//! [`SMOOTHINGS`] samples.

use std::ops::Range;

use glam::{DVec2, dvec2};

use super::flow::{Flow, Grid, Sense};

/// Number of times that the mean of neighbouring points (weights 1, 2, 1) is taken: about as many samples are smoothed.
const SMOOTHINGS: usize = 10;
/// Distances in samples at which the land on both sides of a line is compared with the line: the one at which the line
/// stands out more counts.
const ASIDE_SAMPLES: [f64; 2] = [3.0, 8.0];
/// Number of samples before and after a point over which its relief is averaged, so that a line is drawn or left out as a
/// whole.
const ALONG_SAMPLES: usize = 24;
/// Number of points in a row with level land on both sides from which on the land is taken for water, which has no lines.
const LEVEL_POINTS: usize = 12;
const NONE: u32 = u32::MAX;

/// A point of a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Column and row.
    pub place: DVec2,
    pub height_m: f32,
    /// The area that drains through the point.
    pub area_m2: f32,
    /// How steeply the land rises on both sides of a valley, or falls on both sides of a ridge: the tangent of the slope
    /// on the gentler side. Negative if the point is in no valley and on no ridge.
    pub relief: f32,
}

/// Returns the lines through which at least `least_samples` samples drain. Each begins at its mouth, at the point of the
/// line into which it flows if there is one. A line comes after the one into which it flows.
pub(crate) fn lines(grid: &Grid, flow: &Flow, sense: Sense, least_samples: f32) -> Vec<Vec<Point>> {
    let area = |at: u32| flow.areas[at as usize];
    let mut main = vec![NONE; flow.areas.len()];
    for &at in flow.order.iter().filter(|at| area(**at) >= least_samples) {
        let receiver = flow.receivers[at as usize];
        let known = &mut main[receiver as usize];
        if receiver != at && (*known == NONE || area(at) > area(*known)) {
            *known = at;
        }
    }
    let columns = grid.size[0] as u32;
    let sample_m2 = grid.sample_m2();
    let mut smoothed_places: Vec<[f32; 2]> = vec![[f32::NAN; 2]; flow.areas.len()];
    let mut lines = Vec::new();
    for &mouth in flow.order.iter().filter(|at| area(**at) >= least_samples) {
        let receiver = flow.receivers[mouth as usize];
        if receiver != mouth && main[receiver as usize] == mouth {
            continue;
        }
        let mut samples = Vec::new();
        let mut at = mouth;
        while at != NONE {
            samples.push(at);
            at = main[at as usize];
        }
        let place_of = |at: &u32| dvec2(f64::from(at % columns), f64::from(at / columns));
        let mut places: Vec<DVec2> = samples.iter().map(place_of).collect();
        let flows_on = receiver != mouth;
        if flows_on {
            let [x, y] = smoothed_places[receiver as usize].map(f64::from);
            // Receivers come first, so their places are known.
            places.insert(0, dvec2(x, y));
            samples.insert(0, mouth);
        }
        smooth(&mut places);
        for (at, place) in samples.iter().zip(&places).skip(usize::from(flows_on)) {
            smoothed_places[*at as usize] = place.as_vec2().to_array();
        }
        if places.len() < 3 {
            continue;
        }
        let sides: Vec<Sides> = (0..places.len()).map(|index| sides_of(grid, sense, &places, index)).collect();
        let reliefs = averaged(&sides.iter().map(|sides| sides.relief).collect::<Vec<_>>());
        let point = |index: usize| {
            let place = places[index];
            let height_m = grid.height_m(place)? as f32;
            let area_m2 = (f64::from(area(samples[index])) * sample_m2) as f32;
            Some(Point { place, height_m, area_m2, relief: reliefs[index] as f32 })
        };
        for piece in beside_water(&sides) {
            let points: Vec<Point> = piece.filter_map(point).collect();
            if points.len() >= 2 {
                lines.push(points);
            }
        }
    }
    lines
}

/// The land on both sides of a point of a line.
#[derive(Clone, Copy, Debug, Default)]
struct Sides {
    /// See [`Point::relief`].
    relief: f64,
    /// Whether the land on both sides is as high as the point.
    is_level: bool,
}

/// Returns the parts of a line that are not on water, given the land on both sides of its points.
fn beside_water(sides: &[Sides]) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let (mut start, mut level) = (0, 0);
    for (index, sides) in sides.iter().enumerate() {
        if sides.is_level {
            level += 1;
            if level == LEVEL_POINTS {
                parts.push(start..index + 1 - level);
            }
        } else {
            if level >= LEVEL_POINTS {
                start = index;
            }
            level = 0;
        }
    }
    if level < LEVEL_POINTS {
        parts.push(start..sides.len());
    }
    parts.retain(|part| part.len() >= 2);
    parts
}

/// Replaces each value but the first and the last by the mean around it, [`SMOOTHINGS`] times.
fn smooth<T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>>(values: &mut [T]) {
    for _ in 0..SMOOTHINGS {
        let Some(&first) = values.first() else { return };
        let mut before = first;
        for index in 1..values.len().saturating_sub(1) {
            let own = values[index];
            values[index] = before * 0.25 + own * 0.5 + values[index + 1] * 0.25;
            before = own;
        }
    }
}

/// Returns the land on both sides of a point. Where there is none it has no relief, and is not level.
fn sides_of(grid: &Grid, sense: Sense, places: &[DVec2], index: usize) -> Sides {
    let sign = if sense == Sense::Down { 1.0 } else { -1.0 };
    let step_m = DVec2::from_array(grid.step_m);
    let along = places[(index + 1).min(places.len() - 1)] - places[index.saturating_sub(1)];
    let rises = |aside: f64| {
        let away_m = aside * step_m.min_element();
        let across = (along * step_m).perp().normalize_or_zero() * away_m / step_m;
        let own_m = grid.height_m(places[index])?;
        let rise = |way: f64| Some(sign * (grid.height_m(places[index] + across * way)? - own_m) / away_m);
        Some([rise(1.0)?, rise(-1.0)?])
    };
    let known: Vec<[f64; 2]> = ASIDE_SAMPLES.into_iter().filter_map(rises).collect();
    let relief = known.iter().map(|[left, right]| left.min(*right)).reduce(f64::max).unwrap_or(0.0);
    Sides { relief, is_level: !known.is_empty() && known.iter().flatten().all(|rise| *rise == 0.0) }
}

/// Returns the mean of [`ALONG_SAMPLES`] values before and after each value.
fn averaged(values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, value| {
        *sum += value;
        Some(*sum)
    }));
    let mean = |index: usize| {
        let (first, end) = (index.saturating_sub(ALONG_SAMPLES), (index + ALONG_SAMPLES + 1).min(values.len()));
        (sums[end] - sums[first]) / (end - first) as f64
    };
    (0..values.len()).map(mean).collect()
}

impl Grid {
    /// Returns the height at a place by bilinear interpolation; `None` beyond the grid and next to samples without land.
    fn height_m(&self, place: DVec2) -> Option<f64> {
        let last = dvec2((self.size[0] - 1) as f64, (self.size[1] - 1) as f64);
        if place.cmplt(DVec2::ZERO).any() || place.cmpgt(last).any() || place.is_nan() {
            return None;
        }
        let corner = place.floor().min(last - DVec2::ONE).max(DVec2::ZERO);
        let part = place - corner;
        let at = |dx: usize, dy: usize| {
            let [x, y] = [corner.x as usize + dx, corner.y as usize + dy];
            let index = y.min(self.size[1] - 1) * self.size[0] + x.min(self.size[0] - 1);
            f64::from(self.heights_m[index])
        };
        let [upper, lower] = [0, 1].map(|dy| at(0, dy) + (at(1, dy) - at(0, dy)) * part.x);
        let height_m = upper + (lower - upper) * part.y;
        (!height_m.is_nan()).then_some(height_m)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    /// A valley that winds down along y, with ridges halfway between its repetitions.
    fn winding(side: usize) -> Grid {
        let middle = |y: f64| 30.0 + 8.0 * (y / 9.0).sin();
        let heights_m = (0..side * side).map(|i| {
            let [x, y] = [(i % side) as f64, (i / side) as f64];
            let away = (x - middle(y)) / 30.0;
            (40.0 * (1.0 - (std::f64::consts::TAU * away).cos()) + 0.5 * y) as f32
        });
        Grid { size: [side; 2], step_m: [10.0; 2], heights_m: heights_m.collect() }
    }

    /// Returns the largest and the mean distance, in samples, of the longest line from the middle of the valley or from
    /// the ridge beside it. The ends, within ten samples of the border, do not count.
    fn off(sense: Sense, aside: f64) -> [f64; 2] {
        let grid = winding(120);
        let flow = Flow::over(&grid, sense);
        let found = lines(&grid, &flow, sense, 60.0);
        let middle = |y: f64| 30.0 + 8.0 * (y / 9.0).sin();
        let inside = |point: &&Point| (10.0..110.0).contains(&point.place.y) && (5.0..115.0).contains(&point.place.x);
        let off = |point: &Point| ((point.place.x - middle(point.place.y)) / 30.0 - aside).rem_euclid(1.0);
        let off = |point: &Point| 30.0 * off(point).min(1.0 - off(point));
        let line = found.iter().max_by_key(|line| line.len()).unwrap();
        let all: Vec<f64> = line.iter().filter(inside).map(off).collect();
        assert!(all.len() > 30, "{} points", all.len());
        assert!(line.iter().filter(inside).all(|point| point.relief > 0.1), "a line of no relief");
        [all.iter().copied().fold(0.0, f64::max), all.iter().sum::<f64>() / all.len() as f64]
    }

    #[test]
    fn lines_follow_valleys_and_ridges() {
        for (sense, aside) in [(Sense::Down, 0.0), (Sense::Up, 0.5)] {
            let [most, mean] = off(sense, aside);
            assert!(most < 2.0 && mean < 0.7, "{sense:?}: at most {most} samples, {mean} in the mean");
            // Planted: the other kind of line is half a period away.
            assert!(off(sense, 0.5 - aside)[1] > 10.0);
        }
    }

    #[test]
    fn tributaries_end_on_the_line_that_they_flow_into() {
        let grid = winding(120);
        let flow = Flow::over(&grid, Sense::Down);
        let found = lines(&grid, &flow, Sense::Down, 20.0);
        let far = |line: &Vec<Point>| {
            let mouth = line[0].place;
            let border = mouth.min(dvec2(119.0, 119.0) - mouth).min_element();
            let nearest = |other: &Vec<Point>| {
                other
                    .windows(2)
                    .map(|ends| {
                        let along = ends[1].place - ends[0].place;
                        let part = ((mouth - ends[0].place).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                        mouth.distance(ends[0].place + along * part)
                    })
                    .fold(f64::INFINITY, f64::min)
            };
            let others = found.iter().filter(|other| !std::ptr::eq(*other, line)).map(nearest);
            if border < 1.0 { 0.0 } else { others.fold(f64::INFINITY, f64::min) }
        };
        assert!(found.len() > 10);
        for line in &found {
            assert!(far(line) < 0.3, "a mouth at {} is {} samples from every line", line[0].place, far(line));
        }
    }

    #[test]
    fn lines_end_at_water() {
        let ends = |sides: &[Sides]| -> Vec<[usize; 2]> {
            beside_water(sides).into_iter().map(|part| [part.start, part.end]).collect()
        };
        let level = Sides { relief: 0.0, is_level: true };
        let with = |points: usize| {
            let mut sides = vec![Sides { relief: 0.1, is_level: false }; 60];
            sides[20..20 + points].fill(level);
            ends(&sides)
        };
        assert_eq!(with(30), [[0, 20], [50, 60]]);
        assert_eq!(with(40), [[0, 20]]);
        // A few level points are a plain, not a lake.
        assert_eq!(with(LEVEL_POINTS - 1), [[0, 60]]);
        assert!(ends(&[level; 40]).is_empty());
        // Land that is level on one side only, or unknown, is no water.
        let grid = Grid {
            size: [40, 9],
            step_m: [1.0; 2],
            heights_m: (0..360).map(|i| (i / 40_usize).saturating_sub(4) as f32).collect(),
        };
        let places: Vec<DVec2> = (0..40).map(|x| dvec2(f64::from(x), 4.0)).collect();
        assert!((0..40).all(|index| !sides_of(&grid, Sense::Down, &places, index).is_level));
    }

    #[test]
    fn areas_grow_toward_the_mouth() {
        let grid = winding(90);
        let flow = Flow::over(&grid, Sense::Down);
        for line in lines(&grid, &flow, Sense::Down, 20.0) {
            assert!(line.windows(2).all(|pair| pair[0].area_m2 >= pair[1].area_m2));
        }
    }
}
