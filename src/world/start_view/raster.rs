//! Heights of a world on a lattice whose columns run east and whose rows run north, from a coarse level of the pyramid.

use std::sync::Arc;

use glam::{DVec2, UVec2};
use rustc_hash::FxHashMap;

use crate::pyramid::PyramidError;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::tile::TileAddress;
use crate::tiles::Terrain;

/// Largest number of cells along a side.
const MOST_CELLS: u32 = 768;
/// Number of places along each side of an area whose positions on the grid are computed.
const SIDE_PLACES: u32 = 9;

/// Heights on a lattice. Cells without data are NaN.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    /// The centre of the first cell: east and north in metres.
    first_m: DVec2,
    /// Side of a cell in metres.
    pub cell_m: f64,
    /// Number of columns and rows.
    pub size: [usize; 2],
    /// Heights in metres, row by row from the south.
    pub heights_m: Vec<f32>,
}

impl Raster {
    /// Reads the heights between two corners (south-west and north-east), from the finest level that has at most
    /// [`MOST_CELLS`] samples along each side of the area.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub(super) fn read(terrain: &Terrain, [low_m, high_m]: [DVec2; 2]) -> Result<Self, PyramidError> {
        let store = terrain.store();
        let levels = store.levels();
        let projection = terrain.grid_projection();
        let finest = DVec2::new(f64::from(levels[0].width), f64::from(levels[0].height));
        let steps = (0..SIDE_PLACES).map(|step| f64::from(step) / f64::from(SIDE_PLACES - 1));
        let places = steps.clone().flat_map(|v| steps.clone().map(move |u| DVec2::new(u, v)));
        let (mut low, mut high) = (finest, DVec2::ZERO);
        for at in places {
            let grid = projection.grid_from_world(low_m + (high_m - low_m) * at);
            if grid.is_finite() {
                let grid = grid.clamp(DVec2::ZERO, finest - 1.0);
                (low, high) = (low.min(grid), high.max(grid));
            }
        }
        let span = (high - low).max(DVec2::ONE);
        let samples = |level: usize| {
            let size = DVec2::new(f64::from(levels[level].width), f64::from(levels[level].height));
            (span * size / finest).max_element()
        };
        let level = (0..levels.len()).find(|level| samples(*level) <= f64::from(MOST_CELLS));
        let level = level.unwrap_or(levels.len() - 1);
        let size_m = (high_m - low_m).max(DVec2::splat(1e-9));
        let most = samples(level).clamp(4.0, f64::from(MOST_CELLS));
        let cell_m = size_m.max_element() / most;
        let size = (size_m / cell_m).ceil().max(DVec2::ONE).min(DVec2::splat(f64::from(MOST_CELLS))).as_uvec2();
        let mut raster = Self {
            first_m: low_m + 0.5 * cell_m,
            cell_m,
            size: [size.x as usize, size.y as usize],
            heights_m: Vec::with_capacity((size.x * size.y) as usize),
        };
        let mut tiles: FxHashMap<TileAddress, Arc<LoadedTile>> = FxHashMap::default();
        for row in 0..size.y {
            for column in 0..size.x {
                let grid = projection.grid_from_world(raster.place_m(UVec2::new(column, row)));
                // Where a level has no tile, as in a mosaic of several resolutions, a coarser one has.
                let address = (level as u32..levels.len() as u32)
                    .map_while(|level| tile_at(levels, level, grid.x, grid.y))
                    .find(|address| store.has_tile(*address));
                let height_m = match address {
                    Some(address) => {
                        let tile = match tiles.get(&address) {
                            Some(tile) => tile,
                            None => {
                                let loaded = Arc::new(Arc::clone(store).load(address)?);
                                tiles.entry(address).or_insert(loaded)
                            }
                        };
                        height_in_tile(levels, address, &tile.tile, grid.x, grid.y)
                    }
                    None => None,
                };
                raster.heights_m.push(height_m.map_or(f32::NAN, |height_m| height_m as f32));
            }
        }
        Ok(raster)
    }

    /// Creates a raster of a function of east and north.
    #[cfg(test)]
    pub(super) fn of(side: usize, cell_m: f64, height_m: impl Fn(f64, f64) -> f64) -> Self {
        let first_m = DVec2::splat(-0.5 * cell_m * (side as f64 - 1.0));
        let mut raster = Self { first_m, cell_m, size: [side; 2], heights_m: Vec::new() };
        for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
            let at = raster.place_m(UVec2::new(column as u32, row as u32));
            raster.heights_m.push(height_m(at.x, at.y) as f32);
        }
        raster
    }

    /// Returns the centre of a cell: east and north in metres.
    pub(super) fn place_m(&self, cell: UVec2) -> DVec2 {
        self.first_m + self.cell_m * cell.as_dvec2()
    }

    /// Returns the column and row of the index of a cell.
    pub(super) fn cell(&self, index: usize) -> UVec2 {
        UVec2::new((index % self.size[0]) as u32, (index / self.size[0]) as u32)
    }

    /// Returns the index of the cell at a place; `None` outside.
    pub(super) fn index(&self, place_m: DVec2) -> Option<usize> {
        let cell = ((place_m - self.first_m) / self.cell_m + 0.5).floor();
        let is_inside = cell.cmpge(DVec2::ZERO).all() && cell.x < self.size[0] as f64 && cell.y < self.size[1] as f64;
        is_inside.then(|| cell.y as usize * self.size[0] + cell.x as usize)
    }

    /// Returns the height of the cell at a place; NaN outside, and without data.
    pub(super) fn height_m(&self, place_m: DVec2) -> f64 {
        self.index(place_m).map_or(f64::NAN, |at| f64::from(self.heights_m[at]))
    }

    /// Returns whether a place is in the rectangle of the lattice.
    pub(super) fn contains(&self, place_m: DVec2) -> bool {
        let [low_m, high_m] = self.corners_m();
        place_m.cmpge(low_m).all() && place_m.cmplt(high_m).all()
    }

    /// Returns the south-western and the north-eastern corner of the lattice.
    pub(super) fn corners_m(&self) -> [DVec2; 2] {
        let low_m = self.first_m - 0.5 * self.cell_m;
        [low_m, low_m + self.cell_m * DVec2::new(self.size[0] as f64, self.size[1] as f64)]
    }

    /// Returns the smallest rectangle around all cells with data, and the mean of their centres; `None` without data.
    pub(super) fn data(&self) -> Option<([DVec2; 2], DVec2)> {
        let (mut low, mut high, mut sum, mut count) = (UVec2::MAX, UVec2::ZERO, DVec2::ZERO, 0.0);
        for (index, _) in self.heights_m.iter().enumerate().filter(|(_, height_m)| !height_m.is_nan()) {
            let cell = self.cell(index);
            (low, high, sum, count) = (low.min(cell), high.max(cell), sum + cell.as_dvec2(), count + 1.0);
        }
        let half_m = 0.5 * self.cell_m;
        let corners_m = [self.place_m(low.min(high)) - half_m, self.place_m(high) + half_m];
        (count > 0.0).then(|| (corners_m, self.first_m + self.cell_m * sum / count))
    }
}
