//! The terrain of a world on the GPU: what `shaders/shared/terrain.wgsl` reads, kept up to date with the view.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use super::bending::Bending;
use super::frustum::Frustum;
use super::needed::LevelRule;
use super::patches::ResidentPatches;
use super::residency::{Loaded, Movement, Residency};
use super::selection::{self, Selection, Viewpoint, units_log2};
use super::tables::Tables;
use super::warp::{MAX_TERMS, Warp};
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::Named;
use crate::pyramid::ground::{Ground, height_in_tile, tile_at};
use crate::pyramid::{TileAddress, TileStore};
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

/// Of the allowed error, the part that the choice of the level may use: positions are on the level's surface exactly,
/// so the rest is for what happens between the samples where errors were measured.
const LEVEL_SHARE: f64 = 0.5;

/// Samples along a side: what f32 still counts one by one.
const MOST_SAMPLES: u32 = 1 << 24;

/// After a jump, detail does not fade in but stands as it comes, for so long in seconds.
const JUMP_S: f64 = 1.5;
/// A step so many times as long as the one before is a jump.
const JUMP: f64 = 20.0;
/// A pause so long in seconds ends a movement.
const PAUSE_S: f64 = 1.0;

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
        /// Rows.
        height: u32,
    },
}

/// The tiles of a terrain in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileCounts {
    /// On the GPU now.
    pub on_gpu: u64,
    /// Made room for others, since the start.
    pub evicted: u64,
    /// Given up before they were there, since the start.
    pub cancelled: u64,
    /// Bytes of those on the GPU.
    pub gpu_bytes: u64,
    /// Bytes of those in memory.
    pub cache_bytes: u64,
}

/// What was prepared for a frame.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// The patches to draw.
    pub selection: Selection,
    /// What the tiles did.
    pub tiles: Loaded,
    /// What the frame thread spent on tiles and patches, in milliseconds.
    pub prepare_ms: f64,
    /// Whether the camera has jumped: detail is on its way.
    pub jumped: bool,
}

/// The terrain.
pub struct Terrain {
    store: Arc<dyn TileStore>,
    ground: Ground,
    mapping: WorldMapping,
    warp: Warp,
    options: TerrainOptions,
    residency: Residency,
    /// What the mesh of the last frame missed.
    asked: FxHashMap<TileAddress, f64>,
    flight: Option<Flown>,
    start: Instant,
    frame: u64,
    tables: Tables,
    uniform: GrowingBuffer,
    levels: GrowingBuffer,
    rows: GrowingBuffer,
    tiles: GrowingBuffer,
}

/// The frame before, for what comes next.
#[derive(Clone, Copy)]
struct Flown {
    camera_m: DVec3,
    velocity_m: DVec3,
    at_s: f64,
    /// Of the last jump.
    jumped_s: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct TerrainUniform {
    terms: [[f32; 4]; MAX_TERMS],
    extent_units: [i32; 4],
    grid_unit: f32,
    world_unit: f32,
    degree: i32,
    level_count: i32,
    camera_z_coarse_m: f32,
    camera_z_fine_m: f32,
    min_z_m: f32,
    max_z_m: f32,
    spacing_m: f32,
    level_error_px: f32,
    level_bias: f32,
    focal_px: f32,
    world_origin_m: [f32; 2],
    units_per_sample: f32,
    inverse_radius: f32,
}

crate::gpu::shared::describe!(TerrainUniform as "Terrain" in "surface/resolve": terms, extent_units, grid_unit, world_unit, degree, level_count, camera_z_coarse_m, camera_z_fine_m, min_z_m, max_z_m, spacing_m, level_error_px, level_bias, focal_px, world_origin_m, units_per_sample, inverse_radius);

/// A view as the terrain sees it.
#[derive(Clone, Debug)]
pub struct TerrainView {
    /// In the world.
    pub camera_m: DVec3,
    /// What is in view; empty frusta see nothing.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian.
    pub focal_px: f64,
}

impl Terrain {
    /// Makes room for a world's tiles; they follow with the views.
    ///
    /// # Errors
    /// [`TerrainError`].
    pub fn new(gpu: &Gpu, store: Arc<dyn TileStore>, options: TerrainOptions) -> Result<Self, TerrainError> {
        use wgpu::BufferUsages as Usage;
        let size = store.levels()[0];
        if size.width.max(size.height) > MOST_SAMPLES {
            return Err(TerrainError::TooWide { width: size.width, height: size.height });
        }
        let mapping = WorldMapping::new(store.georeference(), size.width, size.height)?;
        let warp = Warp::fit(&mapping, size.width, size.height);
        Ok(Self {
            ground: Ground::new(Arc::clone(&store)),
            residency: Residency::new(gpu, Arc::clone(&store), options.tile_memory_bytes),
            store,
            mapping,
            warp,
            options,
            asked: FxHashMap::default(),
            flight: None,
            start: Instant::now(),
            frame: 0,
            tables: Tables::default(),
            uniform: GrowingBuffer::new(gpu, "terrain", Usage::UNIFORM),
            levels: GrowingBuffer::new(gpu, "levels", Usage::STORAGE),
            rows: GrowingBuffer::new(gpu, "tile rows", Usage::STORAGE),
            tiles: GrowingBuffer::new(gpu, "tiles", Usage::STORAGE),
        })
    }

    /// Grid ↔ world ↔ CRS, exactly.
    pub fn mapping(&self) -> &WorldMapping {
        &self.mapping
    }

    /// East and north extent in metres.
    pub fn extent_m(&self) -> [f64; 2] {
        let size = self.store.levels()[0];
        let (right, bottom) = (f64::from(size.width - 1), f64::from(size.height - 1));
        let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
        let places = corners.map(|(x, y)| self.warp.world_from_grid(DVec2::new(x, y)));
        let low = places.into_iter().reduce(DVec2::min).unwrap_or_default();
        let high = places.into_iter().reduce(DVec2::max).unwrap_or_default();
        (high - low).to_array()
    }

    /// Where its tiles come from.
    pub fn store(&self) -> &Arc<dyn TileStore> {
        &self.store
    }

    /// Lowest and highest height in metres.
    pub fn range_m(&self) -> [f32; 2] {
        self.store.range_m()
    }

    /// Grid ↔ world.
    pub fn warp(&self) -> &Warp {
        &self.warp
    }

    /// As it was made, or last changed.
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
        let grid = self.warp.grid_from_world(world_m);
        self.ground.height_m(grid.x, grid.y)
    }

    /// Heights by grid coordinates of level 0.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// The same from the finest tile in memory. None also while there is none.
    pub fn height_at_hand_m(&self, world_m: DVec2) -> Option<f64> {
        let grid = self.warp.grid_from_world(world_m);
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
        let buffers = [&self.uniform, &self.levels, &self.rows, &self.tiles];
        self.residency.atlas.bytes() + buffers.iter().map(|buffer| buffer.buffer().size()).sum::<u64>()
    }

    /// Sees to the tiles that a view needs, chooses its patches, and tells the shaders. Waits for the tiles only where
    /// the options say so.
    pub fn prepare(&mut self, gpu: &Gpu, view: &TerrainView) -> Prepared {
        self.frame += 1;
        let begun_s = self.start.elapsed().as_secs_f64();
        let mut now_s = begun_s;
        let rule = LevelRule {
            camera_m: view.camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: self.options.lod_error_px * LEVEL_SHARE,
            bending: self.bending(view.camera_m.z),
        };
        let streams = self.options.loading == Loading::Stream;
        let flown = self.fly_on(view.camera_m, now_s);
        let fades = streams && now_s - flown.jumped_s > JUMP_S;
        let step_s = self.flight.map_or(0.0, |before| now_s - before.at_s);
        self.flight = Some(flown);
        let mut tiles = Loaded::default();
        let mut idle = 0;
        loop {
            // While nothing fades, what has come stands at once.
            let fade_step_s = streams.then_some(if fades { step_s } else { f64::INFINITY });
            let asked = std::mem::take(&mut self.asked);
            let movement = Movement { rule: rule.clone(), velocity_m: flown.velocity_m, frame_s: step_s, asked };
            let update = self.residency.update(gpu, &self.warp, &movement, self.frame, now_s, fade_step_s);
            let loaded = tiles.loaded + update.loaded;
            tiles = Loaded { loaded, ..update };
            if !streams && tiles.pending > 0 {
                self.asked = movement.asked;
                now_s = self.start.elapsed().as_secs_f64();
                idle = if update.loaded > 0 || self.residency.is_busy(now_s) { 0 } else { idle + 1 };
                if idle < 3 {
                    self.residency.wait();
                    gpu.wait();
                    continue;
                }
                // Everything that is not wanted has gone, and still there is no room.
                tiles.without_room += std::mem::take(&mut tiles.pending);
            }
            let selection = self.select(view, fades.then_some(now_s));
            if !streams && idle < 3 && self.asked.keys().any(|tile| self.residency.can_come(*tile)) {
                continue;
            }
            tiles.pending += self.asked.keys().filter(|tile| self.residency.can_come(**tile)).count() as u64;
            tiles.late |= !self.asked.is_empty();
            self.tell(gpu, &rule, view.camera_m);
            let prepare_ms = (self.start.elapsed().as_secs_f64() - begun_s) * 1000.0;
            return Prepared { selection, tiles, prepare_ms, jumped: flown.jumped_s == begun_s };
        }
    }

    /// The earth as a camera at a height sees it.
    pub fn bending(&self, camera_z_m: f64) -> Bending {
        let lowest_m = f64::from(self.store.range_m()[0]);
        Bending { inverse_radius: self.options.inverse_radius, camera_z_m, lowest_m }
    }

    /// How the camera moves: a step much longer than the one before is a jump, and says nothing of the next.
    fn fly_on(&self, camera_m: DVec3, now_s: f64) -> Flown {
        let Some(before) = self.flight else {
            return Flown { camera_m, velocity_m: DVec3::ZERO, at_s: now_s, jumped_s: now_s };
        };
        let (step_m, step_s) = (camera_m - before.camera_m, now_s - before.at_s);
        let expected_m = before.velocity_m.length() * step_s + self.warp.spacing_m();
        if step_m.length() > JUMP * expected_m {
            // The first step of a movement looks like a jump as well; only a long one is.
            let is_far = step_m.length() > 256.0 * self.warp.spacing_m();
            let jumped_s = if is_far { now_s } else { before.jumped_s };
            let velocity_m = if is_far || step_s > PAUSE_S { DVec3::ZERO } else { step_m / step_s.max(1e-3) };
            return Flown { camera_m, velocity_m, at_s: now_s, jumped_s };
        }
        let velocity_m = if step_s > PAUSE_S { DVec3::ZERO } else { step_m / step_s.max(1e-3) };
        Flown { camera_m, velocity_m: before.velocity_m.lerp(velocity_m, 0.5), at_s: now_s, ..before }
    }

    /// Chooses the patches; what they miss is asked for in the next frame.
    fn select(&mut self, view: &TerrainView, now_s: Option<f64>) -> Selection {
        let camera_m = view.camera_m;
        let ground_m = self.height_at_hand_m(camera_m.truncate());
        let clearance_m = ground_m.map_or(0.0, |ground_m| (camera_m.z - ground_m).abs());
        // Beside the land one looks under it.
        let highest_m = f64::from(self.store.range_m()[1]);
        let viewpoint = Viewpoint {
            camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: self.options.lod_error_px,
            bending: self.bending(camera_m.z),
            is_above_ground: camera_m.z > ground_m.unwrap_or(highest_m),
            nearest_m: (0.5 * clearance_m).max(0.02),
        };
        let atlas = &self.residency.atlas;
        let patches =
            ResidentPatches { store: &*self.store, atlas, frame: self.frame, now_s, asked: RefCell::default() };
        let anchor = self.warp.anchor(camera_m.truncate());
        let selection = selection::select(&patches, &self.warp, anchor, &viewpoint);
        self.asked = patches.asked.into_inner();
        selection
    }

    /// Writes what the shaders read.
    fn tell(&mut self, gpu: &Gpu, rule: &LevelRule, camera_m: DVec3) {
        let anchor = self.warp.anchor(camera_m.truncate());
        let residency = &self.residency;
        let needed = residency.needed.iter().map(|tile| tile.address);
        let tables = Tables::new(&*self.store, &residency.atlas, &residency.blocked, needed, anchor);
        if tables != self.tables {
            self.levels.write(gpu, &tables.levels);
            self.rows.write(gpu, &tables.rows);
            self.tiles.write(gpu, &tables.tiles);
            self.tables = tables;
        }
        self.uniform.write(gpu, &[self.uniform_for(anchor, rule)]);
    }

    fn uniform_for(&self, anchor: DVec2, rule: &LevelRule) -> TerrainUniform {
        let camera_m = rule.camera_m;
        let local = self.warp.around(anchor, camera_m.truncate());
        let size = self.store.levels()[0];
        let units = f64::from(units_log2(size)).exp2();
        let [min_m, max_m] = self.store.range_m();
        let first = -anchor * units;
        let last = (DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1)) - anchor) * units;
        // Coarse in sixteenths of a metre: exact in f32 up to a million metres.
        let coarse_m = (camera_m.z * 16.0).round() / 16.0;
        TerrainUniform {
            terms: local.terms,
            extent_units: [first.x as i32, first.y as i32, last.x as i32, last.y as i32],
            grid_unit: local.grid_unit,
            world_unit: local.world_unit,
            degree: local.degree as i32,
            level_count: self.store.levels().len() as i32,
            camera_z_coarse_m: coarse_m as f32,
            camera_z_fine_m: (camera_m.z - coarse_m) as f32,
            min_z_m: (f64::from(min_m) - camera_m.z) as f32,
            max_z_m: (f64::from(max_m) - camera_m.z) as f32,
            spacing_m: self.warp.spacing_m() as f32,
            level_error_px: rule.error_px as f32,
            level_bias: 0.0,
            focal_px: rule.focal_px as f32,
            world_origin_m: local.world_origin_m,
            units_per_sample: units as f32,
            inverse_radius: self.options.inverse_radius as f32,
        }
    }

    /// What `shaders/shared/terrain.wgsl` declares.
    pub fn resources(&self) -> [Named<'_>; 5] {
        [
            ("terrain", self.uniform.binding()),
            ("levels", self.levels.binding()),
            ("tile_rows", self.rows.binding()),
            ("tiles", self.tiles.binding()),
            ("heights", wgpu::BindingResource::TextureView(self.residency.atlas.view())),
        ]
    }
}
