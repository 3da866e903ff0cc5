//! The rule that scatters models over the land ([`Scatter`]).
//!
//! Models are placed at the points of forests ([`crate::forest::points`]), in tiles whose size follows from the
//! density: at most all points of a tile and at least a quarter of them are tested, so that the tested part of their
//! order is always evenly distributed. A given number of models is found by testing more and more points, in order of
//! rank, and keeping those of lowest rank.
//!
//! Whether a point is taken depends only on the rule, the model's name and the land, never on the other models of a
//! scene or on their order. Points are tested tile by tile, because heights are read in tiles, too.

use glam::{DVec2, DVec3};

use crate::forest::points::{Point, Points};
use crate::forest::{POINTS, TILE_M};
use crate::scene::{Density, Scatter};

/// For a given number of models, at least this many times as many points are tested.
const POINTS_FOR_EACH: f64 = 16.0;
/// For a given number of models, the first step tests this fraction of the points: 1 / 16.
const FIRST_SHARE: u32 = 16;

/// The placement of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    /// Position of the model's origin in the world, in metres.
    pub at_m: DVec3,
    /// Rotation clockwise as seen from above, in degrees.
    pub turn_deg: f64,
    /// World metres per unit of the model.
    pub scale: f64,
}

/// A point where the land satisfies the rule.
struct Found {
    /// Number in the order of its tile, then a random number of its own.
    rank: (u32, u64),
    spot: Spot,
}

/// The points of a rule.
struct ScatterPoints<'a> {
    scatter: &'a Scatter,
    /// The points of a tile, in order of their numbers.
    points: &'a [Point],
    side_m: f64,
    /// Corner of tile 0, 0, in metres.
    first_m: DVec2,
    seed: u64,
}

/// Returns the placements of a rule's models. `name` is the model's name, which seeds the points, so that two models
/// with one rule get different places. `ground_m` returns the height of a place in metres, or `None` where there is no
/// land; slopes are measured over `spacing_m` to both sides.
pub(crate) fn scattered(
    scatter: &Scatter,
    name: &str,
    points: &Points,
    spacing_m: f64,
    ground_m: &impl Fn(DVec2) -> Option<f64>,
) -> Vec<Spot> {
    let mut points: Vec<Point> = points.points[..POINTS as usize].to_vec();
    points.sort_by_key(|point| point.number);
    // FNV-1a.
    let of_name = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    let seed = mixed(of_name ^ mixed(u64::from(scatter.seed)));
    let area_m2 = scatter.area_ha() * 1e4;
    // Points per square metre, if all points of a tile are tested.
    let least = match scatter.density {
        Density::PerHa(per_ha) => per_ha * 1e-4,
        Density::Count(count) => POINTS_FOR_EACH * f64::from(count) / area_m2,
    };
    let of_tile = f64::from(POINTS) / (TILE_M * TILE_M);
    let side_m = TILE_M * (0.5 * (of_tile / least).log2()).floor().exp2();
    let shift = DVec2::new(part(mixed(seed ^ 1)), part(mixed(seed ^ 2)));
    let candidates = ScatterPoints { scatter, points: &points, side_m, first_m: -shift * side_m, seed };
    let passes = |found: &Spot| is_allowed(scatter, found.at_m, spacing_m, ground_m);
    let mut found = match scatter.density {
        Density::PerHa(_) => {
            let below = (least * side_m * side_m).round() as u32;
            candidates.find(0..below.min(POINTS), &passes, ground_m)
        }
        Density::Count(count) => {
            let mut found = Vec::new();
            let (mut from, mut to) = (0, POINTS / FIRST_SHARE);
            while from < POINTS && found.len() < count as usize {
                found.extend(candidates.find(from..to, &passes, ground_m));
                (from, to) = (to, (2 * to).min(POINTS));
            }
            found.sort_by_key(|found| found.rank);
            found.truncate(count as usize);
            found
        }
    };
    found.sort_by_key(|found| found.rank);
    found.into_iter().map(|found| found.spot).collect()
}

/// Returns whether the height and slope of the ground below a model satisfy the rule.
fn is_allowed(scatter: &Scatter, at_m: DVec3, step_m: f64, ground_m: &impl Fn(DVec2) -> Option<f64>) -> bool {
    let height_m = at_m.z - scatter.up_m;
    if !(scatter.heights_m[0]..=scatter.heights_m[1]).contains(&height_m) {
        return false;
    }
    let Some(steepest_deg) = scatter.steepest_deg else { return true };
    let rise = |way: DVec2| {
        let at = |side: f64| ground_m(at_m.truncate() + way * (side * step_m));
        Some((at(1.0)? - at(-1.0)?) / (2.0 * step_m))
    };
    // Next to a hole the slope is unknown.
    let slope = rise(DVec2::X).zip(rise(DVec2::Y));
    slope.is_some_and(|(east, north)| east.hypot(north).atan().to_degrees() <= steepest_deg)
}

impl ScatterPoints<'_> {
    /// Returns the points with these numbers where the land satisfies the rule.
    fn find(
        &self,
        numbers: std::ops::Range<u32>,
        passes: &impl Fn(&Spot) -> bool,
        ground_m: &impl Fn(DVec2) -> Option<f64>,
    ) -> Vec<Found> {
        let Self { scatter, side_m, first_m, .. } = *self;
        let [west, south, east, north] = scatter.within_m;
        let tile_of =
            |east_m: f64, north_m: f64| ((DVec2::new(east_m, north_m) - first_m) / side_m).floor().as_i64vec2();
        let (first, last) = (tile_of(west, south), tile_of(east, north));
        let mut found = Vec::new();
        for (row, column) in (first.y..=last.y).flat_map(|row| (first.x..=last.x).map(move |column| (row, column))) {
            let corner_m = first_m + DVec2::new(column as f64, row as f64) * side_m;
            for point in &self.points[numbers.start as usize..numbers.end as usize] {
                let at_m = corner_m + DVec2::from_array(point.at) * side_m;
                // Neighbouring tiles share no border.
                if !((west..east).contains(&at_m.x) && (south..north).contains(&at_m.y)) {
                    continue;
                }
                let Some(height_m) = ground_m(at_m) else { continue };
                let own = mixed(mixed(mixed(self.seed ^ column as u64) ^ row as u64) ^ u64::from(point.number));
                let between = |[low, high]: [f64; 2], salt: u64| low + (high - low) * part(mixed(own ^ salt));
                let spot = Spot {
                    at_m: at_m.extend(height_m + scatter.up_m),
                    turn_deg: between(scatter.turn_deg, 3),
                    scale: between(scatter.scale, 4),
                };
                if passes(&spot) {
                    found.push(Found { rank: (point.number, own), spot });
                }
            }
        }
        found
    }
}

/// A step of SplitMix64 (Steele, Lea, Flood 2014), which also generates the points of forests.
fn mixed(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Converts a random number to the range from 0 to 1.
fn part(value: u64) -> f64 {
    (value >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const WITHIN_M: [f64; 4] = [-700.0, -300.0, 500.0, 900.0];

    fn rule(density: Density) -> Scatter {
        Scatter {
            density,
            within_m: WITHIN_M,
            heights_m: [-1e6, 1e6],
            steepest_deg: None,
            seed: 1,
            scale: [0.8, 1.2],
            turn_deg: [0.0, 360.0],
            up_m: 0.0,
        }
    }

    /// Returns the height of a land that rises to the east, more and more steeply, and has a hole.
    fn ground_m(at_m: DVec2) -> Option<f64> {
        let is_hole = at_m.distance(DVec2::new(-300.0, 200.0)) < 80.0;
        (!is_hole).then(|| (at_m.x + 700.0).powi(2) / 2400.0)
    }

    fn slope_deg(at_m: DVec3) -> f64 {
        ((at_m.x + 700.0) / 1200.0).atan().to_degrees()
    }

    /// Returns the smallest distance, relative to the largest that this many points on the area could have.
    fn evenness(spots: &[Spot], area_m2: f64) -> f64 {
        let max_m = (2.0 * area_m2 / (3.0_f64.sqrt() * spots.len() as f64)).sqrt();
        let places: Vec<DVec2> = spots.iter().map(|spot| spot.at_m.truncate()).collect();
        let of = |(i, a): (usize, &DVec2)| places[i + 1..].iter().map(|b| a.distance(*b)).fold(1e9, f64::min);
        places.iter().enumerate().map(of).fold(1e9, f64::min) / max_m
    }

    #[test]
    fn models_are_spread_evenly_within_bounds_by_density_and_by_number() {
        let points = Points::new();
        let area_m2 = 1200.0 * 1200.0;
        let everywhere = |_: DVec2| Some(7.0);
        for density in [0.3, 2.0, 7.1, 25.0] {
            let spots = scattered(&rule(Density::PerHa(density)), "hut.obj", &points, 10.0, &everywhere);
            let wanted = density * area_m2 * 1e-4;
            let off = (spots.len() as f64 - wanted).abs();
            // The number in a box varies with its border.
            assert!(off <= 3.0 + 1.5 * wanted.sqrt(), "{density}: {} of {wanted}", spots.len());
            assert!(evenness(&spots, area_m2) > 0.6, "{density}: {}", evenness(&spots, area_m2));
        }
        for count in [1_u32, 40, 1000, 9000] {
            let spots = scattered(&rule(Density::Count(count)), "hut.obj", &points, 10.0, &everywhere);
            assert_eq!(spots.len(), count as usize);
            assert!(count == 1 || evenness(&spots, area_m2) > 0.55, "{count}: {}", evenness(&spots, area_m2));
            let [west, south, east, north] = WITHIN_M;
            assert!(spots.iter().all(|spot| (west..east).contains(&spot.at_m.x)
                && (south..north).contains(&spot.at_m.y)
                && (0.8..=1.2).contains(&spot.scale)
                && (0.0..=360.0).contains(&spot.turn_deg)
                && spot.at_m.z == 7.0));
        }
        // Planted error: random places are not as even.
        let at = |i: u64| DVec2::new(part(mixed(2 * i)), part(mixed(2 * i + 1))) * 1200.0;
        let random = (0..1000).map(|i| Spot { at_m: at(i).extend(0.0), turn_deg: 0.0, scale: 1.0 });
        assert!(evenness(&random.collect::<Vec<_>>(), area_m2) < 0.2);
    }

    #[test]
    fn heights_steepness_and_holes_are_respected_and_nothing_else() {
        let points = Points::new();
        let all = Scatter { up_m: -0.5, ..rule(Density::PerHa(20.0)) };
        let some = Scatter { heights_m: [20.0, 500.0], steepest_deg: Some(30.0), ..all.clone() };
        let (all, some) = [&all, &some].map(|rule| scattered(rule, "rock.obj", &points, 0.01, &ground_m)).into();
        let may = |spot: &&Spot| (20.0..=500.0).contains(&(spot.at_m.z + 0.5)) && slope_deg(spot.at_m) <= 30.0;
        // The allowed ones of all: the rule moves none of them.
        let wanted: Vec<Spot> = all.iter().filter(may).copied().collect();
        assert!(some == wanted && some.len() > 200 && all.len() > some.len() + 500, "{} {}", all.len(), some.len());
        assert!(all.iter().all(|spot| ground_m(spot.at_m.truncate()).is_some_and(|z_m| z_m - 0.5 == spot.at_m.z)));
        // Planted error: without the rule there are some of both kinds.
        assert!(all.iter().any(|spot| slope_deg(spot.at_m) > 30.0) && all.iter().any(|spot| spot.at_m.z < 19.0));
        // The given number is reached where there is room; nothing is placed where there is none.
        let count = Scatter { heights_m: [20.0, 500.0], steepest_deg: Some(30.0), ..rule(Density::Count(3000)) };
        let spots = scattered(&count, "rock.obj", &points, 1.0, &ground_m);
        assert!(spots.len() == 3000 && spots.iter().all(|spot| may(&spot) || (spot.at_m.z - 20.0).abs() < 0.5));
        let none = Scatter { heights_m: [-20.0, -10.0], ..count };
        assert!(scattered(&none, "rock.obj", &points, 1.0, &ground_m).is_empty());
    }

    #[test]
    fn a_rule_is_deterministic_and_a_part_of_the_land_has_its_part() {
        let points = Points::new();
        let whole = rule(Density::PerHa(20.0));
        let of = |rule: &Scatter, name: &str| scattered(rule, name, &points, 1.0, &ground_m);
        let spots = of(&whole, "hut.obj");
        assert_eq!(spots, of(&whole, "hut.obj"));
        // The two halves tested separately, the second one first.
        let east = of(&Scatter { within_m: [10.0, -300.0, 500.0, 900.0], ..whole.clone() }, "hut.obj");
        let west = of(&Scatter { within_m: [-700.0, -300.0, 10.0, 900.0], ..whole.clone() }, "hut.obj");
        assert_eq!(east.len() + west.len(), spots.len());
        assert!(spots.iter().all(|spot| east.contains(spot) != west.contains(spot)));
        // Planted errors: another seed, and another model.
        for other in [of(&Scatter { seed: 2, ..whole.clone() }, "hut.obj"), of(&whole, "rock.obj")] {
            assert!(other.iter().all(|spot| !spots.contains(spot)) && !other.is_empty());
        }
    }
}
