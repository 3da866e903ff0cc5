//! The mesh patches that are drawn, and how far each morphs: level of detail by measured error.
//!
//! A patch (level j, column x, row y) covers samples 16·2^j·x to 16·2^j·(x+1) with 16 × 16 quads; negative levels are
//! finer than the data and are evaluated, not loaded. A patch is split while its measured mesh error, seen from the
//! nearest point of its box, exceeds the allowed error in pixels. The leaves cover the view exactly once.
//!
//! Each leaf has a continuous level: its own, plus a fraction that grows from 0 to 1 as the allowed error grows from
//! the leaf's error to its parent's. At 1 all four siblings have the shape of their parent, so nothing pops. Where two
//! leaves meet, both take the coarser of their continuous levels on the shared edge
//! (`shaders/surface/land/vertices.wgsl` morphs to it): there are no cracks, and neighbours may differ by more than one
//! level. The only rule is that the corners of a leaf must exist on its neighbours' levels, hence at most
//! `MAX_LEVEL_STEP`.
//!
//! Patches are visited from near to far, and those hidden behind nearer land (`skyline`) are skipped.
//!
//! Land may be so steep that its error is many times the width of its quads: spikes, damaged samples, undeclared
//! no-data values. There the same height is found a little to the side: a patch whose quads are no wider than a quarter
//! of the allowed error is never split, whatever its error in height, and with quads up to half of it some are not. So
//! the guarantee is the allowed error in height, or half of it sideways. The number of patches of a frame is limited by
//! `budget`.
//!
//! This module defines the patches, the viewpoint and the result; `patch_tree` keeps the quadtree between frames,
//! `walk` selects, and `select` is the entry point.
//!
//! The statistics of patches come with tiles. As long as they are missing, a patch is not split; when they arrive, the
//! patch's children begin in their parent's shape and fade in.
//!
//! Why: `docs/decisions/level-of-detail.md`.

use glam::{DVec2, DVec3};

use super::earth_curvature::EarthCurvature;
pub(crate) use crate::gpu::wgsl::shared::patch::Patch as PatchInstance;
use crate::pyramid::LevelSize;
use crate::pyramid::tile::PATCH_QUADS;
use crate::scene::frustum::Frustum;

/// Returns the log2 of the grid units per sample: positions of vertices are whole numbers of these units. 4096 per
/// sample, or fewer in a world so wide that its patches would not fit into 31 bits.
pub(crate) fn units_log2(finest: LevelSize) -> i32 {
    let side = finest.width.max(finest.height).next_power_of_two();
    (30 - side.ilog2() as i32).min(12)
}

/// The position of a patch in the quadtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PatchKey {
    /// Log2 of the number of samples between vertices; negative is finer than the data.
    pub level: i32,
    /// Column, in patches of this level.
    pub x: i64,
    /// Row, in patches of this level.
    pub y: i64,
}

impl PatchKey {
    pub(super) fn children(self) -> [Self; 4] {
        let child = |dx, dy| Self { level: self.level - 1, x: 2 * self.x + dx, y: 2 * self.y + dy };
        [child(0, 0), child(1, 0), child(0, 1), child(1, 1)]
    }

    /// Returns the first sample, and the side in samples.
    pub fn area(self) -> (DVec2, f64) {
        let side = f64::from(PATCH_QUADS) * f64::from(self.level).exp2();
        (DVec2::new(self.x as f64, self.y as f64) * side, side)
    }
}

/// The view that patches are selected for.
#[derive(Clone, Debug)]
pub struct Viewpoint {
    /// Position of the camera in the world, in metres.
    pub camera_m: DVec3,
    /// The view frusta; one for each eye or part of a picture.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian in the middle of the picture.
    pub focal_px: f64,
    /// The allowed mesh error, in pixels.
    pub error_px: f64,
    /// The curvature of the earth around this camera.
    pub earth_curvature: EarthCurvature,
    /// Whether the camera is above the ground, so that near land hides far land. From below, one sees through the land.
    pub is_above_ground: bool,
    /// Lower bound of the distance to the surface, in metres: half the camera's height above ground.
    pub nearest_m: f64,
}

/// The selected patches of a frame.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Patches without holes, nearest first.
    pub solid: Vec<PatchInstance>,
    /// Patches with no-data samples, nearest first.
    pub with_holes: Vec<PatchInstance>,
    /// The leaves in the order of `solid`, then `with_holes`.
    pub leaves: Vec<PatchKey>,
    /// Distances from the camera to the nearest and to the farthest point of each of their boxes, in metres.
    pub distances_m: Vec<[f64; 2]>,
    /// The least and the greatest height of their boxes in the world, in metres; `None` without leaves.
    pub range_m: Option<[f64; 2]>,
}

impl Selection {
    /// Returns the number of triangles of the patches.
    pub fn triangles(&self) -> u64 {
        (self.solid.len() + self.with_holes.len()) as u64 * 2 * u64::from(PATCH_QUADS) * u64::from(PATCH_QUADS)
    }
}

/// Returns a number that identifies a patch from frame to frame: FNV-1a of its key, never 0.
pub(super) fn patch_id(key: PatchKey) -> u32 {
    let mut hash = 0x811c_9dc5_u32;
    for byte in (key.level as i64).to_le_bytes().iter().chain(&key.x.to_le_bytes()).chain(&key.y.to_le_bytes()) {
        hash = (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
    }
    hash.max(1)
}
