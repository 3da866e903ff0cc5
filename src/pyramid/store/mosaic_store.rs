//! Several pyramids as one, without baking them again: tiles are composed on demand.
//!
//! The grid is that of [`crate::source::mosaic`]. It is sparse: at levels finer than a member's own, tiles exist only
//! where a finer member is, and next to it; elsewhere the coarser tile is the finest. A tile is composed from the
//! members' tiles of the matching level, the finer member over the coarser. Samples on the member's lattice are copied
//! bit for bit; others are evaluated on the bicubic surface of the member's level, whose outermost polynomial is
//! continued half a sample beyond, which is where an abutting member begins. Toward its border a member fades into the
//! members under it, over one sample of its own level, or over two samples of a coarser member's, so that there is no
//! step. No-data does not fade. Statistics are those of [`derive()`](super::derive()).
//!
//! Why: `docs/decisions/mosaics.md`.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::derive::{coarse_patches, derive};
use super::small_members::SmallMembers;
use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::bicubic;
use crate::pyramid::surface::levels::{LevelSize, coordinate, level_sizes};
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::{TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress, flagged, is_void};
use crate::source::Window;
use crate::source::georeference::Georeference;
use crate::source::mosaic::{Misfit, MosaicGrid, Placed, precedence};

/// Number of cached member tiles, of 264 KiB each.
const KEPT_TILES: usize = 64;

/// A tile of a member: the member's index, and the tile's address.
type Key = (usize, TileAddress);

/// Several pyramids as one; tiles are composed on demand.
pub(crate) struct MosaicStore {
    name: String,
    grid: MosaicGrid,
    levels: Vec<LevelSize>,
    members: Vec<Arc<dyn TileStore>>,
    /// Indices of the members, the uppermost first.
    precedence: Vec<usize>,
    range_m: [f32; 2],
    coarse_patches: Vec<Vec<PatchStatistics>>,
    /// Cached member tiles, most recently used first.
    kept: Mutex<VecDeque<(Key, Arc<Tile>)>>,
}

impl MosaicStore {
    /// Combines `members`; among those of the same spacing, the earlier covers the later.
    ///
    /// # Errors
    /// If the members do not fit a common grid, or the coarsest tile cannot be read.
    pub(crate) fn new(members: Vec<Arc<dyn TileStore>>) -> Result<Self, PyramidError> {
        let name = members.iter().map(|member| member.name()).collect::<Vec<_>>().join(", ");
        let places: Vec<_> = members
            .iter()
            .map(|member| (member.georeference(), [member.levels()[0].width, member.levels()[0].height]))
            .collect();
        let grid = MosaicGrid::new(&places).map_err(|Misfit { member, cause }| {
            let path = members.get(member).map_or_else(|| name.clone(), |member| member.name()).into();
            PyramidError::BadGrid { path, cause }
        })?;
        grid.warn();
        let levels = level_sizes(grid.size[0], grid.size[1]);
        let range_m = members
            .iter()
            .map(|member| member.range_m())
            .fold([f32::NAN; 2], |[low, high], range| [low.min(range[0]), high.max(range[1])]);
        let precedence = precedence(&grid);
        let mut store = Self {
            name,
            grid,
            levels,
            members,
            precedence,
            range_m,
            coarse_patches: Vec::new(),
            kept: Mutex::default(),
        };
        let top = TileAddress { level: store.levels.len() as u32 - 1, x: 0, y: 0 };
        store.coarse_patches = coarse_patches(&store.levels, &store.compose(top, &Cancel::default())?);
        Ok(store)
    }

    /// Returns the finest level of the mosaic at which a member has data of its own.
    fn first_level(placed: &Placed) -> u32 {
        placed.ratio.log2().round().max(0.0) as u32
    }

    /// Returns the window of level 0 under a tile's own samples and `around` more tiles of its level on every side.
    fn area(&self, address: TileAddress, around: u32) -> Window {
        let size = self.levels[address.level as usize];
        let span = |tile: u32, finest: u32, count: u32| {
            let at = |tile: u32| {
                let sample = f64::from((tile * TILE_SAMPLES).min(count));
                sample * f64::from(finest) / f64::from(count)
            };
            let (first, end) = (at(tile.saturating_sub(around)).floor() as u32, at(tile + 1 + around).ceil() as u32);
            (first, end.min(finest).max(first + 1) - first)
        };
        let (x, width) = span(address.x, self.grid.size[0], size.width);
        let (y, height) = span(address.y, self.grid.size[1], size.height);
        Window { x, y, width, height }
    }

    /// Returns whether a tile is on or near a member that has data of its own at the tile's level.
    ///
    /// A tile is drawn in full detail only where the tiles around it exist and their parents are unblocked as well
    /// (`tiles::residency_floor`); without tiles beyond its border a member would be coarse along it. At its finest
    /// level a member has one more tile on every side. At coarser levels it has the parents of those and one tile
    /// around them: 3/2 tiles, then 7/4, always less than two.
    fn is_near(&self, placed: &Placed, address: TileAddress) -> bool {
        let finest = Self::first_level(placed);
        let around = if address.level == finest { 1 } else { 2 };
        finest <= address.level && placed.meets(self.area(address, around))
    }

    fn compose(&self, address: TileAddress, cancel: &Cancel) -> Result<LoadedTile, PyramidError> {
        if !self.has_tile(address) {
            return Err(PyramidError::NoSuchTile { path: self.name.clone().into(), address });
        }
        let mut sheet = Sheet::new(&self.levels, address);
        // From the bottom to the top.
        for &index in self.precedence.iter().rev() {
            self.lay(index, address, &mut sheet, cancel)?;
        }
        sheet.continue_members();
        let fallback_m = if self.range_m[0].is_finite() { self.range_m[0] } else { 0.0 };
        let samples = sheet.heights_m.iter().zip(&sheet.voids).map(|(&height, &void)| match height.is_nan() {
            true => flagged(fallback_m, true),
            false => flagged(height, void),
        });
        let loaded = derive(&self.levels, address, Tile { samples: samples.collect() });
        Ok(SmallMembers::at(&self.grid.members, &self.members, self.levels[0], address).noted_in(loaded))
    }

    /// Composes a member over the existing samples.
    fn lay(&self, index: usize, address: TileAddress, sheet: &mut Sheet, cancel: &Cancel) -> Result<(), PyramidError> {
        let (placed, store) = (&self.grid.members[index], &self.members[index]);
        let members = || self.grid.members.iter();
        let inset = members().any(|other| other.ratio > placed.ratio * 1.5);
        let alike: Vec<&Placed> = members()
            .enumerate()
            .filter(|(other, member)| *other != index && (member.ratio / placed.ratio - 1.0).abs() < 0.5)
            .map(|(_, member)| member)
            .collect();
        let sizes = store.levels();
        let wanted = address.level.saturating_sub(Self::first_level(placed)) as usize;
        let level = wanted.min(sizes.len() - 1);
        let (finest, size) = (sizes[0], sizes[level]);
        let places = placed.coordinates(sheet.first, sheet.step, [TILE_STRIDE, TILE_STRIDE]);
        // The width of the fade in samples of the member's level: two samples of a coarser member's.
        let fade = 4.0_f64.max(8.0 / f64::from(1_u32 << level));
        let fade_finest = fade * placed.ratio * f64::from(1_u32 << level);
        let mut tiles = MemberTiles { store: self, index, level: level as u32, last: None };
        for (i, place) in places.into_iter().enumerate() {
            let x = coordinate(place[0], finest.width, size.width);
            let y = coordinate(place[1], finest.height, size.height);
            let depths = [x + 0.5, f64::from(size.width) - 0.5 - x, y + 0.5, f64::from(size.height) - 0.5 - y];
            if depths.iter().any(|depth| depth.is_nan() || *depth < -1e-6) {
                continue;
            }
            if cancel.is_cancelled() {
                return Err(PyramidError::Cancelled);
            }
            let mut weight = 1.0_f64;
            for (depth, toward) in depths.into_iter().zip([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]]) {
                if depth < 1.0 || inset && depth < fade {
                    let from = sheet.place(i);
                    let beyond = [0, 1].map(|axis| from[axis] + toward[axis] * fade_finest);
                    let goes_on = !inset || alike.iter().any(|other| other.holds(beyond));
                    weight = weight.min(if goes_on { depth } else { depth / fade });
                }
            }
            let (height_m, void) = tiles.sample(size, x, y)?;
            sheet.put(i, height_m, void, weight.clamp(0.0, 1.0));
        }
        Ok(())
    }

    /// Returns a member's tile, from the cache or from its store.
    fn tile(&self, key: Key) -> Result<Arc<Tile>, PyramidError> {
        // The lock guards only a cache, which is consistent between statements, so poisoning is harmless.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|(known, _)| *known == key)
            && let Some(found) = kept.remove(at)
        {
            let tile = found.1.clone();
            kept.push_front(found);
            return Ok(tile);
        }
        drop(kept);
        let (index, address) = key;
        let tile = Arc::new(self.members[index].clone().load(address)?.tile);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_front((key, tile.clone()));
        kept.truncate(KEPT_TILES);
        Ok(tile)
    }
}

/// A tile that is being composed.
struct Sheet {
    /// The position of the first sample, in samples of level 0.
    first: [f64; 2],
    step: [f64; 2],
    /// Heights in metres; NaN where no member has been composed yet.
    heights_m: Vec<f32>,
    voids: Vec<bool>,
}

impl Sheet {
    fn new(levels: &[LevelSize], address: TileAddress) -> Self {
        let (finest, size) = (levels[0], levels[address.level as usize]);
        let first = |tile: u32, finest: u32, count: u32| {
            let sample = f64::from(tile * TILE_SAMPLES) - f64::from(TILE_BORDER);
            coordinate(sample, count, finest)
        };
        let step = |finest: u32, count: u32| f64::from(finest) / f64::from(count);
        Self {
            first: [first(address.x, finest.width, size.width), first(address.y, finest.height, size.height)],
            step: [step(finest.width, size.width), step(finest.height, size.height)],
            heights_m: vec![f32::NAN; (TILE_STRIDE * TILE_STRIDE) as usize],
            voids: vec![true; (TILE_STRIDE * TILE_STRIDE) as usize],
        }
    }

    /// Returns the position of a sample, in samples of level 0.
    fn place(&self, i: usize) -> [f64; 2] {
        let at = [i as u32 % TILE_STRIDE, i as u32 / TILE_STRIDE];
        [0, 1].map(|axis| self.first[axis] + self.step[axis] * f64::from(at[axis]))
    }

    /// Gives the samples next to a member the mean of the member's samples around them, weighted by 1/distance⁴ as in
    /// [`crate::pyramid::surface::fill`]. The surface reads one sample beyond the outermost of a member, which must not
    /// bend it. Tiles that share such a sample agree on it, because each has all samples around it.
    fn continue_members(&mut self) {
        let side = TILE_STRIDE as usize;
        let known = self.heights_m.clone();
        for (i, height_m) in self.heights_m.iter_mut().enumerate().filter(|(_, height_m)| height_m.is_nan()) {
            let (column, row) = (i % side, i / side);
            let (mut sum, mut total) = (0.0, 0.0);
            for y in row.saturating_sub(1)..(row + 2).min(side) {
                for x in column.saturating_sub(1)..(column + 2).min(side) {
                    let near_m = f64::from(known[y * side + x]);
                    let weight = if x == column || y == row { 1.0 } else { 0.25 };
                    if !near_m.is_nan() {
                        sum += weight * near_m;
                        total += weight;
                    }
                }
            }
            if total > 0.0 {
                *height_m = (sum / total) as f32;
            }
        }
    }

    /// Composes a height over the existing one.
    fn put(&mut self, i: usize, height_m: f32, void: bool, weight: f64) {
        let (there_m, there_void) = (&mut self.heights_m[i], &mut self.voids[i]);
        if there_m.is_nan() || *there_void && !void {
            (*there_m, *there_void) = (height_m, void);
        } else if !void {
            *there_m += (weight * (f64::from(height_m) - f64::from(*there_m))) as f32;
            if weight == 1.0 {
                *there_m = height_m;
            }
        }
    }
}

/// The samples of a member's level.
struct MemberTiles<'a> {
    store: &'a MosaicStore,
    index: usize,
    level: u32,
    /// The last tile that was read; neighbouring samples are usually in the same tile.
    last: Option<(TileAddress, Arc<Tile>)>,
}

impl MemberTiles<'_> {
    /// Returns the height in metres at a place of the level, and whether it is no-data.
    fn sample(&mut self, size: LevelSize, x: f64, y: f64) -> Result<(f32, bool), PyramidError> {
        const WHOLE: f64 = 1e-3;
        let (column, row) = (x.round(), y.round());
        let (mut near_x, mut near_y) = (column.max(0.0) as u32, row.max(0.0) as u32);
        (near_x, near_y) = (near_x.min(size.width - 1), near_y.min(size.height - 1));
        let (cell_x, u) = bicubic::cell(x, size.width);
        let (cell_y, v) = bicubic::cell(y, size.height);
        let address = TileAddress { level: self.level, x: cell_x / TILE_SAMPLES, y: cell_y / TILE_SAMPLES };
        let tile = match &self.last {
            Some((known, tile)) if *known == address => tile.clone(),
            _ => {
                let tile = self.store.tile((self.index, address))?;
                self.last = Some((address, tile.clone()));
                tile
            }
        };
        let at = |column: u32, row: u32| {
            let (column, row) =
                (column + TILE_BORDER - address.x * TILE_SAMPLES, row + TILE_BORDER - address.y * TILE_SAMPLES);
            tile.samples[(row * TILE_STRIDE + column) as usize]
        };
        let near = at(near_x, near_y);
        if (x - column).abs() < WHOLE && (y - row).abs() < WHOLE {
            return Ok((near, is_void(near)));
        }
        let (left, top) = (cell_x + TILE_BORDER - 1, cell_y + TILE_BORDER - 1);
        let (left, top) = (left - address.x * TILE_SAMPLES, top - address.y * TILE_SAMPLES);
        let four: [[f32; 4]; 4] = std::array::from_fn(|k| {
            let start = ((top + k as u32) * TILE_STRIDE + left) as usize;
            std::array::from_fn(|i| tile.samples[start + i])
        });
        Ok((bicubic::height_and_gradient(&four, u, v).0 as f32, is_void(near)))
    }
}

impl TileStore for MosaicStore {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn levels(&self) -> &[LevelSize] {
        &self.levels
    }

    fn georeference(&self) -> &Georeference {
        &self.grid.georeference
    }

    fn range_m(&self) -> [f32; 2] {
        self.range_m
    }

    fn is_measured(&self) -> bool {
        false
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.coarse_patches
    }

    fn has_tile(&self, address: TileAddress) -> bool {
        let Some(size) = self.levels.get(address.level as usize) else { return false };
        if address.x >= size.tiles_x() || address.y >= size.tiles_y() {
            return false;
        }
        // The coarsest tile always exists: something has to be drawn.
        address.level + 1 == self.levels.len() as u32
            || self.grid.members.iter().any(|placed| self.is_near(placed, address))
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        let cancel = cancel.clone();
        Ok(Box::new(move || self.compose(address, &cancel)))
    }
}
