//! Which mesh patches are drawn, and how far each morphs: level of detail by measured error.
//!
//! A patch (level j, column x, row y) covers samples 16·2^j·x to 16·2^j·(x+1) with 16 × 16 quads; negative levels are
//! finer than the data and are evaluated, not loaded. A patch is split while its measured mesh error, seen from the
//! nearest point of its box, is more than the allowed error in pixels. What is left covers the view once.
//!
//! Each leaf has a continuous level: its own, plus how far it is on the way to its parent's error. At that way's end
//! all four siblings have the shape of their parent, so nothing pops. Where two leaves meet, both take the coarser of
//! their continuous levels on the shared edge (`shaders/surface/land/vertices.wgsl` morphs to it): there is no crack
//! and no rule that neighbours differ by one level at most. The only rule is that a leaf's corners exist on its
//! neighbours' levels, hence at most `MAX_LEVEL_STEP`.
//!
//! Patches are visited from near to far, and what is hidden behind nearer land (`horizon`) is left out.
//!
//! Land may be so steep that its error is many times as long as its quads are wide: spikes, damaged samples, marks for
//! no data that nobody declared. There a height is found again a little to the side: where quads are no wider than a
//! quarter of the allowed error, a patch stays whole, whatever its error in height, and up to half of it some do. So
//! what is promised is the allowed error in height, or half of it sideways. How many patches a frame may have
//! altogether is in `budget`.
//!
//! Here are the patches, the viewpoint and the result; `walk` chooses, `leaves` knows how the chosen ones meet, and
//! `select` is where it begins.
//!
//! What is known of patches comes with tiles. Where it has not come yet, a patch stays whole; when it comes, the
//! patch's children begin in their parent's shape and fade in.
//!
//! Why: `docs/decisions/level-of-detail.md`.

use glam::{DVec2, DVec3};

use super::earth_curvature::EarthCurvature;
pub use crate::gpu::wgsl::shared::patch::Patch as PatchInstance;
use crate::pyramid::LevelSize;
use crate::pyramid::tile::PATCH_QUADS;
use crate::scene::frustum::Frustum;

/// Log2 of the grid units in a sample: positions of vertices are whole numbers of these. 4096 to a sample, or fewer in
/// a world so wide that its patches would not fit into 31 bits.
pub fn units_log2(finest: LevelSize) -> i32 {
    let side = finest.width.max(finest.height).next_power_of_two();
    (30 - side.ilog2() as i32).min(12)
}

/// Where in the quadtree of patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PatchKey {
    /// Log2 of samples between vertices; negative is finer than the data.
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

    pub(super) fn parent(self) -> Self {
        Self { level: self.level + 1, x: self.x >> 1, y: self.y >> 1 }
    }

    /// First sample and side in samples.
    pub fn area(self) -> (DVec2, f64) {
        let side = f64::from(PATCH_QUADS) * f64::from(self.level).exp2();
        (DVec2::new(self.x as f64, self.y as f64) * side, side)
    }
}

/// The view that patches are chosen for.
#[derive(Clone, Debug)]
pub struct Viewpoint {
    /// The camera's place in the world, in metres.
    pub camera_m: DVec3,
    /// What is in view; several eyes or parts of a picture each have one.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian in the middle of the picture.
    pub focal_px: f64,
    /// The mesh error that is allowed, in pixels.
    pub error_px: f64,
    /// The curvature of the earth around this camera.
    pub earth_curvature: EarthCurvature,
    /// Whether near land hides far land: the camera stands above the ground. From below one sees through.
    pub is_above_ground: bool,
    /// No part of the surface is nearer than this: half the camera's height above ground.
    pub nearest_m: f64,
}

/// The patches of a frame.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Patches without holes, nearest first.
    pub solid: Vec<PatchInstance>,
    /// Patches that have void samples, nearest first.
    pub with_holes: Vec<PatchInstance>,
    /// The leaves in the order of `solid`, then `with_holes`.
    pub leaves: Vec<PatchKey>,
    /// From the camera to the nearest and to the farthest point of each of their boxes.
    pub distances_m: Vec<[f64; 2]>,
}

impl Selection {
    /// How many triangles the patches have.
    pub fn triangles(&self) -> u64 {
        (self.solid.len() + self.with_holes.len()) as u64 * 2 * u64::from(PATCH_QUADS) * u64::from(PATCH_QUADS)
    }
}

/// The patches of the same level beside the first column, last column, first row and last row.
pub(super) fn neighbours(key: PatchKey) -> [PatchKey; 4] {
    let beside = |dx, dy| PatchKey { x: key.x + dx, y: key.y + dy, ..key };
    [beside(-1, 0), beside(1, 0), beside(0, -1), beside(0, 1)]
}

/// A number that names a patch from frame to frame: FNV-1a over its key, never 0.
pub(super) fn patch_id(key: PatchKey) -> u32 {
    let mut hash = 0x811c_9dc5_u32;
    for byte in (key.level as i64).to_le_bytes().iter().chain(&key.x.to_le_bytes()).chain(&key.y.to_le_bytes()) {
        hash = (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
    }
    hash.max(1)
}
