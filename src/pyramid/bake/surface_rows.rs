//! The surface of a level at the samples of full resolution, row by row.
//!
//! All full-resolution samples of a row share their vertical weights, so a row costs one weighted sum of four level
//! rows and then four products for each sample.

use crate::pyramid::surface::bicubic;
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::levels::{LevelSize, Region, coordinate};

/// A full-resolution sample along an axis, in relation to a level.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisSample {
    /// The cell of the level that contains it.
    pub cell: u32,
    /// The weights of the samples −1, 0, 1, 2 of that cell.
    pub weights: [f64; 4],
    /// The sample of the level whose area covers its centre.
    pub sample: u32,
    /// Whether all samples with a weight are inside the region `own` of [`Surface::new`].
    pub inside: bool,
}

impl AxisSample {
    /// Locates the sample `f` of `finest` on an axis of `size` samples, of which `count` from `first` on are inside.
    fn new(f: u32, finest: u32, size: u32, (first, count): (u32, u32)) -> Self {
        let c = coordinate(f.into(), finest, size);
        let (cell, fraction) = bicubic::cell(c, size);
        let weights = bicubic::weights(fraction);
        let own = |k: u32| (first..first + count).contains(&bicubic::neighbour(cell, k, size));
        let inside = (0..4).all(|k| weights[k as usize] == 0.0 || own(k));
        Self { cell, weights, sample: (c + 0.5) as u32, inside }
    }
}

/// Returns the full-resolution samples in the area of the samples `first` … `first + count − 1` of an axis of `size`:
/// the first one, and the one after the last.
pub(super) fn area(first: u32, count: u32, finest: u32, size: u32) -> (u32, u32) {
    let sample = |f: u32| (coordinate(f.into(), finest, size) + 0.5) as u32;
    let begin = |at: u32| {
        if at >= size {
            return finest;
        }
        // Start near the sample, by division; then find it exactly, by the rule itself.
        let mut f = (u64::from(at) * u64::from(finest) / u64::from(size)).saturating_sub(2) as u32;
        while f < finest && sample(f) < at {
            f += 1;
        }
        f
    };
    (begin(first), begin(first + count))
}

/// A level's surface over a rectangle of full-resolution samples.
pub(super) struct Surface<'a> {
    served: &'a Field,
    size: LevelSize,
    /// The columns of the rectangle, from its first.
    pub columns: Vec<AxisSample>,
    /// The rows of the rectangle, from its first.
    pub rows: Vec<AxisSample>,
}

impl<'a> Surface<'a> {
    /// Prepares the surface over the columns and rows of `over`. `served` is the level as tiles serve it, at least as
    /// far as the kernel reaches from there; `own` says which of its samples count as inside.
    pub(super) fn new(served: &'a Field, finest: LevelSize, size: LevelSize, over: Region, own: Region) -> Self {
        let column = |f| AxisSample::new(f, finest.width, size.width, (own.x, own.width));
        let row = |f| AxisSample::new(f, finest.height, size.height, (own.y, own.height));
        let columns = (over.x..over.x + over.width).map(column).collect();
        let rows = (over.y..over.y + over.height).map(row).collect();
        Self { served, size, columns, rows }
    }

    /// Evaluates the surface along a row, at the level's columns from one before the field's first on (clamped).
    pub(super) fn across(&self, row: &AxisSample, across: &mut Vec<f64>) {
        let line = |k: u32| self.served.row(bicubic::neighbour(row.cell, k, self.size.height));
        let lines = [line(0), line(1), line(2), line(3)];
        let width = lines[0].len();
        across.clear();
        across.push(0.0);
        across.extend((0..width).map(|x| (0..4).map(|k| row.weights[k] * f64::from(lines[k][x])).sum::<f64>()));
        across[0] = across[1];
        let last = across[width];
        across.extend([last; 2]);
    }

    /// Returns the height at a column, from the `across` of [`Surface::across`]; NaN where it depends on unknown
    /// heights.
    pub(super) fn height_m(&self, across: &[f64], column: &AxisSample) -> f64 {
        let first = (column.cell - self.served.region.x) as usize;
        across[first..first + 4].iter().zip(column.weights).map(|(across, weight)| across * weight).sum()
    }
}
