//! Adds pieces of the exemplar to the base, on a lattice of triangles.
//!
//! Every vertex of the lattice has a piece. At each position the three pieces of its triangle are summed with weights
//! that fall from each vertex to the opposite side; the sum is divided by the root of the sum of squared weights, which
//! preserves the variance of independent pieces. Weights are raised to a power first, so that a single piece dominates
//! most of the land.

use std::collections::HashMap;

use super::super::relief::hash;
use super::exemplar::REACH;
use super::{BASE_LEVEL, BASE_SAMPLES, Continent, Field};

/// Distance between the vertices, in samples of level 0. A piece is visible up to this far from its vertex.
const EDGE: f64 = REACH as f64 * 0.98;

/// Height of a triangle as a fraction of its edge.
const RISE: f64 = 0.866_025_403_784_438_6;

/// A piece at a vertex: maps the sample at (column, row) of a level to an index in the exemplar's level.
#[derive(Clone, Copy)]
struct Piece {
    /// Index = base + column · across + row · down.
    base: i64,
    across: i64,
    down: i64,
    gain: f32,
}

/// Adds the pieces to a field of a `level` below that of the base; their standard deviation is `relief`, in metres.
pub(super) fn lay(land: &Continent, level: u32, relief: &Field, field: &mut Field) {
    let span = field.span;
    let (_, heights_m) = land.exemplar.level(level);
    let step = f64::from(1_u32 << level);
    let middle = 0.5 * (step - 1.0);
    let mut pieces: HashMap<(i64, i64), Piece> = HashMap::new();
    let width = span.width as usize;
    let lines = field.heights_m.chunks_exact_mut(width).zip(relief.heights_m.chunks_exact(width));
    for (row, (line, relief)) in (span.y..).zip(lines) {
        // Skewed coordinates, in which whole numbers are vertices.
        let v = (row as f64 * step + middle) / (EDGE * RISE);
        let (row_cell, v_part) = (v.floor() as i64, (v - v.floor()) as f32);
        let mut last_cell = i64::MIN;
        let mut corners = [None; 4];
        for (column, (height, strength_m)) in (span.x..).zip(line.iter_mut().zip(relief)) {
            let u = (column as f64 * step + middle) / EDGE - 0.5 * v;
            let (cell, u_part) = (u.floor() as i64, (u - u.floor()) as f32);
            if cell != last_cell {
                last_cell = cell;
                corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
                    let vertex = (cell + x, row_cell + y);
                    Some(*pieces.entry(vertex).or_insert_with(|| piece(land, level, vertex)))
                });
            }
            // A cell has two triangles: (0,0) (1,0) (0,1), and (1,1) (0,1) (1,0).
            let (order, weights) = match u_part + v_part < 1.0 {
                true => ([0, 1, 2], [1.0 - u_part - v_part, u_part, v_part]),
                false => ([3, 1, 2], [u_part + v_part - 1.0, 1.0 - v_part, 1.0 - u_part]),
            };
            let (mut sum, mut squares) = (0.0, 1e-12);
            for (corner, weight) in order.into_iter().zip(weights) {
                let weight = weight * weight * weight;
                squares += weight * weight;
                if let Some(piece) = corners[corner]
                    && weight > 0.0
                {
                    let at = piece.base + column * piece.across + row * piece.down;
                    // The index is inside by construction; if rounding moves it outside, the relief is 0.
                    let relief_m = usize::try_from(at).ok().and_then(|at| heights_m.get(at)).copied().unwrap_or(0.0);
                    sum += weight * piece.gain * relief_m;
                }
            }
            *height += strength_m.max(0.0) * sum / squares.sqrt();
        }
    }
}

/// Returns the piece at a vertex.
fn piece(land: &Continent, level: u32, vertex: (i64, i64)) -> Piece {
    let bits = hash(vertex.0 as u32 ^ hash(vertex.1 as u32 ^ hash(land.seed)));
    let chance = (hash(bits ^ 0x51ED_270B) >> 8) as f32 / (1 << 24) as f32;
    // The position of the vertex, in samples of level 0.
    let y = vertex.1 as f64 * EDGE * RISE;
    let x = (vertex.0 as f64 + 0.5 * vertex.1 as f64) * EDGE;
    let (middle, roughness_m) = land.exemplar.place(wanted_m(land, x, y), chance);
    let gain = 1.0 / roughness_m.max(1.0);
    // The vertex, and with it the piece, is snapped to a lattice that all levels share.
    let coarse = f64::from(1_u32 << (BASE_LEVEL - 2));
    let place = |c: f64| ((c / coarse).round() * coarse) as i64 >> level;
    let (column, row) = (place(x), place(y));
    let size = i64::from(land.exemplar.level(level).0 as u32);
    let [middle_x, middle_y] = middle.map(|c| i64::from(c >> level));
    // One of the eight orientations of a square: a mirrored sample c to the side of the middle becomes −1 − c.
    let way = bits & 7;
    let (across, down) = match way & 1 {
        0 => ([1, 0], [0, 1]),
        _ => ([0, 1], [1, 0]),
    };
    let flip =
        |axis: [i64; 2]| [if way & 2 == 0 { axis[0] } else { -axis[0] }, if way & 4 == 0 { axis[1] } else { -axis[1] }];
    let (across, down) = (flip(across), flip(down));
    let shift = [if way & 2 == 0 { 0 } else { -1 }, if way & 4 == 0 { 0 } else { -1 }];
    let index = |axis: [i64; 2]| axis[0] + axis[1] * size;
    let base = index([middle_x + shift[0], middle_y + shift[1]]) - column * index(across) - row * index(down);
    Piece { base, across: index(across), down: index(down), gain }
}

/// Returns the required roughness of the land at a position, in metres.
fn wanted_m(land: &Continent, x: f64, y: f64) -> f32 {
    let base = f64::from(1_u32 << BASE_LEVEL);
    let last = i64::from(BASE_SAMPLES) - 1;
    let [column, row] = [x, y].map(|c| ((c / base) as i64).clamp(0, last));
    // The strongest value nearby is used: where a valley meets a mountain, the mountain's piece fades into it.
    let around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (column + right, row + down)));
    let near = around.map(|(c, r)| land.relief_m[(r.clamp(0, last) * (last + 1) + c.clamp(0, last)) as usize]);
    near.fold(0.0, f32::max)
}
