//! A printer's halftone: round dots on a rotated grid, which grow, meet at the middle tone, and leave round holes.
//!
//! The grid's two waves have whole numbers of periods over the tile, (n, n) and (−n, n), so it is periodic; it is
//! rotated by 45°, as the black of a print is. The spot function is the sum of two cosines (PostScript's most common
//! one): the same shape for dots and for holes.

use super::chance::Chance;
use crate::lines::strokes::texture::field::Field;
use crate::style::marks::Recipe;

/// Returns cos(2π turns), from products alone: Bhaskara's formula (7th century), with an error below 0.002.
fn cosine(turns: f32) -> f32 {
    let t = 2.0 * (turns - turns.round()).abs();
    // sin(π (½ − t)) by halves of the wave, which are mirrored.
    let (t, sign) = if t > 0.5 { (1.0 - t, -1.0) } else { (t, 1.0) };
    sign * (1.0 - 4.0 * t * t) / (1.0 + t * t)
}

/// Returns the ink at which each texel is reached, on an arbitrary rising scale.
pub(super) fn ink(recipe: &Recipe) -> Vec<f32> {
    let side = recipe.side_px as usize;
    // (n, n): √2 n dots along a side.
    let waves = (side as f32 / recipe.spacing_px * std::f32::consts::FRAC_1_SQRT_2).round().max(1.0);
    let mut chance = Chance::new(recipe.seed, 1);
    let start = [chance.part(), chance.part()];
    let noise = |stream: u32, mark_px: f32| Field::noise([side, side], [mark_px, mark_px], recipe.seed, stream);
    // The plate is not quite flat, and the paper not quite smooth.
    let (bend, other, press) = (noise(2, 40.0), noise(3, 40.0), noise(4, 0.8 * recipe.spacing_px));
    let bent = recipe.wobble_px / recipe.spacing_px;
    let place = |place: usize| {
        let [x, y] = [place % side, place / side].map(|at| (at as f32 + 0.5) / side as f32);
        let u = waves * (x + y) + start[0] + bent * 0.3 * bend.values()[place];
        let v = waves * (y - x) + start[1] + bent * 0.3 * other.values()[place];
        -(cosine(u) + cosine(v)) + 0.3 * recipe.jitter * press.values()[place]
    };
    (0..side * side).map(place).collect()
}
