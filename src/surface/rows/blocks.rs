//! Blocks of rows: which of those that a view needs ([`needed`](super::needed)) are built, and where they are cached.
//!
//! The blocks form a quadtree over the grid: a block of level L has 64 cells of 2^L samples along its side. The contents
//! of a block depend on its location alone, so a block is cached until its slot is needed for another one. A window
//! builds [`JOBS_AT_ONCE`] blocks per frame, the nearest first, and rebuilds those that were built while tiles were
//! missing; a frame for a file builds all of them.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use super::needed::{Address, Needed};
use super::reach::{Culling, Reach};
use super::{PlannedPool, RowPlan, proposals};
use crate::gpu::Gpu;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pools::KEEP_FRAMES;
use crate::gpu::wgsl::shared::rows::{CELLS, MAX_CANDIDATES, RowBlock, RowRules, WORDS};
use crate::pyramid::TileStore;
use crate::scene::view::{Rig, View};
use crate::style::Rows;
use crate::tiles::selection::Selection;
use crate::tiles::terrain::{Loading, Terrain};

/// Blocks that a frame builds if it must not wait, and that one submit builds if it must.
pub(crate) const JOBS_AT_ONCE: usize = 8;
/// Blocks of a pool: 66 MB of candidates, half of what a binding may hold.
pub(crate) const POOL_SLOTS: usize = 48;
/// Number of pools. The minimum keeps blocks that go out of view cached; if a picture needs more than the maximum, the
/// spacing is widened.
const POOLS: std::ops::RangeInclusive<usize> = 2..=12;
/// Factor by which the spacing is widened at a time.
const WIDER: f32 = 1.19;
/// Level of the finest blocks: the side of their cells is 2^−6 of a sample.
pub(super) const MIN_LEVEL: i32 = -6;
/// Mean width of a cell, in spacings.
const MEAN_CELL: f32 = 1.4;
/// Expected marks of a picture, per pixel, times the spacing squared.
const MARKS_PER_SPACING: f32 = 2.0;

const COUNTS: BufferKind = BufferKind::storage("row counts");
const CANDIDATES: BufferKind = BufferKind::storage("row candidates");
/// Bytes of a candidate.
pub(crate) const CANDIDATE_BYTES: u64 = 4 * WORDS as u64;

/// A block that is built, or planned to be.
struct Made {
    slot: u32,
    used_in: u64,
    /// Whether all tiles were loaded when it was built.
    is_whole: bool,
}

/// Number of intervals between the samples of a mark that is as high as its row.
const SAMPLES_OF_ROW: f32 = 10.0;

/// The parameters that blocks are built from, apart from their addresses.
#[derive(PartialEq)]
struct MadeOf {
    /// Address of the world's tile store in memory.
    store: usize,
    row_cells: f32,
    level: f32,
    stagger: f32,
}

/// The cached blocks, on the GPU.
#[derive(Default)]
pub(crate) struct RowMemory {
    pools: Vec<[Buffer; 2]>,
    /// Keeps the tile store of the blocks alive, so that no other store can have its address in memory.
    store: Option<Arc<dyn TileStore>>,
    made_of: Option<MadeOf>,
    made: FxHashMap<Address, Made>,
    planned: Vec<Address>,
    /// The blocks that the last view needs.
    needed: Needed,
    reach: Reach,
    /// How blocks out of view are culled.
    pub(crate) culling: Culling,
    /// Pool and slot of each block that the last plan builds, and of each that it may draw.
    built: Vec<[usize; 2]>,
    seen: Vec<[usize; 2]>,
    frame: u64,
    /// Number of successive frames, up to the last, whose style has no rows.
    frames_without_rows: u64,
    is_late: bool,
}

impl RowMemory {
    /// Notes a frame whose style has no rows. After some of them, releases the blocks.
    pub(crate) fn skip(&mut self) {
        self.is_late = false;
        self.frames_without_rows += 1;
        if self.frames_without_rows > KEEP_FRAMES {
            *self = Self::default();
        }
    }

    /// Marks the blocks of the last plan as not built, because its frame was not drawn.
    pub(crate) fn forget_planned(&mut self) {
        for address in self.planned.drain(..) {
            self.made.remove(&address);
        }
    }

    /// Returns the memory of the blocks if the last frame had rows, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let buffers = self.pools.iter().flatten().filter(|_| self.frames_without_rows == 0);
        buffers.map(|buffer| buffer.raw.size()).sum()
    }

    /// Returns the number of candidates of each slot, one buffer for each pool.
    pub(crate) fn counts(&self) -> impl Iterator<Item = &Buffer> {
        self.pools.iter().map(|[counts, _]| counts)
    }

    /// Returns pool and slot of each block that the last plan builds.
    pub(crate) fn built(&self) -> &[[usize; 2]] {
        &self.built
    }

    /// Returns pool and slot of each block that the last plan may draw.
    pub(crate) fn seen(&self) -> &[[usize; 2]] {
        &self.seen
    }

    /// Returns whether the next frame of the same view would have more marks.
    pub(crate) fn is_late(&self) -> bool {
        self.is_late
    }

    /// Plans which blocks a frame builds and draws; these then count as built. `is_whole`: all tiles are loaded.
    pub(crate) fn plan(
        &mut self,
        gpu: &Gpu,
        terrain: &Terrain,
        selection: &Selection,
        rig: &Rig,
        rows: &Rows,
        is_whole: bool,
    ) -> RowPlan {
        self.frame += 1;
        self.frames_without_rows = 0;
        self.planned.clear();
        self.built.clear();
        self.seen.clear();
        let pixels = rig.eyes.iter().map(|eye| eye.part.size_px.map(|side| side as f32).iter().product::<f32>());
        let spacing_m = terrain.grid_projection().spacing_m();
        let focal_px = rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max);
        let greatest_level = greatest_level(terrain);
        let max_blocks = POOL_SLOTS * POOLS.end();
        let mut spacing_px = rows.spacing_px;
        let mut needed = std::mem::take(&mut self.needed);
        let mut reach = std::mem::take(&mut self.reach);
        reach.set(terrain, selection, rig, self.culling);
        loop {
            reach.set_spacing(spacing_m * focal_px / f64::from(spacing_px), greatest_level);
            if needed.find(selection, terrain, &reach, max_blocks) {
                break;
            }
            spacing_px *= WIDER;
        }
        let wanted = needed.nearest_first();
        let max_marks = (4096.0 + pixels.fold(0.0, f32::max) * MARKS_PER_SPACING / spacing_px.powi(2)) as u32;
        let rules = RowRules {
            spacing_px,
            row_cells: rows.length / MEAN_CELL,
            level: rows.level_deg.to_radians().tan(),
            stagger: (rows.stagger * SAMPLES_OF_ROW).round(),
            darkest: rows.darkest,
            taper: rows.taper,
            max_marks: max_marks.min(proposals::max_marks(gpu)),
            cell_px_m: (spacing_m * focal_px) as f32,
            min_level: MIN_LEVEL as f32,
            greatest_level: greatest_level as f32,
        };
        let store = terrain.store();
        let address = Arc::as_ptr(store).cast::<()>() as usize;
        let RowRules { row_cells, level, stagger, .. } = rules;
        let made_of = MadeOf { store: address, row_cells, level, stagger };
        if self.made_of.as_ref() != Some(&made_of) {
            self.made.clear();
            self.made_of = Some(made_of);
            self.store = Some(Arc::clone(store));
        }
        let pools = wanted.len().div_ceil(POOL_SLOTS).clamp(*POOLS.start(), *POOLS.end());
        while self.pools.len() < pools {
            let bytes = POOL_SLOTS as u64 * u64::from(MAX_CANDIDATES) * CANDIDATE_BYTES;
            self.pools.push([Buffer::new(gpu, &COUNTS, 4 * POOL_SLOTS as u64), Buffer::new(gpu, &CANDIDATES, bytes)]);
        }
        let mut plan: Vec<PlannedPool> = self
            .pools
            .iter()
            .map(|[counts, candidates]| PlannedPool::new(counts.clone(), candidates.clone()))
            .collect();

        let waits = terrain.options().loading == Loading::Wait;
        let most = if waits { usize::MAX } else { JOBS_AT_ONCE };
        for address in wanted {
            if let Some(made) = self.made.get_mut(address) {
                made.used_in = self.frame;
            }
        }
        let stale = |made: &FxHashMap<Address, Made>, address: &Address| match made.get(address) {
            None => true,
            Some(made) => is_whole && !made.is_whole,
        };
        let mut jobs = 0;
        self.is_late = false;
        for address in wanted {
            let is_stale = stale(&self.made, address);
            if is_stale && jobs < most {
                let known = self.made.get(address).map(|made| made.slot);
                let Some(slot) = known.or_else(|| self.free_slot()) else { continue };
                self.made.insert(*address, Made { slot, used_in: self.frame, is_whole });
                self.planned.push(*address);
                jobs += 1;
                let [pool, slot] = pool_and_slot(slot);
                self.built.push([pool, slot]);
                plan[pool].jobs.push(block(terrain, *address, slot as u32, rig.origin_m));
            } else if is_stale {
                self.is_late = true;
            }
            if let Some(made) = self.made.get(address) {
                let [pool, slot] = pool_and_slot(made.slot);
                self.seen.push([pool, slot]);
                plan[pool].seen.push(block(terrain, *address, slot as u32, rig.origin_m));
            }
        }
        (self.needed, self.reach) = (needed, reach);
        RowPlan { rules, pools: plan }
    }

    /// Returns a free slot, or that of the least recently used block.
    fn free_slot(&mut self) -> Option<u32> {
        let slots = POOL_SLOTS * self.pools.len();
        if self.made.len() < slots {
            let mut taken = vec![false; slots];
            self.made.values().for_each(|made| taken[made.slot as usize] = true);
            return taken.iter().position(|taken| !taken).map(|slot| slot as u32);
        }
        let oldest = self.made.iter().filter(|(_, made)| made.used_in < self.frame);
        let (address, _) = oldest.min_by_key(|(address, made)| (made.used_in, **address))?;
        let address = *address;
        self.made.remove(&address).map(|made| made.slot)
    }
}

/// Returns the pool of a slot, and the slot's number in the pool.
fn pool_and_slot(slot: u32) -> [usize; 2] {
    [slot as usize / POOL_SLOTS, slot as usize % POOL_SLOTS]
}

/// Returns a block in the form that the shaders read, relative to `origin_m`.
fn block(terrain: &Terrain, address: Address, slot: u32, origin_m: DVec3) -> RowBlock {
    let projection = terrain.grid_projection();
    let cell = f64::from(address.level).exp2();
    let corner = DVec2::new(f64::from(address.x), f64::from(address.y)) * (f64::from(CELLS) * cell);
    // The projection is valid inside the grid only, and the largest blocks reach beyond it.
    let size = terrain.store().levels()[0];
    let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
    let middle = corner + 0.5 * f64::from(CELLS) * cell;
    let inside = middle.clamp(DVec2::ZERO, last);
    let along = |step: DVec2| {
        let [behind, ahead] = [-step, step].map(|step| (inside + step).clamp(DVec2::ZERO, last));
        let way_m = projection.world_from_grid(ahead) - projection.world_from_grid(behind);
        way_m * (cell / (ahead - behind).length())
    };
    let (along_x, along_y) = (along(DVec2::X), along(DVec2::Y));
    let beyond = (middle - inside) / cell;
    let inside_m = projection.world_from_grid(inside) - origin_m.truncate();
    RowBlock {
        corner: (corner - projection.anchor(origin_m.truncate())).as_vec2().to_array(),
        middle_m: (inside_m + along_x * beyond.x + along_y * beyond.y).as_vec2().to_array(),
        along_x: along_x.as_vec2().to_array(),
        along_y: along_y.as_vec2().to_array(),
        cell: cell as f32,
        level: address.level as f32,
        slot,
        ..RowBlock::default()
    }
}

/// Returns the level of the block that covers the whole grid.
fn greatest_level(terrain: &Terrain) -> i32 {
    let size = terrain.store().levels()[0];
    let blocks = size.width.max(size.height).div_ceil(CELLS as u32).max(1);
    blocks.next_power_of_two().trailing_zeros() as i32
}
