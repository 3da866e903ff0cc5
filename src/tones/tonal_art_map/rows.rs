//! Lines through the whole tile: whole rows, one after another, each between two that are there.
//!
//! When all are there they stand evenly, but for the hand's jitter. They come by steps of the golden section, so that
//! at every number of rows there are but two or three sizes of gaps, mixed everywhere (Sós 1958): neither do all gaps
//! halve at once, nor is one part of the tile denser than another. Where a row begins early and where late varies along
//! it, so lines come as long strokes that grow at their ends.
//!
//! Rows run in a direction (a, b) of whole numbers, which closes on the tile; those of (1, 0) are level.

use super::chance::Chance;
use super::growth::Growth;
use super::ink_map::{InkMap, MarkPoint};
use crate::lines::strokes::texture::field::Field;
use crate::style::marks::Recipe;

/// A family of rows.
pub(super) struct Family {
    /// Whole numbers without a common divisor.
    pub(super) direction: [i32; 2],
    /// Rows beyond this number do not come; the others widen.
    pub(super) most: usize,
    /// Ink before the first row begins.
    pub(super) after: f32,
    /// Tells families apart.
    pub(super) stream: u32,
}

/// A row: where it lies across, and the ink at which it begins.
struct Row {
    across_px: f32,
    begin: f32,
    /// Its own piece of the noises.
    shift: [usize; 2],
    width: f32,
}

/// Where rows lie, 0 to 1, in the order in which they come.
fn places(count: usize, jitter: f32, chance: &mut Chance) -> Vec<f32> {
    // By steps of the golden section, and then moved to even places without changing their order.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let steps: Vec<f32> = (0..count).map(|i| (i as f64 * GOLDEN).fract() as f32).collect();
    let start = chance.part();
    let place = |rank: f32| {
        let at = start + rank + 0.35 * jitter * chance.gentle() / count as f32;
        at - at.floor()
    };
    super::equalise::ranks(&steps).into_iter().map(place).collect()
}

/// Draws a family.
pub(super) fn draw(recipe: &Recipe, growth: &Growth, family: &Family, map: &mut InkMap) {
    let side = map.side_px;
    let [a, b] = family.direction.map(|part| part as f32);
    let norm = (a * a + b * b).sqrt();
    // All that is across repeats after this.
    let period_px = side as f32 / norm;
    let mut chance = Chance::new(recipe.seed, family.stream);
    let count = growth.count().min(family.most);
    let mut rows: Vec<Row> = Vec::with_capacity(count);
    for (before, at) in places(count, recipe.jitter, &mut chance).into_iter().enumerate() {
        let shift = [0, 1].map(|_| (chance.part() * side as f32) as usize);
        let width = 1.0 + 0.35 * recipe.pressure * chance.gentle();
        rows.push(Row { across_px: at * period_px, begin: family.after + growth.begin(before), shift, width });
    }
    rows.sort_by(|a, b| a.across_px.total_cmp(&b.across_px));
    // The first row at or beyond each pixel across.
    let starts: Vec<usize> =
        (0..=period_px.ceil() as usize).map(|px| rows.partition_point(|row| row.across_px < px as f32)).collect();

    let noise = |along_px: f32, across_px: f32, stream: u32| {
        let mark_px = if a == 1.0 && b == 0.0 { [along_px, across_px] } else { [0.7 * along_px, 0.7 * along_px] };
        Field::noise([side, side], mark_px, recipe.seed, family.stream.wrapping_mul(16).wrapping_add(stream))
    };
    // All rows of a neighbourhood sway together, and each a little by itself.
    let sway = noise(110.0, 150.0, 1);
    let own = noise(70.0, 24.0, 2);
    let hand = noise(64.0, 24.0, 3);
    let sway_px = 0.5 * recipe.wobble_px;
    let own_px = (0.25 * recipe.wobble_px).min(0.09 * recipe.spacing_px);
    let reach_px = (0.75 * recipe.spacing_px + 2.0).min(0.499 * period_px);
    for y in 0..side {
        for x in 0..side {
            let level = (a * (y as f32 + 0.5) - b * (x as f32 + 0.5)) / norm;
            let v = (level + sway_px * sway.values()[y * side + x]).rem_euclid(period_px);
            let mut least = f32::MAX;
            let mut index = starts[((v - reach_px).rem_euclid(period_px) as usize).min(starts.len() - 1)];
            for _ in 0..rows.len() {
                index %= rows.len();
                let row = &rows[index];
                let mut off = row.across_px - v;
                off -= (off / period_px).round() * period_px;
                if off > reach_px {
                    break;
                }
                index += 1;
                if off < -reach_px - 1.0 {
                    continue;
                }
                let place = (y + row.shift[1]) % side * side + (x + row.shift[0]) % side;
                let pressed = hand.values()[place].clamp(-2.0, 2.0);
                let away_px = (off + own_px * own.values()[place]).abs();
                let half_px = 0.5 * recipe.width_px * row.width * (1.0 + 0.2 * recipe.pressure * pressed);
                // A row that begins late here has its end here.
                let begin = family.after + (row.begin - family.after) * (1.0 - 0.3 * pressed);
                let place = MarkPoint { begin, away_px, half_px, along: 0.0 };
                least = least.min(place.reached_at(growth));
            }
            if least < f32::MAX {
                map.reach(x, y, least);
            }
        }
    }
}
