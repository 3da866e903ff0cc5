//! The terrain of a world on the GPU: the data that `shaders/shared/terrain.wgsl` reads, updated for each view.

mod prepare;

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

pub use self::prepare::Prepared;
pub(crate) use self::prepare::TerrainView;
use super::camera_motion::CameraMotion;
use super::earth_curvature::EarthCurvature;
use super::grid_projection::GridProjection;
use super::horizon_maps::HorizonMaps;
use super::patch_tree::PatchTree;
use super::residency::Residency;
use super::slot_maps::MapInView;
use super::terrain_buffers::TerrainBuffers;
use super::water_maps::{NO_SEA_M, WaterMaps, water_maps};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::target::{Group, TextureName};
use crate::pyramid::store::Ground;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::{PyramidError, TileAddress, TileStore};
use crate::source::{GeoreferenceError, WorldMapping};
use crate::tiles::atlas::SLOT_BYTES;

/// The horizon maps of the tiles.
pub(crate) const HORIZON_MAPS: TextureName = TextureName {
    name: "horizon maps",
    content: Group::Tones.shows("Elevation of the horizon toward the sun, and visible sky, on each tile of heights"),
};
/// The water maps of the tiles.
pub(crate) const WATER_MAPS: TextureName = TextureName {
    name: "water maps",
    content: Group::Surface.shows("Distance to the shore on each tile of heights, packed into numbers"),
};

/// Whether a frame waits for its tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loading {
    /// Frames wait: for files, where only the picture counts.
    #[default]
    Wait,
    /// Frames never wait: coarser tiles are drawn instead, and detail fades in as it arrives.
    Stream,
}

/// The accuracy and memory of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerrainOptions {
    /// The height error that may be visible, in pixels.
    pub lod_error_px: f64,
    /// Memory in bytes for tiles on the GPU, and as much again for tiles in main memory.
    pub tile_memory_bytes: u64,
    /// Whether frames wait for tiles.
    pub loading: Loading,
    /// One over the effective radius of the earth for light, per metre; 0 is a flat map.
    pub inverse_radius: f64,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self { lod_error_px: 1.0, tile_memory_bytes: 512 << 20, loading: Loading::Wait, inverse_radius: 0.0 }
    }
}

/// Number of frames after which maps are dropped if they are not requested.
pub(crate) const KEEP_MAPS_FRAMES: u64 = 3600;

/// The largest number of samples along a side, up to which f32 counts exactly.
const MAX_SAMPLES: u32 = 1 << 24;

/// The reason why a pyramid cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum TerrainError {
    /// The pyramid's georeference is invalid.
    #[error(transparent)]
    Georeference(#[from] GeoreferenceError),
    /// The grid has more samples than positions on the GPU can count.
    #[error("{width}×{height} samples are too many for one grid: hachure draws at most {MAX_SAMPLES} along a side")]
    TooWide {
        /// Number of samples per row.
        width: u32,
        /// Number of rows of samples.
        height: u32,
    },
}

/// Statistics of the tiles of a terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileCounts {
    /// Number of tiles on the GPU.
    pub on_gpu: u64,
    /// Number of tiles evicted from the GPU, since the start.
    pub evicted: u64,
    /// Number of tiles cancelled before they were loaded, since the start.
    pub cancelled: u64,
    /// Memory of the tiles on the GPU, in bytes.
    pub gpu_bytes: u64,
    /// Memory of the decoded tiles, in bytes.
    pub cache_bytes: u64,
    /// Number of tiles evicted while the view needed them, since the start. It must be 0.
    pub evicted_needed: u64,
    /// Number of tiles that a view began to need and that were on the GPU already, since the start.
    pub gpu_hits: u64,
    /// Number of tiles that a view began to need and that were not on the GPU, since the start.
    pub gpu_misses: u64,
    /// Number of tiles uploaded to the GPU, since the start.
    pub uploaded: u64,
    /// Number of tiles read and decoded, since the start; those uploaded without being read were in memory.
    pub read: u64,
}

/// The clock by which cameras move, tiles fade in and failures are retried.
enum Clock {
    /// The time since this instant.
    System(Instant),
    /// A simulated time, in seconds.
    #[cfg(test)]
    Simulated(f64),
}

impl Clock {
    fn now_s(&self) -> f64 {
        match self {
            Self::System(start) => start.elapsed().as_secs_f64(),
            #[cfg(test)]
            Self::Simulated(now_s) => *now_s,
        }
    }
}

/// The ground heights of a terrain, read on demand.
pub(crate) struct GroundHeights {
    ground: Ground,
    grid_projection: GridProjection,
    lowest_m: f64,
}

impl GroundHeights {
    /// Returns the smallest and the largest east and north, in metres.
    pub(crate) fn corners_m(&self) -> [DVec2; 2] {
        self.grid_projection.extent_m()
    }

    /// Returns the ground height in metres at a place; in holes and outside, the lowest height. The call may read a file.
    pub(crate) fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let grid = self.grid_projection.grid_from_world(DVec2::new(east_m, north_m));
        self.ground.height_m(grid.x, grid.y).unwrap_or(self.lowest_m)
    }

    /// Returns the reason why a tile could not be read, if one could not.
    pub(crate) fn failure(&self) -> Option<Arc<PyramidError>> {
        self.ground.failure()
    }
}

/// The terrain of a world: its tiles on the GPU, and the data by which the shaders find them, from frame to frame.
pub struct Terrain {
    store: Arc<dyn TileStore>,
    ground: Ground,
    mapping: WorldMapping,
    grid_projection: GridProjection,
    options: TerrainOptions,
    /// Angle of the horizon below level in the last view, in radians; 0 for the earth's own curvature.
    horizon_rad: f64,
    residency: Residency,
    /// The tiles that the mesh of the last frame missed, with their urgency.
    requested: FxHashMap<TileAddress, f64>,
    /// The quadtree of patches.
    tree: PatchTree,
    /// The factor of the allowed error in the last frame.
    coarser: f64,
    /// The smallest allowed error, in pixels, so that all parts of a picture have the same.
    min_error_px: f64,
    motion: CameraMotion,
    clock: Clock,
    frame: u64,
    buffers: TerrainBuffers,
    /// The horizon maps, in a style with shadows or occlusion.
    horizon_maps: Option<HorizonMaps>,
    /// Whether the next frame requests horizon maps, and the last frame that did.
    needs_horizons: bool,
    horizons_requested_in: u64,
    /// The water maps, in a style with water.
    water_maps: Option<WaterMaps>,
    needs_water: bool,
    water_requested_in: u64,
}

/// Departure of the world's scale from 1 above which a warning is printed.
const WARNED_DEPARTURE: f64 = 0.02;

impl Terrain {
    /// Creates a terrain for a world. Its tiles are loaded when views are drawn.
    ///
    /// # Errors
    /// [`TerrainError`] if the pyramid cannot be drawn.
    pub fn new(gpu: &Gpu, store: Arc<dyn TileStore>, options: TerrainOptions) -> Result<Self, TerrainError> {
        let size = store.levels()[0];
        if size.width.max(size.height) > MAX_SAMPLES {
            return Err(TerrainError::TooWide { width: size.width, height: size.height });
        }
        let mapping = WorldMapping::new(store.georeference(), size.width, size.height)?;
        if let Some(scale) = mapping.ground_scale().map(|scale| scale.world)
            && scale.departure() > WARNED_DEPARTURE
        {
            let factor = scale.max.max(1.0 / scale.min);
            let how_far = match factor {
                factor if factor < 1.2 => format!("{:.0} %", 100.0 * (factor - 1.0)),
                factor => format!("a factor of {factor:.1}"),
            };
            tracing::warn!(
                "{}: the extent is too wide for one plane: lengths and slopes are off by up to {how_far} toward its edges",
                store.name()
            );
        }
        let grid_projection = GridProjection::fit(&mapping, size.width, size.height);
        Ok(Self {
            ground: Ground::new(Arc::clone(&store)),
            residency: Residency::new(gpu, Arc::clone(&store), options.tile_memory_bytes),
            store,
            mapping,
            grid_projection,
            options,
            horizon_rad: 0.0,
            requested: FxHashMap::default(),
            tree: PatchTree::default(),
            coarser: 1.0,
            min_error_px: 0.0,
            motion: CameraMotion::default(),
            clock: Clock::System(Instant::now()),
            frame: 0,
            buffers: TerrainBuffers::new(gpu),
            horizon_maps: None,
            needs_horizons: false,
            horizons_requested_in: 0,
            water_maps: None,
            needs_water: false,
            water_requested_in: 0,
        })
    }

    /// Returns the exact mapping between grid, world and CRS.
    pub fn mapping(&self) -> &WorldMapping {
        &self.mapping
    }

    /// Returns the extent to the east and to the north, in metres.
    pub fn extent_m(&self) -> [f64; 2] {
        let [low_m, high_m] = self.corners_m();
        (high_m - low_m).to_array()
    }

    /// Returns the smallest and the largest east and north, in metres.
    pub fn corners_m(&self) -> [DVec2; 2] {
        self.grid_projection.extent_m()
    }

    /// Returns the source of its tiles.
    pub fn store(&self) -> &Arc<dyn TileStore> {
        &self.store
    }

    /// Returns the lowest and the highest height in metres.
    pub fn range_m(&self) -> [f32; 2] {
        self.store.range_m()
    }

    /// Returns the mapping between grid and world as the GPU approximates it, by polynomials.
    pub(crate) fn grid_projection(&self) -> &GridProjection {
        &self.grid_projection
    }

    /// Returns the current options.
    pub fn options(&self) -> &TerrainOptions {
        &self.options
    }

    /// Changes the allowed error, in pixels, from the next frame on.
    pub fn set_lod_error_px(&mut self, lod_error_px: f64) {
        self.options.lod_error_px = lod_error_px;
    }

    /// Sets the time of the next frames in seconds, in place of the system's clock, for simulated flights.
    #[cfg(test)]
    pub(crate) fn set_now_s(&mut self, now_s: f64) {
        self.clock = Clock::Simulated(now_s);
    }

    /// Returns whether another thread is looking for tiles that will be needed soon.
    #[cfg(test)]
    pub(crate) fn looks_ahead(&self) -> bool {
        self.residency.looks_ahead()
    }

    /// Returns the number of tiles that are waiting to be read, and of those that are being read or decoded.
    #[cfg(test)]
    pub(crate) fn tiles_queued_and_under_way(&self) -> [usize; 2] {
        self.residency.queued_and_under_way()
    }

    /// Returns the height of the finest surface in metres at a place in the world, or `None` outside and in holes. The
    /// call may read a file, so it is not for frames that must not wait.
    pub fn height_m(&self, world_m: DVec2) -> Option<f64> {
        let grid = self.grid_projection.grid_from_world(world_m);
        self.ground.height_m(grid.x, grid.y)
    }

    /// Returns the reason why a tile of a picture or of the ground could not be read, or `None` if all could.
    pub fn failure(&self) -> Option<Arc<PyramidError>> {
        self.residency.failure().cloned().or_else(|| self.ground.failure())
    }

    /// Returns the ground heights by places in the world, for another thread. They share no tiles with the terrain.
    pub(crate) fn ground_heights(&self) -> GroundHeights {
        let ground = Ground::new(Arc::clone(&self.store));
        GroundHeights { ground, grid_projection: self.grid_projection.clone(), lowest_m: self.range_m()[0].into() }
    }

    /// Returns the ground heights by grid coordinates of level 0.
    pub(crate) fn ground(&self) -> &Ground {
        &self.ground
    }

    /// Returns the height like [`Terrain::height_m`], but from the finest tile in memory, or `None` if there is none.
    pub(crate) fn height_at_hand_m(&self, world_m: DVec2) -> Option<f64> {
        let grid = self.grid_projection.grid_from_world(world_m);
        let levels = self.store.levels();
        (0..levels.len() as u32).find_map(|level| {
            let address = tile_at(levels, level, grid.x, grid.y)?;
            let tile = self.residency.in_memory(address)?;
            height_in_tile(levels, address, &tile.tile, grid.x, grid.y)
        })
    }

    /// Returns statistics of the tiles.
    pub fn tile_counts(&self) -> TileCounts {
        let (atlas, hits) = (&self.residency.atlas, self.residency.hits());
        TileCounts {
            on_gpu: atlas.len() as u64,
            evicted: atlas.evicted(),
            cancelled: self.residency.cancelled(),
            gpu_bytes: atlas.len() as u64 * SLOT_BYTES,
            cache_bytes: self.residency.cache_bytes(),
            evicted_needed: atlas.evicted_needed(),
            gpu_hits: hits.on_gpu,
            gpu_misses: hits.not_on_gpu,
            uploaded: hits.uploaded,
            read: hits.read,
        }
    }

    /// Returns the water maps that the last view's frame can read, or `None` while none are requested.
    pub(crate) fn water_maps_in_view(&self) -> Option<Vec<MapInView>> {
        Some(self.water_maps.as_ref()?.in_view(&self.residency))
    }

    /// Returns how many tiles on the GPU the last view needs, and how many more its maps depend on.
    pub(crate) fn tiles_in_use(&self) -> [u64; 2] {
        let Residency { atlas, needed, map_neighbours, .. } = &self.residency;
        let is_there = |tile: &TileAddress| atlas.get(*tile).is_some();
        let needed: FxHashSet<TileAddress> = needed.iter().map(|tile| tile.address).filter(is_there).collect();
        let around = map_neighbours.iter().filter(|tile| is_there(tile) && !needed.contains(*tile));
        [needed.len() as u64, around.collect::<FxHashSet<_>>().len() as u64]
    }

    /// Returns the memory of the terrain on the GPU, in bytes.
    pub fn gpu_bytes(&self) -> u64 {
        let horizon_maps = self.horizon_maps.as_ref().map_or(0, |horizons| horizons.maps.bytes());
        let water_maps = self.water_maps.as_ref().map_or(0, WaterMaps::bytes);
        self.residency.atlas.bytes() + self.buffers.bytes() + horizon_maps + water_maps
    }

    /// Returns the memory of the maps that the last frame requested, in bytes: a layer for each tile that there may be.
    pub(crate) fn map_bytes(&self) -> u64 {
        let horizons = self.horizon_maps.as_ref().filter(|_| self.needs_horizons);
        let water = self.water_maps.as_ref().filter(|_| self.needs_water);
        horizons.map_or(0, |horizons| horizons.maps.bytes()) + water.map_or(0, WaterMaps::bytes)
    }

    /// Requests horizon maps toward a sun in the direction `to_sun` for the next frame. With `None` they are not
    /// requested; existing ones are kept for a while, because they take long to compute.
    pub(crate) fn map_horizons(&mut self, gpu: &Gpu, to_sun: Option<DVec3>) {
        self.needs_horizons = to_sun.is_some();
        match to_sun {
            Some(to_sun) => {
                let maps = self.horizon_maps.get_or_insert_with(|| HorizonMaps::new(gpu, &self.residency.atlas));
                maps.set_sun(to_sun.truncate());
                self.horizons_requested_in = self.frame;
            }
            None if self.frame > self.horizons_requested_in + KEEP_MAPS_FRAMES => self.horizon_maps = None,
            None => {}
        }
    }

    /// Requests water maps for the next frame, with the sea level in metres if there is a sea: `Some(None)` is water
    /// without a sea. With `None` they are not requested; existing ones are kept for a while.
    pub(crate) fn map_water(&mut self, gpu: &Gpu, sea_level_m: Option<Option<f64>>) {
        self.needs_water = sea_level_m.is_some();
        match sea_level_m {
            Some(sea_level_m) => {
                let sea_m = sea_level_m.map_or(NO_SEA_M, |level_m| level_m as f32);
                let atlas = &self.residency.atlas;
                self.water_maps.get_or_insert_with(|| water_maps(gpu, atlas, sea_m)).set_key(sea_m);
                self.water_requested_in = self.frame;
            }
            None if self.frame > self.water_requested_in + KEEP_MAPS_FRAMES => self.water_maps = None,
            None => {}
        }
    }

    /// Marks the planned maps as not computed, because the frame for which the terrain was prepared was not drawn.
    pub(crate) fn forget_planned_maps(&mut self) {
        if let Some(horizons) = &mut self.horizon_maps {
            horizons.maps.forget_planned();
        }
        if let Some(maps) = &mut self.water_maps {
            maps.forget_planned();
        }
    }

    /// Returns the horizon maps, or `None` while they are not requested.
    pub(crate) fn horizon_maps(&self) -> Option<&HorizonMaps> {
        self.horizon_maps.as_ref()
    }

    /// Returns the water maps, or `None` while they are not requested.
    pub(crate) fn water_maps(&self) -> Option<&WaterMaps> {
        self.water_maps.as_ref()
    }

    /// Returns the earth as a camera at a height sees it in the last view.
    pub(crate) fn earth_curvature(&self, camera_z_m: f64) -> EarthCurvature {
        let lowest_m = f64::from(self.store.range_m()[0]);
        let earth = EarthCurvature { inverse_radius: self.options.inverse_radius, camera_z_m, lowest_m };
        earth.with_horizon(self.horizon_rad)
    }

    /// Returns a lower bound of the distance of the surface from a camera, in metres: half the camera's height above
    /// the ground of the last view.
    pub(crate) fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let ground = self.residency.ground(self.grid_projection.grid_from_world(camera_m.truncate()));
        let clearance_m = ground.map_or(0.0, |ground| (camera_m.z - ground.height_m).abs());
        (0.5 * clearance_m).max(0.02)
    }

    /// Returns the uniform alone, for passes that import `hachure::earth` and do not evaluate the surface.
    pub(crate) fn uniform(&self) -> Named {
        self.buffers.uniform()
    }

    /// Returns the resources that `shaders/shared/terrain.wgsl` and `shared/surface.wgsl` declare.
    pub(crate) fn resources(&self) -> [Named; 5] {
        self.buffers.resources(&self.residency.atlas)
    }

    /// Returns the resources that `shaders/shared/horizon_maps.wgsl` needs besides the uniform, or `None` if no horizon
    /// maps have been requested.
    pub(crate) fn horizon_map_resources(&self) -> Option<[Named; 5]> {
        let maps = self.horizon_maps.as_ref()?;
        let [_, levels, rows, tiles, _] = self.resources();
        Some([
            levels,
            rows,
            tiles,
            ("horizon_maps", Resource::Texture(HORIZON_MAPS, maps.maps.view().clone())),
            ("horizon_sampler", Resource::Sampler(maps.sampler().clone())),
        ])
    }

    /// Returns the resources that `shaders/shared/water_maps.wgsl` needs, or `None` if no water maps have been
    /// requested.
    pub(crate) fn water_map_resources(&self) -> Option<[Named; 5]> {
        let maps = self.water_maps.as_ref()?;
        let [terrain, levels, rows, tiles, _] = self.resources();
        Some([terrain, levels, rows, tiles, ("water_maps", Resource::Texture(WATER_MAPS, maps.view().clone()))])
    }
}
