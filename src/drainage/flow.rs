//! Where water would flow: for each sample of a grid, the neighbour that receives its water, and the area that drains
//! through it.
//!
//! The search starts at the border of the land, and always goes on from the lowest sample that it has reached: so it comes
//! into a depression over its lowest pass, and follows the valley down to the bottom (A* search by height: Ehlschlaeger
//! 1989, "Using the A^T Search Algorithm to Develop Hydrologic Models from Digital Elevation Data"). Each sample drains
//! along the way by which the search came, or, if one of the eight samples around it that the search reached before is
//! lower, to the one to which it falls most steeply (O'Callaghan and Mark 1984, "The Extraction of Drainage Networks from
//! Digital Elevation Data"). Nothing is filled, so water leaves a depression along its valley and not straight across, as
//! it would on a filled surface. That matters most for ridges: on the inverted land, each summit is a depression.
//!
//! The same on the inverted land finds ridges: what "flows" there climbs along divides, from pass to summit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Steps to the eight neighbours, in columns and rows.
const AROUND: [[i32; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];

/// Heights on a regular grid.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    /// Number of columns and rows.
    pub size: [usize; 2],
    /// Distance of samples along rows and columns, in metres.
    pub step_m: [f64; 2],
    /// Heights in metres, row by row; NaN where there is no land.
    pub heights_m: Vec<f32>,
}

impl Grid {
    /// Calls `take` with each neighbour on the grid: its index, and its distance in metres.
    fn for_neighbours(&self, at: u32, mut take: impl FnMut(u32, f64)) {
        let [columns, rows] = self.size.map(|side| side as i32);
        let [x, y] = [at as i32 % columns, at as i32 / columns];
        for [dx, dy] in AROUND {
            let [x, y] = [x + dx, y + dy];
            if (0..columns).contains(&x) && (0..rows).contains(&y) {
                let away_m = (f64::from(dx) * self.step_m[0]).hypot(f64::from(dy) * self.step_m[1]);
                take((y * columns + x) as u32, away_m);
            }
        }
    }

    /// Returns the area of a sample in m².
    pub(crate) fn sample_m2(&self) -> f64 {
        self.step_m[0] * self.step_m[1]
    }
}

/// Which way the land is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    /// Water flows down, in valleys.
    Down,
    /// The inverted land: ridges are its valleys.
    Up,
}

/// The flow over a grid.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    /// The sample that receives the water of each sample; itself where water leaves the land.
    pub receivers: Vec<u32>,
    /// The area that drains through each sample, its own included, in samples.
    pub areas: Vec<f32>,
    /// All samples of the land, each after its receiver.
    pub order: Vec<u32>,
}

impl Flow {
    /// Computes the flow over a grid of less than 2³¹ samples.
    pub(crate) fn over(grid: &Grid, sense: Sense) -> Self {
        let sign = if sense == Sense::Down { 1.0 } else { -1.0 };
        let land: Vec<f32> = grid.heights_m.iter().map(|height_m| sign * height_m).collect();
        let (order, mut receivers) = search(grid, &land);
        let mut turns = vec![u32::MAX; land.len()];
        for (turn, &at) in (0..).zip(&order) {
            let own = land[at as usize];
            let (mut steepest, mut most) = (receivers[at as usize], 0.0);
            grid.for_neighbours(at, |other, away_m| {
                let fall = f64::from(own - land[other as usize]) / away_m;
                if fall > most && turns[other as usize] < turn {
                    (steepest, most) = (other, fall);
                }
            });
            receivers[at as usize] = steepest;
            turns[at as usize] = turn;
        }
        let mut areas = vec![1.0; land.len()];
        for &at in order.iter().rev() {
            let receiver = receivers[at as usize];
            if receiver != at {
                areas[receiver as usize] += areas[at as usize];
            }
        }
        Self { receivers, areas, order }
    }
}

/// Searches the land from its border. Returns all of its samples in the order in which the search left them, and for each
/// the sample from which it was reached: itself on the border.
fn search(grid: &Grid, land: &[f32]) -> (Vec<u32>, Vec<u32>) {
    let count = land.len() as u32;
    let mut receivers: Vec<u32> = (0..count).collect();
    let mut order = Vec::with_capacity(land.len());
    let mut is_reached: Vec<bool> = land.iter().map(|height| height.is_nan()).collect();
    let mut reached: BinaryHeap<Reverse<(u32, u32)>> = BinaryHeap::new();
    for at in (0..count).filter(|at| !land[*at as usize].is_nan()) {
        let mut around = 0;
        grid.for_neighbours(at, |other, _| around += i32::from(!land[other as usize].is_nan()));
        if around < 8 {
            is_reached[at as usize] = true;
            reached.push(Reverse((ordered(land[at as usize]), at)));
        }
    }
    while let Some(Reverse((_, at))) = reached.pop() {
        order.push(at);
        grid.for_neighbours(at, |other, _| {
            if !std::mem::replace(&mut is_reached[other as usize], true) {
                receivers[other as usize] = at;
                reached.push(Reverse((ordered(land[other as usize]), other)));
            }
        });
    }
    (order, receivers)
}

/// Returns a number that is ordered as the heights are.
fn ordered(height: f32) -> u32 {
    let bits = height.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(side: usize, height_m: impl Fn(f64, f64) -> f64) -> Grid {
        let heights_m = (0..side * side).map(|i| height_m((i % side) as f64, (i / side) as f64) as f32).collect();
        Grid { size: [side; 2], step_m: [10.0; 2], heights_m }
    }

    /// Checks what holds for every flow: each sample is listed once, after its receiver, and no water is lost.
    fn check(grid: &Grid, flow: &Flow) {
        let mut place = vec![usize::MAX; grid.heights_m.len()];
        for (turn, &at) in flow.order.iter().enumerate() {
            assert_eq!(std::mem::replace(&mut place[at as usize], turn), usize::MAX);
        }
        let land = grid.heights_m.iter().filter(|height_m| !height_m.is_nan()).count();
        assert_eq!(flow.order.len(), land);
        let mut out = 0.0;
        for &at in &flow.order {
            let receiver = flow.receivers[at as usize];
            if receiver == at {
                out += f64::from(flow.areas[at as usize]);
            } else {
                assert!(place[receiver as usize] < place[at as usize], "{at} is before its receiver {receiver}");
            }
        }
        assert_eq!(out, land as f64);
    }

    #[test]
    fn a_valley_gathers_the_water_of_its_sides() {
        let land = grid(41, |x, y| (x - 20.0).abs() * 5.0 + y);
        let flow = Flow::over(&land, Sense::Down);
        check(&land, &flow);
        // All but the samples of the border rows, whose water leaves at once, reach the valley.
        let outlet = flow.areas[20];
        assert!(outlet > 0.9 * 41.0 * 41.0, "{outlet}");
        // Planted: the ridges of the same land are elsewhere.
        let ridges = Flow::over(&land, Sense::Up);
        check(&land, &ridges);
        assert!(ridges.areas[20] < 50.0, "{}", ridges.areas[20]);
    }

    #[test]
    fn a_depression_flows_over_its_lowest_pass() {
        // A bowl with one notch in its wall, and a hole without data.
        let land = grid(31, |x, y| {
            let away = (x - 15.0).hypot(y - 15.0);
            let wall = if away > 12.0 { 40.0 - away } else { away };
            if (x, y) == (3.0, 20.0) {
                f64::NAN
            } else if (y - 15.0).abs() < 0.5 && x > 15.0 {
                wall.min(10.0 - 0.1 * x)
            } else {
                wall
            }
        });
        let flow = Flow::over(&land, Sense::Down);
        check(&land, &flow);
        let through = |x: usize, y: usize| flow.areas[y * 31 + x];
        assert!(through(28, 15) > 350.0, "{} samples drain through the notch", through(28, 15));
        // Planted: nothing drains through the wall elsewhere.
        assert!(through(2, 15) < 60.0, "{} samples drain through the wall", through(2, 15));
    }

    #[test]
    fn random_land_loses_no_water() {
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64
        };
        let heights: Vec<f64> = (0..64 * 64).map(|_| (random() / 2e4).floor() - 300.0).collect();
        let land = grid(64, |x, y| {
            if heights[(y * 64.0 + x) as usize] < -260.0 { f64::NAN } else { heights[(y * 64.0 + x) as usize] }
        });
        for sense in [Sense::Down, Sense::Up] {
            check(&land, &Flow::over(&land, sense));
        }
    }
}
