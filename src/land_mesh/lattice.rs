//! Heights of the land on a lattice in the world's metres.

use std::sync::Arc;

use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use crate::pyramid::PyramidError;
use crate::pyramid::store::{Ground, TileStore};
use crate::tiles::grid_projection::GridProjection;

/// Largest number of points: 256 MiB of heights.
const MAX_POINTS: u64 = 1 << 26;
/// Side of the blocks in which heights are read, so that each block needs few tiles.
const BLOCK: usize = 128;
/// Largest distance of a point beyond the border of the land, in samples.
const BORDER_SAMPLES: f64 = 1e-3;
/// Points of the lattice from sample to sample of the DEM, along each axis, if there are not too many.
const FINER: f64 = 2.0;

/// The extent of a lattice in the world's metres, and the distance of the DEM's samples there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// South-western and north-eastern corner.
    pub corners_m: [DVec2; 2],
    /// Distance of samples.
    pub sample_m: f64,
}

/// Why there is no lattice.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LatticeError {
    /// The extent has more samples than fit.
    #[error(
        "the extent has about {samples} samples, and a mesh may have {MAX_POINTS}; use --map=EAST,NORTH,WIDTH with less \
         land"
    )]
    TooLarge {
        /// Samples of the DEM in the extent.
        samples: u64,
    },
    /// There is no land in the extent.
    #[error("there is no land in the extent of the mesh")]
    NoLand,
    /// A tile could not be read.
    #[error(transparent)]
    Ground(#[from] Arc<PyramidError>),
}

/// Heights at points with a distance of a step, from the south-western corner on.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Number of points along each axis, at least 2.
    size: [usize; 2],
    /// Distance of points along each axis.
    step_m: DVec2,
    first_m: DVec2,
    /// Heights row by row from the south; NaN where there is no land.
    heights_m: Vec<f32>,
}

impl Lattice {
    /// Reads the heights of an extent.
    ///
    /// # Errors
    /// [`LatticeError`].
    pub(crate) fn read(
        store: &Arc<dyn TileStore>,
        projection: &GridProjection,
        extent: &Extent,
    ) -> Result<Self, LatticeError> {
        let [low_m, high_m] = extent.corners_m;
        let points = |step_m: f64| ((high_m - low_m) / step_m).ceil().max(DVec2::ONE) + DVec2::ONE;
        let is_possible = |step_m: f64| points(step_m).x * points(step_m).y <= MAX_POINTS as f64;
        let step_m = [extent.sample_m / FINER, extent.sample_m].into_iter().find(|step_m| is_possible(*step_m));
        let samples = || points(extent.sample_m).x * points(extent.sample_m).y;
        let step_m = step_m.ok_or_else(|| LatticeError::TooLarge { samples: samples() as u64 })?;
        // Whole steps, so that the last points are on the sides.
        let count = points(step_m);
        let size = [count.x as usize, count.y as usize];
        let step_m = (high_m - low_m) / (count - DVec2::ONE);
        let finest = store.levels()[0];
        let last = DVec2::new(f64::from(finest.width - 1), f64::from(finest.height - 1));
        // Rounding must not move points on the border of the land beyond it.
        let on_border = |grid: DVec2| {
            let inside = grid.clamp(DVec2::ZERO, last);
            if grid.distance(inside) < BORDER_SAMPLES { inside } else { grid }
        };
        let blocks: Vec<(usize, usize)> = (0..size[1])
            .step_by(BLOCK)
            .flat_map(|row| (0..size[0]).step_by(BLOCK).map(move |column| (column, row)))
            .collect();
        let read = |&(column, row): &(usize, usize)| {
            // Each block has a cache of its own, so that blocks do not wait for each other.
            let ground = Ground::new(Arc::clone(store));
            let [columns, rows] = [BLOCK.min(size[0] - column), BLOCK.min(size[1] - row)];
            let mut heights_m = Vec::with_capacity(columns * rows);
            for y in row..row + rows {
                for x in column..column + columns {
                    let grid = projection.grid_from_world(low_m + step_m * DVec2::new(x as f64, y as f64));
                    let grid = on_border(grid);
                    heights_m.push(ground.height_m(grid.x, grid.y).map_or(f32::NAN, |height_m| height_m as f32));
                }
            }
            match ground.failure() {
                Some(failure) => Err(LatticeError::Ground(failure)),
                None => Ok(heights_m),
            }
        };
        let read: Vec<Vec<f32>> = blocks.par_iter().map(read).collect::<Result<_, _>>()?;
        let mut heights_m = vec![f32::NAN; size[0] * size[1]];
        for ((column, row), own) in blocks.into_iter().zip(read) {
            let columns = BLOCK.min(size[0] - column);
            for (y, own) in own.chunks_exact(columns).enumerate() {
                heights_m[(row + y) * size[0] + column..][..columns].copy_from_slice(own);
            }
        }
        if heights_m.iter().all(|height_m| height_m.is_nan()) {
            return Err(LatticeError::NoLand);
        }
        Ok(Self { size, step_m, first_m: low_m, heights_m })
    }

    /// Returns a lattice of given heights.
    #[cfg(test)]
    pub(crate) fn of(size: [usize; 2], step_m: f64, height_m: impl Fn(DVec2) -> Option<f64>) -> Self {
        let at = |i: usize| DVec2::new((i % size[0]) as f64, (i / size[0]) as f64) * step_m;
        let heights_m = (0..size[0] * size[1]).map(|i| height_m(at(i)).map_or(f32::NAN, |height_m| height_m as f32));
        Self { size, step_m: DVec2::splat(step_m), first_m: DVec2::ZERO, heights_m: heights_m.collect() }
    }

    /// Returns the last point.
    pub(crate) fn last(&self) -> UVec2 {
        // Their number is bounded by MAX_POINTS.
        UVec2::new(self.size[0] as u32 - 1, self.size[1] as u32 - 1)
    }

    /// Returns the larger distance of points, in metres.
    pub(crate) fn step_m(&self) -> f64 {
        self.step_m.max_element()
    }

    /// Returns the heights of a row of points; NaN where there is no land.
    pub(crate) fn row(&self, y: u32) -> &[f32] {
        &self.heights_m[y as usize * self.size[0]..][..self.size[0]]
    }

    /// Returns the height of a point, or `None` where there is no land.
    pub(crate) fn height_m(&self, point: UVec2) -> Option<f64> {
        let height_m = self.row(point.y)[point.x as usize];
        (!height_m.is_nan()).then(|| f64::from(height_m))
    }

    /// Returns the middle of the extent in the world.
    pub(crate) fn middle_m(&self) -> DVec2 {
        self.first_m + 0.5 * self.step_m * self.last().as_dvec2()
    }

    /// Returns a point's east and north from the middle, in metres.
    pub(crate) fn offset_m(&self, point: UVec2) -> DVec2 {
        self.step_m * (point.as_dvec2() - 0.5 * self.last().as_dvec2())
    }

    /// Returns the upward normal at a point with a height, by differences to its neighbours that have one.
    pub(crate) fn normal(&self, point: UVec2) -> DVec3 {
        let own = self.height_m(point).unwrap_or_default();
        let rise = |axis: UVec2| {
            let before = (point.cmpge(axis).all()).then(|| point - axis).and_then(|at| self.height_m(at));
            let after = Some(point + axis).filter(|at| at.cmple(self.last()).all()).and_then(|at| self.height_m(at));
            let steps = f64::from(u8::from(before.is_some()) + u8::from(after.is_some())).max(1.0);
            (after.unwrap_or(own) - before.unwrap_or(own)) / (steps * self.step_m.dot(axis.as_dvec2()))
        };
        DVec3::new(-rise(UVec2::X), -rise(UVec2::Y), 1.0).normalize()
    }
}
