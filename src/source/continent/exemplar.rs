//! The exemplar: eroded land from which pieces are taken. Holds its relief without wide features, at every level, and
//! the roughness of each piece.

use super::{BASE_LEVEL, Field, Span};

/// Relief that is wider than the samples of this level is removed, because the base provides it.
const WIDE_LEVEL: u32 = 9;

/// Distance from the middle of a piece to its sides, in samples of level 0.
pub(super) const REACH: u32 = 512;

/// Distance between the possible middles of pieces, in samples of level 0: a whole number of samples of every level
/// that is read.
const PLACES_APART: u32 = 1 << (BASE_LEVEL - 2);

/// Land to take pieces from.
#[derive(Clone, Debug)]
pub(crate) struct Exemplar {
    size: u32,
    /// For each level below [`BASE_LEVEL`] − 1, its heights in metres relative to the wide relief, row by row.
    levels_m: Vec<Vec<f32>>,
    /// Middles of pieces with their roughness in metres, the smoothest first.
    places: Vec<(f32, [u32; 2])>,
}

impl Exemplar {
    /// Builds an exemplar from `size`² heights in metres, none of which may be no-data.
    ///
    /// # Panics
    /// Panics if `size` is not a multiple of 512 or is below 1536, or if the number of heights is not `size`².
    pub(crate) fn new(size: u32, heights_m: &[f32]) -> Self {
        assert!(size.is_multiple_of(1 << WIDE_LEVEL) && size > 2 * REACH && heights_m.len() == (size * size) as usize);
        let mut levels_m = vec![heights_m.to_vec()];
        for level in 0..WIDE_LEVEL {
            levels_m.push(halved(&levels_m[level as usize], (size >> level) as usize));
        }
        let mut wide = levels_m.pop().unwrap_or_default();
        for level in (0..WIDE_LEVEL).rev() {
            wide = doubled(&wide, size >> (level + 1));
            for (height, wide) in levels_m[level as usize].iter_mut().zip(&wide) {
                *height -= wide;
            }
        }
        levels_m.truncate(BASE_LEVEL as usize - 1);
        let places = places(size, &levels_m[3]);
        Self { size, levels_m, places }
    }

    /// Returns the samples along a side of `level`, and its heights.
    pub(super) fn level(&self, level: u32) -> (usize, &[f32]) {
        ((self.size >> level) as usize, &self.levels_m[level as usize])
    }

    /// Returns the middle of a piece about as rough as `roughness_m`, in samples of level 0, and its roughness;
    /// `chance` (0 to 1) selects one of the nearest.
    pub(super) fn place(&self, roughness_m: f32, chance: f32) -> ([u32; 2], f32) {
        let at = self.places.partition_point(|place| place.0 < roughness_m);
        let choice = (self.places.len() / 6).max(1);
        let first = at.saturating_sub(choice / 2).min(self.places.len() - choice);
        let (roughness_m, middle) = self.places[first + ((chance * choice as f32) as usize).min(choice - 1)];
        (middle, roughness_m)
    }
}

/// Returns the middles of all pieces inside, with their roughness: the standard deviation within half of their reach,
/// on level 3.
fn places(size: u32, level_3_m: &[f32]) -> Vec<(f32, [u32; 2])> {
    let width = (size >> 3) as usize;
    let along = (REACH..=size - REACH).step_by(PLACES_APART as usize);
    let mut places = Vec::new();
    for y in along.clone() {
        for x in along.clone() {
            let half = (REACH >> 4) as usize;
            let (column, row) = ((x >> 3) as usize, (y >> 3) as usize);
            let mut squares = 0.0;
            for row in row - half..row + half {
                let line = &level_3_m[row * width + column - half..row * width + column + half];
                squares += line.iter().map(|height| height * height).sum::<f32>();
            }
            places.push(((squares / (4 * half * half) as f32).sqrt(), [x, y]));
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places
}

/// Averages blocks of two by two samples.
pub(super) fn halved(heights_m: &[f32], width: usize) -> Vec<f32> {
    let rows = heights_m.chunks_exact(2 * width);
    rows.flat_map(|rows| {
        let (upper, lower) = rows.split_at(width);
        let pairs = upper.chunks_exact(2).zip(lower.chunks_exact(2));
        pairs.map(|(a, b)| 0.25 * (a[0] + a[1] + b[0] + b[1]))
    })
    .collect()
}

/// Evaluates the bicubic surface over a whole level at the samples of the next finer one.
fn doubled(heights_m: &[f32], size: u32) -> Vec<f32> {
    let fine = Span { x: 0, y: 0, width: 2 * size, height: 2 * size };
    let span = fine.coarse();
    let last = i64::from(size) - 1;
    let mut around = Vec::with_capacity(span.samples());
    for row in span.y..span.y + i64::from(span.height) {
        for column in span.x..span.x + i64::from(span.width) {
            around.push(heights_m[(row.clamp(0, last) * (last + 1) + column.clamp(0, last)) as usize]);
        }
    }
    Field { span, heights_m: around }.doubled(fine).heights_m
}
