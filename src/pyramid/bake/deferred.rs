//! Errors that can only be measured when coarser levels exist.
//!
//! A no-data area far from all data takes its filling from coarser levels, up to the coarsest. Where a valid sample of
//! full resolution is so isolated that the surface of a level there depends on such a filling, a chunk cannot measure
//! the error, and defers the sample. When all levels have been written, they are read as any reader would read them,
//! and the error is measured then. Such samples are few: an island has to be smaller than half a coarse sample, and
//! more than four samples away from the next.

use super::plan::{Plan, Round};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::bicubic;
use crate::pyramid::surface::fill::{HeightLevels, read_filled};
use crate::pyramid::surface::levels::{LevelSize, Region, coordinate};
use crate::pyramid::surface::statistics::rounded_up;
use crate::pyramid::tile::TILE_SAMPLES;

/// A sample whose error is measured when all levels exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deferred {
    /// The level of the tile whose error depends on the sample.
    pub level: u32,
    /// In the first round, its column in level 0; later, that of its quad among the vertices of the round's base level.
    pub x: u32,
    /// The row of the sample, or of its quad, counted like `x`.
    pub y: u32,
    /// In the first round, its height in metres; later NaN.
    pub height_m: f32,
}

impl Deferred {
    /// Returns a unique sort key, in the order of the levels.
    pub(super) fn key(&self) -> (u32, u32, u32) {
        (self.level, self.y, self.x)
    }
}

/// The finished levels, as they are served.
pub(super) struct FinishedLevels<'a> {
    /// The levels of the finished GeoTIFF, read back.
    pub levels: &'a dyn HeightLevels,
    /// The filling of no-data far from everything on the coarsest level, in metres.
    pub fallback_m: f32,
}

impl FinishedLevels<'_> {
    /// Returns the height of a level's surface at a sample of full resolution, in metres, and the tile that the sample
    /// belongs to.
    fn surface_m(&self, level: usize, finest: LevelSize, x: u32, y: u32) -> Result<(f64, (u32, u32)), PyramidError> {
        let size = self.levels.sizes()[level];
        let axis = |f: u32, finest: u32, size: u32| {
            let c = coordinate(f.into(), finest, size);
            let (cell, fraction) = bicubic::cell(c, size);
            (cell, fraction, (c + 0.5) as u32 / TILE_SAMPLES)
        };
        let (cell_x, fx, tile_x) = axis(x, finest.width, size.width);
        let (cell_y, fy, tile_y) = axis(y, finest.height, size.height);
        let around =
            Region { x: cell_x, y: cell_y, width: 2.min(size.width), height: 2.min(size.height) }.grown(1, size);
        let served = read_filled(self.levels, level, around, self.fallback_m)?;
        let samples: [[f32; 4]; 4] = std::array::from_fn(|k| {
            let row = bicubic::neighbour(cell_y, k as u32, size.height) - around.y;
            std::array::from_fn(|i| {
                let column = bicubic::neighbour(cell_x, i as u32, size.width) - around.x;
                served[(row * around.width + column) as usize]
            })
        });
        Ok((bicubic::height_and_gradient(&samples, fx, fy).0, (tile_x, tile_y)))
    }

    /// Raises the errors of tiles (by level, row-major) to those at the deferred samples. The levels of the next round
    /// rest on the errors of their base, so where one grows, they are measured again over the same place.
    pub(super) fn raise(
        &self,
        plan: &Plan,
        deferred: &[Deferred],
        errors_m: &mut [Vec<f32>],
    ) -> Result<(), PyramidError> {
        let rounds = plan.rounds();
        let mut by_level: Vec<Vec<Deferred>> = vec![Vec::new(); plan.sizes.len()];
        for put_off in deferred {
            by_level[put_off.level as usize].push(*put_off);
        }
        for level in 0..plan.sizes.len() {
            let mut here = std::mem::take(&mut by_level[level]);
            here.sort_by_key(Deferred::key);
            here.dedup_by_key(|put_off| put_off.key());
            let Some(round) = rounds.iter().find(|round| level <= round.top) else { continue };
            for put_off in &here {
                self.raise_one(plan, *round, put_off, errors_m)?;
            }
            let Some(next) = rounds.get(round.number as usize + 1).filter(|_| level == round.top) else { continue };
            let shift = if round.number == 0 { next.base } else { next.base - round.base };
            for put_off in here {
                let (x, y) = (put_off.x >> shift, put_off.y >> shift);
                for (level, above) in by_level.iter_mut().enumerate().take(next.top + 1).skip(next.base + 1) {
                    above.push(Deferred { level: level as u32, x, y, height_m: f32::NAN });
                }
            }
        }
        Ok(())
    }

    fn raise_one(
        &self,
        plan: &Plan,
        round: Round,
        put_off: &Deferred,
        errors_m: &mut [Vec<f32>],
    ) -> Result<(), PyramidError> {
        let (finest, level) = (plan.sizes[0], put_off.level as usize);
        let tile = |level: usize, (x, y): (u32, u32)| (y * plan.sizes[level].tiles_x() + x) as usize;
        if round.number == 0 {
            let (surface_m, place) = self.surface_m(level, finest, put_off.x, put_off.y)?;
            let worst = &mut errors_m[level][tile(level, place)];
            *worst = worst.max(rounded_up((surface_m - f64::from(put_off.height_m)).abs()));
            return Ok(());
        }
        let step = 1_u64 << round.base;
        let span = |at: u32, samples: u32| {
            let first = u64::from(at) * step;
            first as u32..(first + step + 1).min(samples.into()) as u32
        };
        for y in span(put_off.y, finest.height) {
            for x in span(put_off.x, finest.width) {
                let (under_m, under) = self.surface_m(round.base, finest, x, y)?;
                let (surface_m, place) = self.surface_m(level, finest, x, y)?;
                let under_error_m = f64::from(errors_m[round.base][tile(round.base, under)]);
                let worst = &mut errors_m[level][tile(level, place)];
                *worst = worst.max(rounded_up((surface_m - under_m).abs() + under_error_m));
            }
        }
        Ok(())
    }
}
