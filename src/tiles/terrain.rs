//! The terrain of a world on the GPU: what `shaders/shared/terrain.wgsl` reads, kept up to date with the view.

mod prepare;

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

pub use self::prepare::{Detail, Prepared, TerrainView};
use super::camera_motion::CameraMotion;
use super::earth_curvature::EarthCurvature;
use super::grid_projection::GridProjection;
use super::horizon_maps::HorizonMaps;
use super::residency::Residency;
use super::terrain_buffers::TerrainBuffers;
use super::water_maps::{NO_SEA_M, WaterMaps, water_maps};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::pyramid::store::Ground;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::{PyramidError, TileAddress, TileStore};
use crate::source::{GeoreferenceError, WorldMapping};
use crate::tiles::atlas::SLOT_BYTES;

/// Whether a frame waits for its tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loading {
    /// It does: for files, where only the picture counts.
    #[default]
    Wait,
    /// It never does: coarser tiles stand in, and detail fades in as it comes.
    Stream,
}

/// Accuracy and memory: the knobs of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerrainOptions {
    /// The height error that may be seen, in pixels.
    pub lod_error_px: f64,
    /// For tiles on the GPU, and as much for tiles in memory.
    pub tile_memory_bytes: u64,
    /// Whether frames wait for tiles.
    pub loading: Loading,
    /// One over the radius of the earth that light sees, per metre; 0 is a flat map.
    pub inverse_radius: f64,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self { lod_error_px: 1.0, tile_memory_bytes: 512 << 20, loading: Loading::Wait, inverse_radius: 0.0 }
    }
}

/// Maps are kept for so many frames in which nobody asks for them.
const KEEP_MAPS_FRAMES: u64 = 3600;

/// Samples along a side: what f32 still counts one by one.
const MOST_SAMPLES: u32 = 1 << 24;

/// Why a pyramid cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum TerrainError {
    /// The pyramid's georeference leads nowhere.
    #[error(transparent)]
    Georeference(#[from] GeoreferenceError),
    /// More samples than positions on the GPU can count.
    #[error("{width}×{height} samples are more than hachure draws as one grid: at most {MOST_SAMPLES} along a side")]
    TooWide {
        /// Samples per row.
        width: u32,
        /// Rows of samples.
        height: u32,
    },
}

/// The tiles of a terrain in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileCounts {
    /// Tiles that are on the GPU now.
    pub on_gpu: u64,
    /// Tiles that made room for others, since the start.
    pub evicted: u64,
    /// Tiles that were given up before they were there, since the start.
    pub cancelled: u64,
    /// Bytes that the tiles on the GPU take.
    pub gpu_bytes: u64,
    /// Bytes that decoded tiles take in memory.
    pub cache_bytes: u64,
}

/// The terrain of a world: its tiles on the GPU and what the shaders read to find them, from frame to frame.
pub struct Terrain {
    store: Arc<dyn TileStore>,
    ground: Ground,
    mapping: WorldMapping,
    grid_projection: GridProjection,
    options: TerrainOptions,
    /// Of the last view: how far below level the horizon lies, 0 as the earth has it.
    horizon_rad: f64,
    residency: Residency,
    /// What the mesh of the last frame missed.
    asked: FxHashMap<TileAddress, f64>,
    /// What the allowed error of the last frame was multiplied by.
    coarser: f64,
    /// Parts of one picture have one allowed error, in pixels: at least this.
    least_error_px: f64,
    motion: CameraMotion,
    start: Instant,
    frame: u64,
    buffers: TerrainBuffers,
    /// Of a style with shadows or occlusion.
    horizon_maps: Option<HorizonMaps>,
    /// Whether the next frame asks for them, and the last frame that did.
    asks_for_horizons: bool,
    horizons_asked_in: u64,
    /// The same of a style with water.
    water_maps: Option<WaterMaps>,
    asks_for_water: bool,
    water_asked_in: u64,
}

impl Terrain {
    /// Makes room for a world's tiles; they follow with the views.
    ///
    /// # Errors
    /// [`TerrainError`].
    pub fn new(gpu: &Gpu, store: Arc<dyn TileStore>, options: TerrainOptions) -> Result<Self, TerrainError> {
        let size = store.levels()[0];
        if size.width.max(size.height) > MOST_SAMPLES {
            return Err(TerrainError::TooWide { width: size.width, height: size.height });
        }
        let mapping = WorldMapping::new(store.georeference(), size.width, size.height)?;
        let grid_projection = GridProjection::fit(&mapping, size.width, size.height);
        Ok(Self {
            ground: Ground::new(Arc::clone(&store)),
            residency: Residency::new(gpu, Arc::clone(&store), options.tile_memory_bytes),
            store,
            mapping,
            grid_projection,
            options,
            horizon_rad: 0.0,
            asked: FxHashMap::default(),
            coarser: 1.0,
            least_error_px: 0.0,
            motion: CameraMotion::default(),
            start: Instant::now(),
            frame: 0,
            buffers: TerrainBuffers::new(gpu),
            horizon_maps: None,
            asks_for_horizons: false,
            horizons_asked_in: 0,
            water_maps: None,
            asks_for_water: false,
            water_asked_in: 0,
        })
    }

    /// Grid ↔ world ↔ CRS, exactly.
    pub fn mapping(&self) -> &WorldMapping {
        &self.mapping
    }

    /// East and north extent in metres.
    pub fn extent_m(&self) -> [f64; 2] {
        let [low_m, high_m] = self.corners_m();
        (high_m - low_m).to_array()
    }

    /// The least and the greatest east and north of its corners.
    pub fn corners_m(&self) -> [DVec2; 2] {
        let size = self.store.levels()[0];
        let (right, bottom) = (f64::from(size.width - 1), f64::from(size.height - 1));
        let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
        let places = corners.map(|(x, y)| self.grid_projection.world_from_grid(DVec2::new(x, y)));
        let low = places.into_iter().reduce(DVec2::min).unwrap_or_default();
        let high = places.into_iter().reduce(DVec2::max).unwrap_or_default();
        [low, high]
    }

    /// Where its tiles come from.
    pub fn store(&self) -> &Arc<dyn TileStore> {
        &self.store
    }

    /// Lowest and highest height in metres.
    pub fn range_m(&self) -> [f32; 2] {
        self.store.range_m()
    }

    /// Grid ↔ world as the GPU follows it, by polynomials.
    pub fn grid_projection(&self) -> &GridProjection {
        &self.grid_projection
    }

    /// Accuracy and memory, as they were given or last changed.
    pub fn options(&self) -> &TerrainOptions {
        &self.options
    }

    /// Changes the allowed error from the next frame on.
    pub fn set_lod_error_px(&mut self, lod_error_px: f64) {
        self.options.lod_error_px = lod_error_px;
    }

    /// Height of the finest surface in metres at a place in the world; none outside and in holes. It may read a file:
    /// not for frames that must not wait.
    pub fn height_m(&self, world_m: DVec2) -> Option<f64> {
        let grid = self.grid_projection.grid_from_world(world_m);
        self.ground.height_m(grid.x, grid.y)
    }

    /// Why a tile could not be read, of the ground or of a picture; none if all could.
    pub fn failure(&self) -> Option<Arc<PyramidError>> {
        self.residency.failure().cloned().or_else(|| self.ground.failure())
    }

    /// Heights by grid coordinates of level 0.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// The same from the finest tile in memory. None also while there is none.
    pub fn height_at_hand_m(&self, world_m: DVec2) -> Option<f64> {
        let grid = self.grid_projection.grid_from_world(world_m);
        let levels = self.store.levels();
        (0..levels.len() as u32).find_map(|level| {
            let address = tile_at(levels, level, grid.x, grid.y)?;
            let tile = self.residency.in_memory(address)?;
            height_in_tile(levels, address, &tile.tile, grid.x, grid.y)
        })
    }

    /// The tiles in numbers.
    pub fn tile_counts(&self) -> TileCounts {
        let atlas = &self.residency.atlas;
        TileCounts {
            on_gpu: atlas.len() as u64,
            evicted: atlas.evicted(),
            cancelled: self.residency.cancelled(),
            gpu_bytes: atlas.len() as u64 * SLOT_BYTES,
            cache_bytes: self.residency.cache_bytes(),
        }
    }

    /// Bytes that the terrain holds on the GPU.
    pub fn gpu_bytes(&self) -> u64 {
        let horizon_maps = self.horizon_maps.as_ref().map_or(0, |horizons| horizons.maps.bytes());
        let water_maps = self.water_maps.as_ref().map_or(0, WaterMaps::bytes);
        self.residency.atlas.bytes() + self.buffers.bytes() + horizon_maps + water_maps
    }

    /// In the next frame horizon maps toward a sun in that direction are there. None asks for nothing: what is known
    /// stays for a while, for it takes long to find.
    pub fn map_horizons(&mut self, gpu: &Gpu, to_sun: Option<DVec3>) {
        self.asks_for_horizons = to_sun.is_some();
        match to_sun {
            Some(to_sun) => {
                let maps = self.horizon_maps.get_or_insert_with(|| HorizonMaps::new(gpu, &self.residency.atlas));
                maps.set_sun(to_sun.truncate());
                self.horizons_asked_in = self.frame;
            }
            None if self.frame > self.horizons_asked_in + KEEP_MAPS_FRAMES => self.horizon_maps = None,
            None => {}
        }
    }

    /// In the next frame water maps are there, with a sea of that height if there is one: `Some(None)` is water without
    /// a sea. None asks for nothing: what is known stays for a while.
    pub fn map_water(&mut self, gpu: &Gpu, sea_level_m: Option<Option<f64>>) {
        self.asks_for_water = sea_level_m.is_some();
        match sea_level_m {
            Some(sea_level_m) => {
                let sea_m = sea_level_m.map_or(NO_SEA_M, |level_m| level_m as f32);
                let atlas = &self.residency.atlas;
                self.water_maps.get_or_insert_with(|| water_maps(gpu, atlas, sea_m)).set_key(sea_m);
                self.water_asked_in = self.frame;
            }
            None if self.frame > self.water_asked_in + KEEP_MAPS_FRAMES => self.water_maps = None,
            None => {}
        }
    }

    /// The frame for which the terrain was prepared was not drawn: its maps are still to be made.
    pub fn forget_planned_maps(&mut self) {
        if let Some(horizons) = &mut self.horizon_maps {
            horizons.maps.forget_planned();
        }
        if let Some(maps) = &mut self.water_maps {
            maps.forget_planned();
        }
    }

    /// The horizon maps; none while nobody asks for them.
    pub fn horizon_maps(&self) -> Option<&HorizonMaps> {
        self.horizon_maps.as_ref()
    }

    /// The water maps; none while nobody asks for them.
    pub fn water_maps(&self) -> Option<&WaterMaps> {
        self.water_maps.as_ref()
    }

    /// The earth as a camera at a height sees it in the last view.
    pub fn earth_curvature(&self, camera_z_m: f64) -> EarthCurvature {
        let lowest_m = f64::from(self.store.range_m()[0]);
        let earth = EarthCurvature { inverse_radius: self.options.inverse_radius, camera_z_m, lowest_m };
        earth.with_horizon(self.horizon_rad)
    }

    /// No part of the surface is nearer to a camera than this: half its height above the ground of the last view.
    pub fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let ground_m = self.residency.height_m(self.grid_projection.grid_from_world(camera_m.truncate()));
        let clearance_m = ground_m.map_or(0.0, |ground_m| (camera_m.z - ground_m).abs());
        (0.5 * clearance_m).max(0.02)
    }

    /// For passes that ask no surface: what `hachure::earth` needs.
    pub fn uniform(&self) -> Named {
        self.buffers.uniform()
    }

    /// What `shaders/shared/terrain.wgsl` and `shared/surface.wgsl` declare.
    pub fn resources(&self) -> [Named; 5] {
        self.buffers.resources(&self.residency.atlas)
    }

    /// What `shaders/shared/horizon_maps.wgsl` needs beside the uniform; none if nobody has asked for horizon maps.
    pub fn horizon_map_resources(&self) -> Option<[Named; 5]> {
        let maps = self.horizon_maps.as_ref()?;
        let [_, levels, rows, tiles, _] = self.resources();
        Some([
            levels,
            rows,
            tiles,
            ("horizon_maps", Resource::Texture("horizon maps", maps.maps.view().clone())),
            ("horizon_sampler", Resource::Sampler(maps.sampler().clone())),
        ])
    }

    /// What `shaders/shared/water_maps.wgsl` needs; none if nobody has asked for water maps.
    pub fn water_map_resources(&self) -> Option<[Named; 5]> {
        let maps = self.water_maps.as_ref()?;
        let [terrain, levels, rows, tiles, _] = self.resources();
        Some([terrain, levels, rows, tiles, ("water_maps", Resource::Texture("water maps", maps.view().clone()))])
    }
}
