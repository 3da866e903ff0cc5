//! Compares the edges of neighbouring tiles. Where heights continue from tile to tile, the step across an edge is like
//! the steps within the tiles; rows that are counted from the other end, or tiles of several data sets, show as steps
//! that are many times larger.

use std::collections::HashSet;
use std::path::Path;

use super::{SourceError, TileRows};

/// Largest number of pairs of neighbours that are compared in each direction.
const PAIRS: usize = 6;
/// A step across an edge up to this many times the usual step counts as continuous, and one beyond [`BROKEN`] times as
/// broken.
const CONTINUOUS: f64 = 2.0;
const BROKEN: f64 = 4.0;
/// Steps below this, in metres, are level ground.
const LEVEL_M: f64 = 0.5;
/// Smallest number of places along an edge that are compared.
const PLACES: u64 = 16;

/// Mean steps in metres: across edges, and within the tiles on both sides.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    across_m: f64,
    across: u64,
    within_m: f64,
    within: u64,
}

impl Step {
    fn add_across(&mut self, a: f32, b: f32) {
        if !a.is_nan() && !b.is_nan() {
            self.across_m += f64::from((a - b).abs());
            self.across += 1;
        }
    }

    fn add_within(&mut self, a: f32, b: f32) {
        if !a.is_nan() && !b.is_nan() {
            self.within_m += f64::from((a - b).abs());
            self.within += 1;
        }
    }

    /// Returns the step across edges and the usual one, in metres; `None` if too few were seen.
    fn means_m(&self) -> Option<[f64; 2]> {
        let mean = |sum: f64, count: u64| (count >= PLACES).then(|| sum / count as f64);
        Some([mean(self.across_m, self.across)?, mean(self.within_m, self.within)?.max(LEVEL_M)])
    }

    fn ratio(&self) -> Option<f64> {
        self.means_m().map(|[across_m, within_m]| across_m / within_m)
    }
}

/// The steps across the edges of tiles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seams {
    /// The edges between columns.
    columns: Step,
    /// Between rows, if they are counted from the north, and from the south.
    from_north: Step,
    from_south: Step,
}

impl Seams {
    /// Compares pairs of neighbours that are spread over the tiles; `heights_m` returns the heights of a tile.
    ///
    /// # Errors
    /// Passes on the errors of `heights_m`.
    pub(super) fn measure(
        tiles: &[[u32; 2]],
        present: &HashSet<[u32; 2]>,
        side: usize,
        heights_m: &dyn Fn([u32; 2]) -> Result<Vec<f32>, SourceError>,
    ) -> Result<Self, SourceError> {
        let mut seams = Self::default();
        let pairs = |next: &dyn Fn([u32; 2]) -> [u32; 2]| {
            let all = tiles.iter().map(|tile| (*tile, next(*tile))).filter(|(_, next)| present.contains(next));
            let all: Vec<_> = all.collect();
            all.iter().step_by((all.len() / PAIRS).max(1)).take(PAIRS).copied().collect::<Vec<_>>()
        };
        for (left, right) in pairs(&|[x, y]| [x + 1, y]) {
            let (left, right) = (heights_m(left)?, heights_m(right)?);
            for row in 0..side {
                let of = |tile: &[f32], column: usize| tile[row * side + column];
                seams.columns.add_across(of(&left, side - 1), of(&right, 0));
                (1..side).for_each(|it| seams.columns.add_within(of(&left, it - 1), of(&left, it)));
            }
        }
        for (lower_number, higher_number) in pairs(&|[x, y]| [x, y + 1]) {
            let (first, second) = (heights_m(lower_number)?, heights_m(higher_number)?);
            for column in 0..side {
                let of = |tile: &[f32], row: usize| tile[row * side + column];
                seams.from_north.add_across(of(&first, side - 1), of(&second, 0));
                seams.from_south.add_across(of(&second, side - 1), of(&first, 0));
                for it in 1..side {
                    seams.from_north.add_within(of(&first, it - 1), of(&first, it));
                    seams.from_south.add_within(of(&second, it - 1), of(&second, it));
                }
            }
        }
        Ok(seams)
    }

    /// Returns the direction of the rows: the given one; else the only one in which edges meet; else the one that a file
    /// with the tiles declares, or from the north. Warns if that is a guess, and if edges do not meet.
    pub(super) fn decide(&self, path: &Path, given: Option<TileRows>, declared: Option<TileRows>) -> TileRows {
        let name = path.display();
        let of = |rows| if rows == TileRows::Tms { &self.from_south } else { &self.from_north };
        let expected = given.or(declared).unwrap_or(TileRows::Xyz);
        let other = if expected == TileRows::Tms { TileRows::Xyz } else { TileRows::Tms };
        let is_broken = |step: &Step| step.ratio().is_some_and(|ratio| ratio > BROKEN);
        let is_continuous = |step: &Step| step.ratio().is_some_and(|ratio| ratio < CONTINUOUS);
        let meets_reversed = is_broken(of(expected)) && is_continuous(of(other));
        let rows = if meets_reversed && given.is_none() { other } else { expected };
        if rows != expected {
            let from = if rows == TileRows::Tms { "south (TMS)" } else { "north (XYZ)" };
            tracing::warn!(
                "{name}: the tile edges match only with rows counted from the {from}, which is assumed; \
                 --tile-rows {} overrides it",
                expected.name()
            );
        }
        let broken = [&self.columns, of(rows)].into_iter().find(|step| is_broken(step));
        if let Some([across_m, within_m]) = broken.and_then(Step::means_m) {
            let hint = if meets_reversed { format!("; --tile-rows {} fits", other.name()) } else { String::new() };
            tracing::warn!(
                "{name}: the edges of neighbouring tiles do not meet: {across_m:.0} m apart, where {within_m:.1} m is \
                 usual{hint}"
            );
        }
        rows
    }
}
