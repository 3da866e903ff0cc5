//! The terrain of a world on the GPU: what `shaders/shared/terrain.wgsl` reads, kept up to date with the view.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use super::bending::Bending;
use super::budget::{Budget, Search, most_patches};
use super::flight::Flight;
use super::frustum::Frustum;
use super::needed::LevelRule;
use super::patches::ResidentPatches;
use super::residency::{Loaded, Movement, Residency};
use super::seen::{SeenTiles, TILES_PER_FRAME};
use super::selection::{self, Selection, Viewpoint};
use super::tables::Tables;
use super::terrain_buffers::{TerrainBuffers, TerrainUniform};
use super::warp::Warp;
use crate::gpu::Gpu;
use crate::gpu::pass::{Named, texture};
use crate::mesh::placed::Placed;
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

/// Tiles for the mesh come level by level; a frame that asks for tiles more often than this takes what there is.
const MOST_ROUNDS: u32 = 1000;

/// Heights as fine as this, in pixels, are all that a picture shows: with a smaller allowed error tiles are as they are
/// with this one.
const FINEST_LEVEL_ERROR_PX: f64 = 1.0 / 64.0;

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
    /// What the patches promise.
    pub detail: Detail,
}

/// How fine a frame's mesh is, where its tiles are there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Detail {
    /// The height error that the mesh was allowed, in pixels: [`TerrainOptions::lod_error_px`], or more.
    pub error_px: f64,
    /// Whether it is more: the error that was asked for takes more patches than a frame has.
    pub is_over_budget: bool,
}

/// What a frame draws and promises, before the GPU is told.
struct Fitted {
    rule: LevelRule,
    selection: Selection,
    tiles: Loaded,
    jumped: bool,
    detail: Detail,
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
    /// What the allowed error of the last frame was multiplied by.
    coarser: f64,
    /// Parts of one picture have one allowed error, in pixels: at least this.
    least_error_px: f64,
    flight: Flight,
    start: Instant,
    frame: u64,
    buffers: TerrainBuffers,
    /// Of a style with shadows or occlusion.
    seen: Option<SeenTiles>,
    meshes: Option<Arc<Placed>>,
}

/// A view as the terrain sees it.
#[derive(Clone, Debug)]
pub struct TerrainView {
    /// In the world.
    pub camera_m: DVec3,
    /// What is in view; empty frusta see nothing.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian.
    pub focal_px: f64,
    /// Pixels to be drawn, of all frusta.
    pub pixels: f64,
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
        let warp = Warp::fit(&mapping, size.width, size.height);
        Ok(Self {
            ground: Ground::new(Arc::clone(&store)),
            residency: Residency::new(gpu, Arc::clone(&store), options.tile_memory_bytes),
            store,
            mapping,
            warp,
            options,
            asked: FxHashMap::default(),
            coarser: 1.0,
            least_error_px: 0.0,
            flight: Flight::default(),
            start: Instant::now(),
            frame: 0,
            buffers: TerrainBuffers::new(gpu),
            seen: None,
            meshes: None,
        })
    }

    /// What stands on the land, if anything does.
    pub fn meshes(&self) -> Option<&Arc<Placed>> {
        self.meshes.as_ref()
    }

    /// Puts meshes onto the land, in place of those that stood there. Frames want other passes then.
    pub fn set_meshes(&mut self, placed: Placed) {
        self.meshes = (!placed.standing.is_empty()).then(|| Arc::new(placed));
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

    /// From the next frame on the mesh is allowed at least this error, in pixels, whatever the options say: all parts of
    /// a picture have that of the part with the largest. 0 holds nothing.
    pub fn hold_error_px(&mut self, error_px: f64) {
        // What was found with a factor must be found with it again, however the quotient is rounded.
        self.least_error_px = error_px * (1.0 + 1e-12);
    }

    /// How fine the mesh of a view is, as [`Terrain::prepare`] finds it: nothing is drawn.
    pub fn detail_of(&mut self, gpu: &Gpu, view: &TerrainView) -> Detail {
        self.fit(gpu, view, false).detail
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
        let seen = self.seen.as_ref().map_or(0, SeenTiles::bytes);
        self.residency.atlas.bytes() + self.buffers.bytes() + seen
    }

    /// From the next frame on it is known what the land sees of the sky and of a sun in that direction; none forgets it.
    pub fn see(&mut self, gpu: &Gpu, to_sun: Option<DVec3>) {
        match to_sun {
            Some(to_sun) => {
                let seen = self.seen.get_or_insert_with(|| SeenTiles::new(gpu, &self.residency.atlas));
                seen.set_sun(to_sun.truncate());
            }
            None => self.seen = None,
        }
    }

    /// What the land sees, where a frame has asked for it.
    pub fn seen(&self) -> Option<&SeenTiles> {
        self.seen.as_ref()
    }

    /// Sees to the tiles that a view needs, chooses its patches, and tells the shaders. Waits for the tiles only where
    /// the options say so.
    pub fn prepare(&mut self, gpu: &Gpu, view: &TerrainView) -> Prepared {
        let begun = Instant::now();
        let Fitted { rule, selection, mut tiles, jumped, detail } = self.fit(gpu, view, self.seen.is_some());
        if let Some(seen) = &mut self.seen {
            let streams = self.options.loading == Loading::Stream;
            let most = if streams { TILES_PER_FRAME } else { usize::MAX };
            let residency = &self.residency;
            tiles.late |= seen.plan(&residency.atlas, self.store.levels(), &residency.needed, most, self.frame) > 0;
        }
        self.tell(gpu, &rule);
        Prepared { selection, tiles, prepare_ms: begun.elapsed().as_secs_f64() * 1000.0, jumped, detail }
    }

    /// Brings tiles and chooses patches.
    fn fit(&mut self, gpu: &Gpu, view: &TerrainView, sees: bool) -> Fitted {
        self.frame += 1;
        let mut now_s = self.start.elapsed().as_secs_f64();
        let rule = LevelRule {
            camera_m: view.camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: self.options.lod_error_px.max(FINEST_LEVEL_ERROR_PX) * LEVEL_SHARE,
            bending: self.bending(view.camera_m.z),
        };
        let streams = self.options.loading == Loading::Stream;
        let step = self.flight.go_on(view.camera_m, now_s, self.warp.spacing_m());
        let fades = streams && step.fades();
        let mut tiles = Loaded::default();
        let mut idle = 0;
        let mut rounds = 0;
        loop {
            // While nothing fades, what has come stands at once.
            let fade_step_s = streams.then_some(if fades { step.step_s } else { f64::INFINITY });
            let asked = std::mem::take(&mut self.asked);
            let movement =
                Movement { rule: rule.clone(), velocity_m: step.velocity_m, frame_s: step.step_s, asked, sees };
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
            let goes_on = streams && !step.has_jumped();
            let mut selection = None;
            let searches = match (streams, goes_on) {
                (true, true) => &[Search::GoOn { step_s: step.step_s }][..],
                (true, false) => &[Search::Exactly],
                // What the least factor needs is not there before what a larger one needs is.
                (false, _) => &[Search::Roughly, Search::Exactly],
            };
            let mut waits = false;
            for search in searches {
                selection = Some(self.select(view, fades.then_some(now_s), *search));
                waits = !streams
                    && idle < 3
                    && rounds < MOST_ROUNDS
                    && self.asked.keys().any(|tile| self.residency.can_come(*tile));
                // A factor of 1 is exact.
                if waits || self.coarser == 1.0 {
                    break;
                }
            }
            rounds += 1;
            let Some(selection) = selection.filter(|_| !waits) else { continue };
            tiles.pending += self.asked.keys().filter(|tile| self.residency.can_come(**tile)).count() as u64;
            tiles.late |= !self.asked.is_empty();
            let detail =
                Detail { error_px: self.options.lod_error_px * self.coarser, is_over_budget: self.coarser > 1.0 };
            return Fitted { rule, selection, tiles, jumped: step.has_jumped(), detail };
        }
    }

    /// The earth as a camera at a height sees it.
    pub fn bending(&self, camera_z_m: f64) -> Bending {
        let lowest_m = f64::from(self.store.range_m()[0]);
        Bending { inverse_radius: self.options.inverse_radius, camera_z_m, lowest_m }
    }

    /// No part of the surface is nearer to a camera than this: half its height above ground, by the heights at hand.
    pub fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let ground_m = self.height_at_hand_m(camera_m.truncate());
        let clearance_m = ground_m.map_or(0.0, |ground_m| (camera_m.z - ground_m).abs());
        (0.5 * clearance_m).max(0.02)
    }

    /// Chooses the patches within the frame's budget; what they miss is asked for in the next frame.
    fn select(&mut self, view: &TerrainView, now_s: Option<f64>, search: Search) -> Selection {
        let camera_m = view.camera_m;
        let ground_m = self.height_at_hand_m(camera_m.truncate());
        // Beside the land one looks under it.
        let highest_m = f64::from(self.store.range_m()[1]);
        let lod_error_px = self.options.lod_error_px;
        let mut viewpoint = Viewpoint {
            camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: lod_error_px,
            bending: self.bending(camera_m.z),
            is_above_ground: camera_m.z > ground_m.unwrap_or(highest_m),
            nearest_m: self.nearest_m(camera_m),
        };
        let atlas = &self.residency.atlas;
        let anchor = self.warp.anchor(camera_m.truncate());
        let samples = self.store.levels()[0].samples() as f64;
        let budget = Budget::new(
            most_patches(view.pixels, samples, lod_error_px, self.options.tile_memory_bytes),
            if self.least_error_px > lod_error_px * (1.0 + 1e-9) { self.least_error_px / lod_error_px } else { 1.0 },
        );
        let (frame, store, warp) = (self.frame, &*self.store, &self.warp);
        let ((selection, asked), coarser) = budget.find(search, self.coarser, |coarser, most| {
            viewpoint.error_px = lod_error_px * coarser;
            // What a choice asked for that was over the budget is not wanted.
            let patches = ResidentPatches { store, atlas, frame, now_s, asked: RefCell::default() };
            let selection = selection::select_within(&patches, warp, anchor, &viewpoint, most)?;
            Some((selection, patches.asked.into_inner()))
        });
        self.asked = asked;
        self.coarser = coarser;
        selection
    }

    /// Writes what the shaders read.
    fn tell(&mut self, gpu: &Gpu, rule: &LevelRule) {
        let anchor = self.warp.anchor(rule.camera_m.truncate());
        let tables = Tables::new(&*self.store, &self.residency, self.seen.as_ref(), anchor);
        let uniform = TerrainUniform::new(&*self.store, &self.warp, anchor, rule);
        self.buffers.write(gpu, tables, uniform);
    }

    /// For passes that ask no surface: what `hachure::earth` needs.
    pub fn uniform(&self) -> Named<'_> {
        self.buffers.uniform()
    }

    /// What `shaders/shared/terrain.wgsl` and `shared/surface.wgsl` declare.
    pub fn resources(&self) -> [Named<'_>; 5] {
        self.buffers.resources(&self.residency.atlas)
    }

    /// What `shaders/shared/seen.wgsl` needs beside the uniform; none if nobody has asked for what the land sees.
    pub fn seen_resources(&self) -> Option<[Named<'_>; 5]> {
        let seen = self.seen.as_ref()?;
        let (view, sampler) = (seen.view(), seen.sampler());
        let [_, levels, rows, tiles, _] = self.resources();
        Some([
            levels,
            rows,
            tiles,
            ("seen_tiles", texture(view)),
            ("seen_sampler", wgpu::BindingResource::Sampler(sampler)),
        ])
    }
}
