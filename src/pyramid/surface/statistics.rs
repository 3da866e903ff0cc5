//! What is known of every tile and every mesh patch without reading it.

use super::levels::LevelSize;
use crate::pyramid::tile::{PATCH_QUADS, TILE_SAMPLES, TileAddress, is_void};

/// Patches along the side of a page.
pub const PAGE_PATCHES: u32 = TILE_SAMPLES / PATCH_QUADS;

/// How much of a set of samples is void.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voids {
    /// Every sample has a height.
    None,
    /// Some samples have a height.
    Some,
    /// No sample has a height.
    All,
}

/// What is known of one tile of one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileStatistics {
    /// Lowest valid sample of the tile and the ring of one sample around it, and of its children, in metres; NaN if
    /// all are void. The surface between the samples may pass a little below it.
    pub min_m: f32,
    /// Highest, likewise.
    pub max_m: f32,
    /// The largest |H(f) − h(f)| in metres over the full-resolution valid samples f in the tile's area, where H is the
    /// surface of this level as stored and h the original height; at least that of the tile's children.
    pub error_m: f32,
    /// At the tile's corners (north-west, north-east, south-west, south-east), the largest error of the up to four
    /// tiles that meet there: what the surface's level follows, since it has no steps between tiles.
    pub corner_errors_m: [f32; 4],
    /// How many samples of the tile and the ring of one sample around it are void.
    pub voids: Voids,
}

/// One mesh patch: 16 × 16 quads of stride 2^j samples of level 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchStatistics {
    /// Lowest valid sample in metres, edges included; NaN if all are void.
    pub min_m: f32,
    /// Highest, likewise.
    pub max_m: f32,
    /// How far the patch's triangles are from the data at most, in metres; at least that of the patch's children.
    pub mesh_error_m: f32,
    /// How many samples of the patch, edges included, are void.
    pub voids: Voids,
}

/// The mesh patches that come with a tile of level L: the 16 × 16 patches of stride 2^L whose columns and rows begin
/// at 16 times the tile's.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchPage {
    patches: Box<[PatchStatistics]>,
}

impl PatchPage {
    /// From 256 patches, row by row; those beyond the grid are [`PatchPage::NOTHING`].
    ///
    /// # Panics
    /// If they are not 256.
    pub fn new(patches: Vec<PatchStatistics>) -> Self {
        assert_eq!(patches.len(), (PAGE_PATCHES * PAGE_PATCHES) as usize);
        Self { patches: patches.into() }
    }

    /// A patch beyond the grid.
    pub const NOTHING: PatchStatistics =
        PatchStatistics { min_m: f32::NAN, max_m: f32::NAN, mesh_error_m: 0.0, voids: Voids::All };

    /// The patch in column `x` and row `y` of the page.
    pub fn get(&self, x: u32, y: u32) -> &PatchStatistics {
        &self.patches[(y * PAGE_PATCHES + x) as usize]
    }

    /// All 256 patches, row by row.
    pub fn patches(&self) -> &[PatchStatistics] {
        &self.patches
    }

    /// All 256 patches, row by row, to be changed in place.
    pub fn patches_mut(&mut self) -> &mut [PatchStatistics] {
        &mut self.patches
    }
}

/// The statistics of a whole pyramid.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// For each level the tiles, row-major.
    pub tiles: Vec<Vec<TileStatistics>>,
    /// For each stride 2^j the patches, row-major.
    pub patches: Vec<Vec<PatchStatistics>>,
}

/// How many patches of stride 2^`j` there are in x and y over a grid of `finest` samples.
pub fn patch_counts(finest: LevelSize, j: u32) -> (u32, u32) {
    let side = u64::from(PATCH_QUADS) << j;
    // A count never exceeds the number of samples.
    let count = |samples: u32| u64::from(samples.saturating_sub(1)).div_ceil(side) as u32;
    (count(finest.width), count(finest.height))
}

/// How many strides of patches there are: until one patch covers the whole grid.
pub fn patch_levels(finest: LevelSize) -> u32 {
    let mut j = 0;
    while patch_counts(finest, j).0 > 1 || patch_counts(finest, j).1 > 1 {
        j += 1;
    }
    j + 1
}

/// Where the statistics of a tile lie in `tiles[level]`; none if there is no such tile.
pub fn tile_index(sizes: &[LevelSize], address: TileAddress) -> Option<usize> {
    let size = sizes.get(address.level as usize)?;
    (address.x < size.tiles_x() && address.y < size.tiles_y())
        .then(|| address.y as usize * size.tiles_x() as usize + address.x as usize)
}

/// Lowest and highest height and the voids of some samples, as they gather.
#[derive(Clone, Copy)]
pub(in crate::pyramid) struct Range {
    /// NaN if there is no height yet.
    pub min_m: f32,
    pub max_m: f32,
    valid: bool,
    void: bool,
}

impl Range {
    pub const EMPTY: Self = Self { min_m: f32::NAN, max_m: f32::NAN, valid: false, void: false };

    /// Adds served samples (see [`is_void`]).
    pub fn add(&mut self, served: &[f32]) {
        for &height in served {
            if is_void(height) {
                self.void = true;
            } else {
                self.valid = true;
                // f32::min and max take the other operand for NaN.
                self.min_m = self.min_m.min(height);
                self.max_m = self.max_m.max(height);
            }
        }
    }

    /// Adds a range whose heights may be off by `doubt_m`.
    pub fn join(&mut self, other: Self, doubt_m: f64) {
        self.void |= other.void;
        self.valid |= other.valid;
        let (low, high) = (f64::from(other.min_m) - doubt_m, f64::from(other.max_m) + doubt_m);
        self.min_m = self.min_m.min(-rounded_up(-low));
        self.max_m = self.max_m.max(rounded_up(high));
    }

    pub fn voids(self) -> Voids {
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
}

/// The f32 that is not below `value`: an error may not be rounded down.
pub(in crate::pyramid) fn rounded_up(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}
