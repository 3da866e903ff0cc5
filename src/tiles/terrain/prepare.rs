//! Preparing a frame: loading the tiles that a view needs, selecting the patches to draw, and writing the shaders'
//! buffers.
//!
//! A frame for a file repeats this until a pass over all tiles requests nothing more, so that the order of their
//! arrival has no effect. A frame of a window uses the tiles that are on the GPU.
//!
//! Why: `docs/decisions/same-picture.md`, `docs/decisions/work-budget.md`.

use std::cell::RefCell;
use std::time::Instant;

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::{Loading, Terrain};
use crate::gpu::Gpu;
use crate::pyramid::TileAddress;
use crate::pyramid::surface::statistics::PAGE_PATCHES;
use crate::scene::frustum::Frustum;
use crate::tiles::budget::{Budget, Search, max_patches};
use crate::tiles::needed::LevelRule;
use crate::tiles::page_table::{PageTable, TableVersion};
use crate::tiles::patch_tree::PatchTree;
use crate::tiles::patches::ResidentPatches;
use crate::tiles::residency::{Loaded, Movement};
use crate::tiles::select::select_in;
use crate::tiles::selection::{Selection, Viewpoint};
use crate::tiles::slot_maps::{MapStep, SlotMaps, maps_of_frame};
use crate::tiles::terrain_buffers::TerrainUniform;

/// The fraction of the allowed error that the choice of the tile level may use. The other half is for deviations between
/// the samples at which the errors of tiles were measured.
const LEVEL_SHARE: f64 = 0.5;

/// Tiles for the mesh are loaded level by level; a frame that requests tiles more often than this uses the existing
/// ones.
const MAX_ROUNDS: u32 = 1000;

/// A file whose tiles do not fit into memory is tried with errors this many times larger, one after the other.
const RAISE: f64 = 1.189_207_115_002_721; // A quarter of an octave.
/// The factor from which on the error of a file is not raised: what does not fit then never will, because the tiles around
/// the camera are needed whatever the error.
const MAX_RAISE: f64 = 64.0;

/// The smallest allowed error, in pixels, that affects the choice of tiles: finer heights are not visible in a picture.
const FINEST_LEVEL_ERROR_PX: f64 = 1.0 / 64.0;

/// A view as the terrain sees it.
#[derive(Clone, Debug)]
pub struct TerrainView {
    /// Position of the camera in the world, in metres.
    pub camera_m: DVec3,
    /// The view frusta; empty frusta see nothing.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian in the middle of the picture.
    pub focal_px: f64,
    /// Number of pixels to be drawn, in all frusta.
    pub pixels: f64,
    /// Angle of the horizon below level, in radians; 0 for the earth's own curvature.
    pub horizon_rad: f64,
}

/// The result of preparing a frame.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// The patches to draw, and their levels.
    pub selection: Selection,
    /// Number of tiles that were loaded, and of those that are still missing.
    pub tiles: Loaded,
    /// Time that the frame thread spent on tiles and patches, in milliseconds.
    pub prepare_ms: f64,
    /// Whether the camera jumped to this frame; the first frame counts as a jump.
    pub jumped: bool,
    /// The error that the patches guarantee.
    pub detail: Detail,
}

/// The accuracy of a frame's mesh, where its tiles are loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// The allowed height error of the mesh, in pixels:
    /// [`TerrainOptions::lod_error_px`](super::TerrainOptions::lod_error_px), or more.
    pub error_px: f64,
    /// Whether it is more, because the requested error needs more patches than the budget of a frame.
    pub is_over_budget: bool,
    /// The factor by which the surface is coarser than requested, because its tiles would not fit into the memory for
    /// tiles; 1 if they fit. The allowed error includes it.
    pub memory_factor: f64,
}

impl Default for Detail {
    fn default() -> Self {
        Self { error_px: 0.0, is_over_budget: false, memory_factor: 1.0 }
    }
}

/// The tiles that the mesh of a file requests, at one error.
#[derive(Default)]
struct OfMesh {
    /// All tiles that it has used or requested.
    all: FxHashSet<TileAddress>,
    /// All tiles that it has requested.
    requested: FxHashSet<TileAddress>,
    /// Whether it uses only tiles that it has requested or that the view needs: whether they fit must not depend on
    /// tiles that are on the GPU by chance.
    is_strict: bool,
}

/// The selection of a frame and its accuracy, before the buffers are written.
struct Fitted {
    rule: LevelRule,
    selection: Selection,
    tiles: Loaded,
    jumped: bool,
    detail: Detail,
    /// Time since the last frame, in seconds; `None` disables fading, as in [`MapStep::fade_step_s`].
    fade_step_s: Option<f64>,
    /// Time since the last frame, in seconds.
    elapsed_s: f64,
    /// Whether the camera rests.
    is_at_rest: bool,
}

/// Adds the tiles of a selection's patches and the tiles above them, of a pyramid with `levels` levels.
fn add_tiles_of(selection: &Selection, levels: u32, tiles: &mut FxHashSet<TileAddress>) {
    for key in &selection.leaves {
        // Patches finer than the data are in tiles of level 0.
        let below = (-key.level).max(0);
        let (level, x, y) = (key.level.max(0) as u32, (key.x >> below) as u32, (key.y >> below) as u32);
        for up in 0..levels.saturating_sub(level) {
            let tile = TileAddress { level: level + up, x: (x >> up) / PAGE_PATCHES, y: (y >> up) / PAGE_PATCHES };
            // What is above a tile that is known is known too.
            if !tiles.insert(tile) {
                break;
            }
        }
    }
}

impl Terrain {
    /// Sets the smallest allowed error of the mesh from the next frame on, in pixels, whatever the options say, so that
    /// all parts of a picture have the error of the part with the largest. 0 removes it.
    pub fn hold_error_px(&mut self, error_px: f64) {
        // The same factor must be found again, however the quotient is rounded.
        self.min_error_px = error_px * (1.0 + 1e-12);
    }

    /// Returns the accuracy of a view's mesh, as [`Terrain::prepare`] finds it, without drawing.
    pub fn detail_of(&mut self, gpu: &Gpu, view: &TerrainView) -> Detail {
        self.fit(gpu, view, false).detail
    }

    /// Loads the tiles that a view needs, selects its patches, and writes the shaders' buffers. Waits for the tiles
    /// only if the options say so.
    pub fn prepare(&mut self, gpu: &Gpu, view: &TerrainView) -> Prepared {
        let begun = Instant::now();
        let fitted = self.fit(gpu, view, self.needs_horizons || self.needs_water);
        let Fitted { rule, selection, mut tiles, jumped, detail, fade_step_s, elapsed_s, is_at_rest } = fitted;
        let streams = self.options.loading == Loading::Stream;
        let most = if streams { maps_of_frame(elapsed_s) } else { usize::MAX };
        let step = MapStep { frame: self.frame, most, fade_step_s, is_at_rest };
        if let Some(horizons) = self.horizon_maps.as_mut().filter(|_| self.needs_horizons) {
            tiles.late_maps |= horizons.maps.plan(&self.residency, self.store.levels(), step);
        }
        if let Some(maps) = self.water_maps.as_mut().filter(|_| self.needs_water) {
            tiles.late_maps |= maps.plan(&self.residency, self.store.levels(), step);
        }
        tiles.late_land = tiles.late;
        tiles.late |= tiles.late_maps;
        self.write_buffers(gpu, &rule);
        Prepared { selection, tiles, prepare_ms: begun.elapsed().as_secs_f64() * 1000.0, jumped, detail }
    }

    /// Loads tiles and selects patches. For a file, it repeats until a pass loads nothing and requests nothing: after three
    /// passes without an upload, the missing tiles count as without room; then the mesh is selected, and if it requests
    /// tiles that can still be loaded, the loop begins again, at most [`MAX_ROUNDS`] times. If memory is too small for the
    /// tiles, the loop begins again with a larger error, which depends on the view alone. A window makes one pass.
    fn fit(&mut self, gpu: &Gpu, view: &TerrainView, needs_map_neighbours: bool) -> Fitted {
        self.frame += 1;
        self.horizon_rad = view.horizon_rad;
        let mut now_s = self.clock.now_s();
        let rule = LevelRule {
            camera_m: view.camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: self.options.lod_error_px.max(FINEST_LEVEL_ERROR_PX) * LEVEL_SHARE,
            earth_curvature: self.earth_curvature(view.camera_m.z),
            margin_m: 0.0,
        };
        let streams = self.options.loading == Loading::Stream;
        let step = self.motion.advance(view.camera_m, now_s, self.grid_projection.spacing_m());
        let fades = streams && step.fades();
        // While nothing fades, new tiles appear at once.
        let fade_step_s = streams.then_some(if fades { step.elapsed_s } else { f64::INFINITY });
        let mut tiles = Loaded::default();
        let mut idle = 0;
        let mut rounds = 0;
        let mut of_mesh = OfMesh::default();
        // The frame in which the current attempt to draw a file began.
        let mut begun_in = self.frame;
        if !streams {
            self.residency.set_memory_factor(1.0);
        }
        loop {
            let requested = std::mem::take(&mut self.requested);
            // Wider pixels are fewer pixels per radian. A window's list of tiles has the factor in it.
            let raised = if streams { 1.0 } else { self.residency.memory_factor() };
            let movement = Movement {
                rule: LevelRule { focal_px: rule.focal_px / raised, ..rule.clone() },
                velocity_m_s: step.velocity_m_s,
                has_jumped: step.has_jumped(),
                frame_s: step.elapsed_s,
                requested,
                needed_since: begun_in,
                needs_map_neighbours,
            };
            self.frame += u64::from(!streams);
            let update = self.residency.update(gpu, &self.grid_projection, &movement, self.frame, now_s, fade_step_s);
            let loaded = tiles.loaded + update.loaded;
            tiles = Loaded { loaded, ..update };
            if !streams && self.residency.is_short_of_slots() && raised < MAX_RAISE {
                self.raise_error();
                of_mesh = OfMesh::default();
                (idle, rounds, begun_in) = (0, 0, self.frame);
                continue;
            }
            // With an unreadable tile there will be no picture, so there is no reason to wait.
            let waits = !streams && tiles.failed == 0;
            // The last tiles may request more: only a pass without new tiles is final.
            if waits && (tiles.pending > 0 || update.loaded > 0) {
                self.requested = movement.requested;
                now_s = self.clock.now_s();
                idle = if update.loaded > 0 || self.residency.is_busy(now_s) { 0 } else { idle + 1 };
                if idle < 3 {
                    self.residency.wait();
                    gpu.wait();
                    continue;
                }
                // All unwanted tiles have been evicted, and there are still too few slots.
                tiles.without_room += std::mem::take(&mut tiles.pending);
            }
            let is_continuous = streams && !step.has_jumped();
            let mut selection = None;
            let searches = match (streams, is_continuous) {
                (true, true) => &[Search::GoOn { step_s: step.elapsed_s }][..],
                (true, false) => &[Search::Exactly],
                // The tiles for the smallest factor are loaded after those for a larger one.
                (false, _) => &[Search::Roughly, Search::Exactly],
            };
            let (mut must_repeat, mut must_raise) = (false, false);
            if waits && !of_mesh.is_strict && self.residency.is_tight() {
                of_mesh = self.strict_mesh();
            }
            for search in searches {
                let only = of_mesh.is_strict.then(|| self.residency.needed_and(&of_mesh.requested));
                let selected = selection.insert(self.select(view, fades.then_some(now_s), *search, only.as_ref()));
                if waits {
                    of_mesh.requested.extend(self.requested.keys());
                    of_mesh.all.extend(self.requested.keys());
                    add_tiles_of(selected, self.store.levels().len() as u32, &mut of_mesh.all);
                    // Tiles for which there is no slot would take each other's.
                    must_raise = raised < MAX_RAISE && !self.residency.has_slots_for(&of_mesh.all);
                    if must_raise {
                        break;
                    }
                }
                // A strict mesh ignores tiles on the GPU until it has requested them.
                let is_unknown = |tile: &TileAddress| only.as_ref().is_some_and(|only| !only.contains(tile));
                let can_come = |tile: &TileAddress| is_unknown(tile) || self.residency.can_come(*tile);
                must_repeat = waits && idle < 3 && rounds < MAX_ROUNDS && self.requested.keys().any(can_come);
                // A factor of 1 is exact.
                if must_repeat || self.coarser == 1.0 {
                    break;
                }
            }
            rounds += 1;
            if must_raise {
                if of_mesh.is_strict {
                    self.raise_error();
                    of_mesh = OfMesh::default();
                } else {
                    self.begin_again();
                    of_mesh = self.strict_mesh();
                }
                (idle, rounds, begun_in) = (0, 0, self.frame);
                continue;
            }
            let Some(selection) = selection.filter(|_| !must_repeat) else {
                continue;
            };
            tiles.pending += self.requested.keys().filter(|tile| self.residency.can_come(**tile)).count() as u64;
            // A frame whose error was raised and reported is not late because its mesh could be finer.
            tiles.late |= !self.requested.is_empty() && (!streams || self.residency.memory_factor() == 1.0);
            let memory_factor = self.residency.memory_factor();
            let detail = Detail {
                error_px: self.options.lod_error_px * self.coarser,
                is_over_budget: self.coarser > memory_factor,
                memory_factor,
            };
            let rule = LevelRule { focal_px: rule.focal_px / memory_factor, ..rule };
            return Fitted {
                rule,
                selection,
                tiles,
                jumped: step.has_jumped(),
                detail,
                fade_step_s,
                elapsed_s: step.elapsed_s,
                is_at_rest: self.residency.list_is_exact(),
            };
        }
    }

    /// Raises the error of a file because memory is too small for its tiles.
    fn raise_error(&mut self) {
        self.residency.set_memory_factor(self.residency.memory_factor() * RAISE);
        self.begin_again();
    }

    /// Begins a frame for a file again. The next attempt counts as another frame: tiles that only the previous attempt
    /// needed lose their slots, whatever the order in which they came.
    fn begin_again(&mut self) {
        self.frame += 1;
        self.requested.clear();
    }

    fn strict_mesh(&mut self) -> OfMesh {
        // The quadtree has the patches of all tiles on the GPU.
        self.tree = PatchTree::default();
        OfMesh { is_strict: true, ..OfMesh::default() }
    }

    /// Selects the patches within the frame's budget, from the tiles `only` or from all; tiles that they miss are requested
    /// in the next frame.
    fn select(
        &mut self,
        view: &TerrainView,
        now_s: Option<f64>,
        search: Search,
        only: Option<&FxHashSet<TileAddress>>,
    ) -> Selection {
        let camera_m = view.camera_m;
        let ground = self.residency.ground(self.grid_projection.grid_from_world(camera_m.truncate()));
        // A camera outside of the land can see it from below. Over land that is known roughly, a camera counts as above
        // ground: from below, nothing hides anything, and the frame would cost many times as much.
        let highest_m = f64::from(self.store.range_m()[1]);
        let lowest_ground_m = ground.map_or(highest_m, |ground| ground.height_m - ground.error_m);
        let lod_error_px = self.options.lod_error_px;
        let mut viewpoint = Viewpoint {
            camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: lod_error_px,
            earth_curvature: self.earth_curvature(camera_m.z),
            is_above_ground: camera_m.z > lowest_ground_m,
            nearest_m: self.nearest_m(camera_m),
        };
        let atlas = &self.residency.atlas;
        let anchor = self.grid_projection.anchor(camera_m.truncate());
        let samples = self.store.levels()[0].samples() as f64;
        let of_parts =
            if self.min_error_px > lod_error_px * (1.0 + 1e-9) { self.min_error_px / lod_error_px } else { 1.0 };
        let budget = Budget::new(
            max_patches(view.pixels, samples, lod_error_px, self.options.tile_memory_bytes),
            // A mesh finer than the surface shows nothing more.
            of_parts.max(self.residency.memory_factor()),
        );
        let (frame, store, grid_projection) = (self.frame, &*self.store, &self.grid_projection);
        let tree = &mut self.tree;
        let (((selection, skyline), requested), coarser) = budget.find(search, self.coarser, |coarser, most| {
            viewpoint.error_px = lod_error_px * coarser;
            // The requests of a selection that exceeded the budget are dropped.
            let patches = ResidentPatches { store, atlas, only, frame, now_s, requested: RefCell::default() };
            let selected = select_in(tree, &patches, grid_projection, anchor, &viewpoint, most, false)?;
            Some((selected, patches.requested.into_inner()))
        });
        self.requested = requested;
        self.coarser = coarser;
        self.tree.reuse(skyline);
        selection
    }

    /// Writes the buffers that the shaders read.
    fn write_buffers(&mut self, gpu: &Gpu, rule: &LevelRule) {
        let anchor = self.grid_projection.anchor(rule.camera_m.truncate());
        let horizon_maps = self.horizon_maps.as_ref().map(|horizons| &horizons.maps);
        let water_maps = self.water_maps.as_ref();
        let version = TableVersion {
            residency: self.residency.version(),
            floor: self.residency.floor.version(),
            horizon_maps: horizon_maps.map(SlotMaps::table_version),
            water_maps: water_maps.map(SlotMaps::table_version),
        };
        let table = || PageTable::new(&*self.store, &self.residency, horizon_maps, water_maps);
        let uniform =
            TerrainUniform::new(&*self.store, &self.grid_projection, anchor, rule, self.options.inverse_radius);
        self.buffers.write(gpu, version, table, self.store.levels(), anchor, uniform);
    }
}
