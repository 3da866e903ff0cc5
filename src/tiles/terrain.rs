//! The terrain of a world on the GPU: what `shaders/shared/terrain.wgsl` reads, kept up to date with the view.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

use super::atlas::{Atlas, SLOT_BYTES};
use super::frustum::Frustum;
use super::residency::{self, LevelRule, Loaded};
use super::selection::{self, Selection, UNITS_LOG2, Viewpoint};
use super::warp::{MAX_TERMS, Warp};
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::Named;
use crate::pyramid::Pyramid;
use crate::source::{GeoreferenceError, WorldMapping};

/// Accuracy and memory: the knobs of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerrainOptions {
    /// The height error that may be seen, in pixels.
    pub lod_error_px: f64,
    /// For tiles on the GPU.
    pub tile_memory_bytes: u64,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self { lod_error_px: 1.0, tile_memory_bytes: 512 << 20 }
    }
}

/// Of the allowed error, the part that the choice of the level may use: positions are on the level's surface exactly,
/// so the rest is for what happens between the samples where errors were measured.
const LEVEL_SHARE: f64 = 0.5;

/// Samples along a side: grid units of 32 bits reach from one end to the other.
const MOST_SAMPLES: u32 = 1 << 18;

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

/// What was prepared for a frame.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// The patches to draw.
    pub selection: Selection,
    /// What the tiles did.
    pub tiles: Loaded,
}

/// The terrain.
pub struct Terrain {
    pyramid: Pyramid,
    mapping: WorldMapping,
    warp: Warp,
    options: TerrainOptions,
    atlas: Atlas,
    frame: u64,
    uniform: GrowingBuffer,
    levels: GrowingBuffer,
    pages: GrowingBuffer,
    corner_errors: GrowingBuffer,
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
    pad: [f32; 2],
}

crate::gpu::shared::describe!(TerrainUniform as "Terrain" in "surface/resolve": terms, extent_units, grid_unit, world_unit, degree, level_count, camera_z_coarse_m, camera_z_fine_m, min_z_m, max_z_m, spacing_m, level_error_px, level_bias, focal_px, world_origin_m, pad);

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
    /// Puts a pyramid's tables on the GPU; tiles follow with the views.
    ///
    /// # Errors
    /// [`TerrainError`].
    pub fn new(gpu: &Gpu, pyramid: Pyramid, options: TerrainOptions) -> Result<Self, TerrainError> {
        use wgpu::BufferUsages as Usage;
        let size = pyramid.levels()[0];
        if size.width.max(size.height) > MOST_SAMPLES {
            return Err(TerrainError::TooWide { width: size.width, height: size.height });
        }
        let mapping = WorldMapping::new(pyramid.georeference(), size.width, size.height)?;
        let warp = Warp::fit(&mapping, size.width, size.height);
        let tiles = pyramid.levels().iter().map(|size| u64::from(size.tiles_x()) * u64::from(size.tiles_y())).sum();
        let atlas = Atlas::new(gpu, tiles, options.tile_memory_bytes);
        let mut corner_errors = GrowingBuffer::new(gpu, "tile errors", Usage::STORAGE);
        corner_errors.write(gpu, &residency::corner_errors_m(&pyramid));
        Ok(Self {
            pyramid,
            mapping,
            warp,
            options,
            atlas,
            frame: 0,
            uniform: GrowingBuffer::new(gpu, "terrain", Usage::UNIFORM),
            levels: GrowingBuffer::new(gpu, "levels", Usage::STORAGE),
            pages: GrowingBuffer::new(gpu, "pages", Usage::STORAGE),
            corner_errors,
        })
    }

    /// Grid ↔ world ↔ CRS, exactly.
    pub fn mapping(&self) -> &WorldMapping {
        &self.mapping
    }

    /// East and north extent in metres.
    pub fn extent_m(&self) -> [f64; 2] {
        let size = self.pyramid.levels()[0];
        let (right, bottom) = (f64::from(size.width - 1), f64::from(size.height - 1));
        let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
        let places = corners.map(|(x, y)| self.warp.world_from_grid(DVec2::new(x, y)));
        let low = places.into_iter().reduce(DVec2::min).unwrap_or_default();
        let high = places.into_iter().reduce(DVec2::max).unwrap_or_default();
        (high - low).to_array()
    }

    /// The heights.
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
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

    /// Height of the surface in metres at a place in the world; none outside and in holes.
    pub fn height_m(&self, world_m: DVec2) -> Option<f64> {
        let grid = self.warp.grid_from_world(world_m);
        self.pyramid.height_m(grid.x, grid.y)
    }

    /// (tiles on the GPU, tiles that made room since the start, bytes of tiles on the GPU).
    pub fn atlas_state(&self) -> (usize, u64, u64) {
        (self.atlas.len(), self.atlas.evicted(), self.atlas.len() as u64 * SLOT_BYTES)
    }

    /// Bytes that the terrain holds on the GPU.
    pub fn gpu_bytes(&self) -> u64 {
        let buffers = [&self.uniform, &self.levels, &self.pages, &self.corner_errors];
        self.atlas.bytes() + buffers.iter().map(|buffer| buffer.buffer().size()).sum::<u64>()
    }

    /// Loads what a view needs, chooses its patches, and tells the shaders.
    pub fn prepare(&mut self, gpu: &Gpu, view: &TerrainView) -> Prepared {
        self.frame += 1;
        let rule = LevelRule {
            camera_m: view.camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: self.options.lod_error_px * LEVEL_SHARE,
            bias: 0.0,
        };
        let needed = residency::needed(&self.pyramid, &self.warp, &rule);
        let tiles = residency::load(gpu, &self.pyramid, &mut self.atlas, &needed, self.frame);
        if tiles.loaded > 0 || self.frame == 1 {
            self.pages.write(gpu, &residency::pages(&self.pyramid, &self.atlas));
        }

        let camera_m = view.camera_m;
        let anchor = self.warp.anchor(camera_m.truncate());
        self.levels.write(gpu, &residency::level_infos(&self.pyramid, anchor));
        self.uniform.write(gpu, &[self.uniform_for(anchor, &rule)]);

        let clearance_m = self.height_m(camera_m.truncate()).map_or(0.0, |ground_m| (camera_m.z - ground_m).abs());
        let viewpoint = Viewpoint {
            camera_m,
            frusta: view.frusta.clone(),
            focal_px: view.focal_px,
            error_px: self.options.lod_error_px,
            nearest_m: (0.5 * clearance_m).max(0.02),
        };
        let selection = selection::select(&self.pyramid, &self.warp, anchor, &viewpoint);
        Prepared { selection, tiles }
    }

    fn uniform_for(&self, anchor: DVec2, rule: &LevelRule) -> TerrainUniform {
        let camera_m = rule.camera_m;
        let local = self.warp.around(anchor, camera_m.truncate());
        let size = self.pyramid.levels()[0];
        let units = f64::from(UNITS_LOG2).exp2();
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
            level_count: self.pyramid.levels().len() as i32,
            camera_z_coarse_m: coarse_m as f32,
            camera_z_fine_m: (camera_m.z - coarse_m) as f32,
            min_z_m: (f64::from(self.pyramid.min_m()) - camera_m.z) as f32,
            max_z_m: (f64::from(self.pyramid.max_m()) - camera_m.z) as f32,
            spacing_m: self.warp.spacing_m() as f32,
            level_error_px: rule.error_px as f32,
            level_bias: rule.bias as f32,
            focal_px: rule.focal_px as f32,
            world_origin_m: local.world_origin_m,
            pad: [0.0; 2],
        }
    }

    /// What `shaders/shared/terrain.wgsl` declares.
    pub fn resources(&self) -> [Named<'_>; 5] {
        [
            ("terrain", self.uniform.binding()),
            ("levels", self.levels.binding()),
            ("pages", self.pages.binding()),
            ("corner_errors_m", self.corner_errors.binding()),
            ("heights", wgpu::BindingResource::TextureView(self.atlas.view())),
        ]
    }
}
