//! The most prominent summit of a raster of heights.
//!
//! The prominence of a summit is its height above the highest saddle over which one reaches higher land. Cells are
//! joined from the highest to the lowest into islands, as if the sea fell: where two islands meet, the lower of their
//! summits has its prominence.

use glam::{DVec2, IVec2, UVec2};

use super::raster::Raster;

/// No-data that reaches the edge of the raster is outside of the data if it has this part of its own rim there, and else
/// a hole, such as the shadows of a radar in mountains.
const LEAST_OF_RIM: f64 = 0.3;
/// A summit inside the data is taken if it has this part of the range of heights as its prominence; else the highest
/// point is, which may be on the edge of the data.
const LEAST_PART: f32 = 0.2;
/// The top of a mountain is what is at most this part of its prominence below the summit.
const TOP_PART: f32 = 0.005;
/// Number of places on a ring around a summit.
const RING_PLACES: u32 = 48;
/// Smallest share of a ring that must have data.
const LEAST_OF_RING: f64 = 0.3;

/// A summit of a grid of heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Summit {
    pub cell: UVec2,
    pub height_m: f32,
    pub prominence_m: f32,
    /// Radius of the top around it, in metres.
    pub top_m: f64,
}

const NEIGHBOURS: [IVec2; 8] = [
    IVec2::new(-1, -1),
    IVec2::new(0, -1),
    IVec2::new(1, -1),
    IVec2::new(-1, 0),
    IVec2::new(1, 0),
    IVec2::new(-1, 1),
    IVec2::new(0, 1),
    IVec2::new(1, 1),
];

/// Returns the most prominent summit. Cells on the edge of the data are not summits, since the land may rise beyond it,
/// unless no other summit stands out. Returns `None` without data.
pub(super) fn most_prominent(raster: &Raster) -> Option<Summit> {
    let (_, middle_m) = raster.data()?;
    let heights_m = &raster.heights_m;
    let mut order: Vec<u32> = (0..heights_m.len() as u32).filter(|at| !heights_m[*at as usize].is_nan()).collect();
    let apart = |at: u32| raster.place_m(raster.cell(at as usize)).distance_squared(middle_m);
    // Of several equal heights, such as those of a plain, the one nearest to the middle is the summit.
    order.sort_unstable_by(|a, b| {
        heights_m[*b as usize].total_cmp(&heights_m[*a as usize]).then_with(|| apart(*a).total_cmp(&apart(*b)))
    });
    let lowest_m = heights_m[*order.last()? as usize];
    let relief_m = heights_m[order[0] as usize] - lowest_m;
    let is_outside = outside(raster);
    let mut islands = Islands { parents: vec![u32::MAX; heights_m.len()] };
    let (mut best, mut best_inside): (Option<Summit>, Option<Summit>) = (None, None);
    let mut end = |summit: u32, prominence_m: f32| {
        let cell = raster.cell(summit as usize);
        let found = Summit { cell, height_m: heights_m[summit as usize], prominence_m, top_m: 0.0 };
        let is_more = |known: &Option<Summit>| known.is_none_or(|known| prominence_m > known.prominence_m);
        if is_more(&best) {
            best = Some(found);
        }
        if is_more(&best_inside) && !is_on_edge(raster, &is_outside, cell) {
            best_inside = Some(found);
        }
    };
    for &at in &order {
        islands.parents[at as usize] = at;
        for neighbour in neighbours(raster, raster.cell(at as usize)).flatten() {
            let Some(other) = islands.summit(neighbour) else { continue };
            let mine = islands.summit(at).unwrap_or(at);
            if other == mine {
                continue;
            }
            // The root of an island is its summit. An island of the single cell `at` has none of its own.
            let is_higher = |a: u32, b: u32| {
                let [a_m, b_m] = [heights_m[a as usize], heights_m[b as usize]];
                a_m > b_m || (a_m == b_m && apart(a) < apart(b))
            };
            let (winner, loser) = if mine == at || is_higher(other, mine) { (other, mine) } else { (mine, other) };
            if loser != at {
                end(loser, heights_m[loser as usize] - heights_m[at as usize]);
            }
            islands.parents[loser as usize] = winner;
        }
    }
    // Islands that nothing joins: separated by no-data, or the whole land. They are not higher above other land than
    // above their own: a patch of a valley between holes is not a mountain.
    let mut feet_m = vec![f32::INFINITY; heights_m.len()];
    for &at in &order {
        if let Some(summit) = islands.summit(at) {
            feet_m[summit as usize] = feet_m[summit as usize].min(heights_m[at as usize]);
        }
    }
    for &at in order.iter().filter(|at| islands.parents[**at as usize] == **at) {
        end(at, heights_m[at as usize] - feet_m[at as usize]);
    }
    let found = best_inside.filter(|inside| inside.prominence_m >= LEAST_PART * relief_m).or(best)?;
    let (cell, top_m) = middle_of_top(raster, found);
    Some(Summit { cell, top_m, ..found })
}

/// Returns the cell in the middle of the top around a summit (of a plateau, not one of the cells of its rim), and the
/// distance of the top's farthest cell from it in metres.
fn middle_of_top(raster: &Raster, summit: Summit) -> (UVec2, f64) {
    let least_m = summit.height_m - TOP_PART * summit.prominence_m;
    let first = summit.cell.y * raster.size[0] as u32 + summit.cell.x;
    let (mut top, mut waiting) = (Vec::new(), vec![first]);
    let mut is_known = vec![false; raster.heights_m.len()];
    while let Some(at) = waiting.pop() {
        if std::mem::replace(&mut is_known[at as usize], true) {
            continue;
        }
        top.push(raster.cell(at as usize).as_dvec2());
        let around = neighbours(raster, raster.cell(at as usize)).flatten();
        waiting.extend(around.filter(|at| raster.heights_m[*at as usize] >= least_m && !is_known[*at as usize]));
    }
    let middle = top.iter().sum::<DVec2>() / top.len() as f64;
    let apart = |cell: &DVec2| cell.distance_squared(middle);
    let cell = top.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    let cell = cell.unwrap_or_else(|| summit.cell.as_dvec2());
    let farthest = top.iter().map(|other| other.distance(cell)).fold(0.0, f64::max);
    (cell.as_uvec2(), farthest * raster.cell_m)
}

/// Returns the indices of the cells around a cell; `None` outside of the raster.
fn neighbours(raster: &Raster, cell: UVec2) -> impl Iterator<Item = Option<u32>> + '_ {
    let [width, height] = raster.size;
    NEIGHBOURS.into_iter().map(move |step| {
        let at = cell.as_ivec2() + step;
        let is_inside = at.cmpge(IVec2::ZERO).all() && at.x < width as i32 && at.y < height as i32;
        is_inside.then(|| (at.y as usize * width + at.x as usize) as u32)
    })
}

/// Returns for each cell whether it is outside of the data: without data, and not in a hole in them.
fn outside(raster: &Raster) -> Vec<bool> {
    let has_none = |at: u32| raster.heights_m[at as usize].is_nan();
    let mut is_outside = vec![false; raster.heights_m.len()];
    let mut is_known = is_outside.clone();
    for first in (0..raster.heights_m.len() as u32).filter(|at| has_none(*at)) {
        let (mut patch, mut waiting) = (Vec::new(), vec![first]);
        let (mut on_edge, mut on_data) = (0.0, 0.0);
        while let Some(at) = waiting.pop() {
            if std::mem::replace(&mut is_known[at as usize], true) {
                continue;
            }
            patch.push(at);
            let (mut is_on_edge, mut is_on_data) = (false, false);
            for neighbour in neighbours(raster, raster.cell(at as usize)) {
                match neighbour {
                    None => is_on_edge = true,
                    Some(neighbour) if !has_none(neighbour) => is_on_data = true,
                    Some(neighbour) if !is_known[neighbour as usize] => waiting.push(neighbour),
                    Some(_) => (),
                }
            }
            on_edge += f64::from(u8::from(is_on_edge));
            on_data += f64::from(u8::from(is_on_data));
        }
        if on_edge > LEAST_OF_RIM * (on_edge + on_data) {
            for at in patch {
                is_outside[at as usize] = true;
            }
        }
    }
    is_outside
}

/// Returns whether a neighbour of a cell is outside of the raster or of the data.
fn is_on_edge(raster: &Raster, is_outside: &[bool], cell: UVec2) -> bool {
    neighbours(raster, cell).any(|at| at.is_none_or(|at| is_outside[at as usize]))
}

/// A forest of cells: each points toward the summit of its island. `u32::MAX` is below the sea.
struct Islands {
    parents: Vec<u32>,
}

impl Islands {
    /// Returns the summit of the island of a cell; `None` for a cell below the sea.
    fn summit(&mut self, mut at: u32) -> Option<u32> {
        if self.parents[at as usize] == u32::MAX {
            return None;
        }
        while self.parents[at as usize] != at {
            let above = self.parents[self.parents[at as usize] as usize];
            self.parents[at as usize] = above;
            at = above;
        }
        Some(at)
    }
}

/// Returns the radius of the mountain around a place, in metres, and how far the land falls from `height_m` to that
/// ring: the radius at which the drop of the mean height, divided by the root of the radius, is largest. `None` if the
/// land around is not lower.
pub(super) fn form_of_mountain(
    heights_m: impl Fn(DVec2) -> f64,
    at_m: DVec2,
    height_m: f64,
    radii_m: [f64; 2],
) -> Option<[f64; 2]> {
    let [first_m, last_m] = radii_m;
    let mut best: Option<[f64; 3]> = None;
    let mut radius_m = first_m;
    while radius_m <= last_m {
        let (mut sum_m, mut count) = (0.0, 0.0);
        for place in 0..RING_PLACES {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(place) / f64::from(RING_PLACES)).sin_cos();
            let found_m = heights_m(at_m + radius_m * DVec2::new(sin, cos));
            if !found_m.is_nan() {
                (sum_m, count) = (sum_m + found_m, count + 1.0);
            }
        }
        if count >= LEAST_OF_RING * f64::from(RING_PLACES) {
            let drop_m = height_m - sum_m / count;
            let weight = drop_m / radius_m.sqrt();
            if drop_m > 0.0 && best.is_none_or(|[_, _, known]| weight > known) {
                best = Some([radius_m, drop_m, weight]);
            }
        }
        radius_m *= 1.15;
    }
    best.map(|[radius_m, drop_m, _]| [radius_m, drop_m])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    fn hill(at: [f64; 2], height_m: f64, radius_m: f64) -> impl Fn(f64, f64) -> f64 {
        move |x, y| (height_m * (1.0 - (x - at[0]).hypot(y - at[1]) / radius_m)).max(0.0)
    }

    #[test]
    fn the_prominent_summit_is_not_always_the_highest() {
        let (big, small) = (hill([-300.0, 200.0], 500.0, 400.0), hill([500.0, -300.0], 300.0, 300.0));
        let raster = Raster::of(201, 10.0, |x, y| big(x, y).max(small(x, y)));
        let found = most_prominent(&raster).unwrap();
        let at = raster.place_m(found.cell);
        assert!(at.distance(DVec2::new(-300.0, 200.0)) < 15.0 && found.prominence_m > 480.0, "{found:?} {at}");
        // A ramp at the edge is higher than both, but the land may rise beyond.
        let raster = Raster::of(201, 10.0, |x, y| big(x, y).max(small(x, y)).max(20.0 * (x - 950.0)));
        let found = most_prominent(&raster).unwrap();
        assert!(raster.place_m(found.cell).distance(DVec2::new(-300.0, 200.0)) < 15.0, "{found:?}");
        // The rim of a plateau may be a little higher.
        let plateau = Raster::of(201, 10.0, |x, y| match x.hypot(y - 200.0) {
            away if away > 610.0 => 0.0,
            away if away > 580.0 => 300.5,
            _ => 300.0,
        });
        let at = plateau.place_m(most_prominent(&plateau).unwrap().cell);
        assert!(at.distance(DVec2::new(0.0, 200.0)) < 15.0, "{at}");
        let top_m = most_prominent(&plateau).unwrap().top_m;
        assert!((590.0..630.0).contains(&top_m), "{top_m}");
        // On a plane that is tilted, nothing but the edge stands out; a plain has its middle.
        let tilted = Raster::of(101, 10.0, |x, y| 0.1 * x + 0.05 * y);
        assert_eq!(most_prominent(&tilted).unwrap().cell, UVec2::new(100, 100));
        let plain = Raster::of(101, 10.0, |_, _| 7.0);
        assert_eq!(most_prominent(&plain).unwrap().cell, UVec2::new(50, 50));
        assert_eq!(most_prominent(&Raster::of(9, 1.0, |_, _| f64::NAN)), None);
    }

    #[test]
    fn the_rim_of_a_hole_may_be_a_summit_and_the_edge_is_none() {
        let (main, other) = (hill([-200.0, 0.0], 500.0, 600.0), hill([700.0, 500.0], 300.0, 300.0));
        let land = move |x: f64, y: f64| main(x, y).max(other(x, y));
        let with = |is_cut: fn(f64, f64) -> bool| {
            let raster = Raster::of(201, 10.0, |x, y| if is_cut(x, y) { f64::NAN } else { land(x, y) });
            raster.place_m(most_prominent(&raster).unwrap().cell)
        };
        // The radar saw no summit, but all around it: its mountain is still the most prominent one.
        let found = with(|x, y| (x + 200.0).abs() < 50.0 && y.abs() < 50.0);
        assert!(found.distance(DVec2::new(-200.0, 0.0)) < 80.0, "{found}");
        // A mountain that the border of the data cuts through is not: the remaining part is highest on the edge.
        let found = with(|x, _| x < -150.0);
        assert!(found.distance(DVec2::new(700.0, 500.0)) < 15.0, "{found}");
    }

    #[test]
    fn shadows_of_a_radar_are_holes_even_at_the_edge() {
        let (main, other) = (hill([-300.0, 500.0], 900.0, 900.0), hill([600.0, -600.0], 300.0, 300.0));
        // The hole around the summit reaches the northern edge. A patch of a valley in it is not a mountain, though
        // nothing joins it to higher land.
        let found = {
            let raster = Raster::of(201, 10.0, |x, y| match (x + 300.0).abs().max((y - 720.0).abs() - 200.0) {
                _ if (x + 300.0).hypot(y - 750.0) < 35.0 => 600.0 - 0.1 * (x + 300.0).hypot(y - 750.0),
                away if away < 80.0 => f64::NAN,
                _ => main(x, y).max(other(x, y)),
            });
            raster.place_m(most_prominent(&raster).unwrap().cell)
        };
        assert!((found.x + 300.0).abs() < 100.0 && (400.0..520.0).contains(&found.y), "{found}");
    }

    #[test]
    fn a_cone_has_its_radius() {
        let cone = hill([0.0, 0.0], 800.0, 1000.0);
        let raster = Raster::of(401, 20.0, cone);
        let [radius_m, drop_m] =
            form_of_mountain(|at| raster.height_m(at), DVec2::ZERO, 800.0, [40.0, 4000.0]).unwrap();
        assert!((850.0..1200.0).contains(&radius_m) && drop_m > 650.0, "{radius_m} {drop_m}");
        let hollow = Raster::of(101, 20.0, |x, y| x.hypot(y));
        assert_eq!(form_of_mountain(|at| hollow.height_m(at), DVec2::ZERO, 0.0, [40.0, 900.0]), None);
    }
}
