//! The statistics of every tile and every mesh patch.

use super::levels::LevelSize;
use crate::pyramid::tile::{PATCH_QUADS, TILE_SAMPLES, TileAddress, is_void};

/// Number of patches along the side of a page.
pub(crate) const PAGE_PATCHES: u32 = TILE_SAMPLES / PATCH_QUADS;

/// The extent of no-data in a set of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voids {
    /// Every sample has a height.
    None,
    /// Some samples have a height.
    Some,
    /// No sample has a height.
    All,
}

/// The statistics of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileStatistics {
    /// Lowest valid sample of the tile, of the ring of one sample around it, and of its children, in metres; NaN if all
    /// are no-data. The surface between the samples may pass a little below it.
    pub min_m: f32,
    /// Highest valid sample, of the same samples, in metres.
    pub max_m: f32,
    /// The largest |H(f) − h(f)| in metres over the full-resolution valid samples f in the tile's area, where H is the
    /// surface of this level as stored and h the original height; at least that of the tile's children.
    pub error_m: f32,
    /// At the tile's corners (north-west, north-east, south-west, south-east), the largest error of the up to four
    /// tiles that meet there, in metres. The level of the surface follows these, so it has no steps between tiles.
    pub corner_errors_m: [f32; 4],
    /// The no-data of the tile and of the ring of one sample around it.
    pub voids: Voids,
}

/// The statistics of a mesh patch: 16 × 16 quads of stride 2^j samples of level 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchStatistics {
    /// Lowest valid sample in metres, edges included; NaN if all are no-data.
    pub min_m: f32,
    /// Highest valid sample in metres, edges included.
    pub max_m: f32,
    /// Largest distance of the patch's triangles from the data, in metres; at least that of the patch's children.
    pub mesh_error_m: f32,
    /// The no-data of the patch, edges included.
    pub voids: Voids,
}

/// The mesh patches that come with a tile of level L: the 16 × 16 patches of stride 2^L whose columns and rows begin at
/// 16 times the tile's.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchPage {
    patches: Box<[PatchStatistics]>,
}

impl PatchPage {
    /// Creates a page of 256 patches, row by row; those beyond the grid are [`PatchPage::NOTHING`].
    ///
    /// # Panics
    /// If `patches` does not have 256 elements.
    pub fn new(patches: Vec<PatchStatistics>) -> Self {
        assert_eq!(patches.len(), (PAGE_PATCHES * PAGE_PATCHES) as usize);
        Self { patches: patches.into() }
    }

    /// A patch beyond the grid.
    pub(crate) const NOTHING: PatchStatistics =
        PatchStatistics { min_m: f32::NAN, max_m: f32::NAN, mesh_error_m: 0.0, voids: Voids::All };

    /// Returns the patch in column `x` and row `y` of the page.
    pub fn get(&self, x: u32, y: u32) -> &PatchStatistics {
        &self.patches[(y * PAGE_PATCHES + x) as usize]
    }

    /// Returns all 256 patches, row by row.
    pub(crate) fn patches(&self) -> &[PatchStatistics] {
        &self.patches
    }

    /// Returns all 256 patches, row by row, to be changed in place.
    pub(crate) fn patches_mut(&mut self) -> &mut [PatchStatistics] {
        &mut self.patches
    }
}

/// The statistics of a whole pyramid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Statistics {
    /// The tiles of each level, row-major.
    pub tiles: Vec<Vec<TileStatistics>>,
    /// The patches of each stride 2^j, row-major.
    pub patches: Vec<Vec<PatchStatistics>>,
}

/// Returns the number of patches of stride 2^`j` in x and y over a grid of `finest` samples.
pub(crate) fn patch_counts(finest: LevelSize, j: u32) -> (u32, u32) {
    let side = u64::from(PATCH_QUADS) << j;
    // A count never exceeds the number of samples.
    let count = |samples: u32| u64::from(samples.saturating_sub(1)).div_ceil(side) as u32;
    (count(finest.width), count(finest.height))
}

/// Returns the number of strides of patches, up to the one at which one patch covers the whole grid.
pub(crate) fn patch_levels(finest: LevelSize) -> u32 {
    let mut j = 0;
    while patch_counts(finest, j).0 > 1 || patch_counts(finest, j).1 > 1 {
        j += 1;
    }
    j + 1
}

/// Returns the index of a tile in `tiles[level]`, or `None` if there is no such tile.
pub(crate) fn tile_index(sizes: &[LevelSize], address: TileAddress) -> Option<usize> {
    let size = sizes.get(address.level as usize)?;
    (address.x < size.tiles_x() && address.y < size.tiles_y())
        .then(|| address.y as usize * size.tiles_x() as usize + address.x as usize)
}

/// The height range and no-data of samples, while they are accumulated.
#[derive(Clone, Copy)]
pub(in crate::pyramid) struct Range {
    /// Lowest height in metres; NaN if there is none yet.
    pub min_m: f32,
    pub max_m: f32,
    valid: bool,
    void: bool,
}

impl Range {
    pub(crate) const EMPTY: Self = Self { min_m: f32::NAN, max_m: f32::NAN, valid: false, void: false };

    /// Adds served samples (see [`is_void`]).
    pub(crate) fn add(&mut self, served: &[f32]) {
        for &height in served {
            if is_void(height) {
                self.void = true;
            } else {
                self.valid = true;
                // f32::min and max ignore NaN.
                self.min_m = self.min_m.min(height);
                self.max_m = self.max_m.max(height);
            }
        }
    }

    /// Adds a range whose heights may be wrong by up to `doubt_m`.
    pub(crate) fn join(&mut self, other: Self, doubt_m: f64) {
        self.void |= other.void;
        self.valid |= other.valid;
        let (low, high) = (f64::from(other.min_m) - doubt_m, f64::from(other.max_m) + doubt_m);
        self.min_m = self.min_m.min(-rounded_up(-low));
        self.max_m = self.max_m.max(rounded_up(high));
    }

    pub(crate) fn voids(self) -> Voids {
        match (self.valid, self.void) {
            (true, true) => Voids::Some,
            (true, false) => Voids::None,
            (false, _) => Voids::All,
        }
    }
}

impl Voids {
    pub(in crate::pyramid) fn union(self, other: Self) -> Self {
        if self == other { self } else { Self::Some }
    }

    /// Returns the no-data of an area that also has a height somewhere.
    pub(in crate::pyramid) fn with_land(self) -> Self {
        if self == Self::All { Self::Some } else { self }
    }
}

/// Returns the smallest f32 that is not below `value`, because an error must not be rounded down.
pub(in crate::pyramid) fn rounded_up(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}
