//! Lines through the whole tile, drawn as whole rows, one after another, each between two existing ones.
//!
//! When all exist they are evenly spaced, apart from the hand's jitter. They are added by steps of the golden section,
//! so that for every number of rows there are only two or three sizes of gaps, mixed everywhere (Sós 1958): gaps do not
//! all halve at once, and no part of the tile is denser than another. The ink at which a row begins varies along it, so
//! lines appear as long strokes that grow at their ends.
//!
//! Rows run in a direction (a, b) of integers, which closes on the tile; rows of (1, 0) are horizontal.

use super::chance::Chance;
use super::growth::Growth;
use super::ink_map::{InkMap, MarkPoint};
use crate::lines::strokes::texture::field::Field;
use crate::style::marks::Recipe;

/// A family of parallel rows.
pub(super) struct Family {
    /// Direction, as integers without a common divisor.
    pub(super) direction: [i32; 2],
    /// Largest number of rows; when they are reached, rows only widen.
    pub(super) most: usize,
    /// Ink before the first row begins.
    pub(super) after: f32,
    /// Random stream, a different one for each family.
    pub(super) stream: u32,
}

/// A row: its position across, and the ink at which it begins.
struct Row {
    across_px: f32,
    begin: f32,
    /// Offset of its own piece of the noises.
    shift: [usize; 2],
    width: f32,
}

/// Returns the positions of rows, 0 to 1, in the order in which they are added.
fn places(count: usize, jitter: f32, chance: &mut Chance) -> Vec<f32> {
    // By steps of the golden section, then moved to even spacing without changing their order.
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
    // The period across the rows.
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
    // For each pixel across, the first row at or beyond it.
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
                // Where the ink of its beginning is higher, the row has an end.
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
