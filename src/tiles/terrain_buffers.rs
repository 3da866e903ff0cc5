//! The GPU resources that `shaders/shared/terrain.wgsl` declares: the terrain's uniform and the page table.

use glam::DVec2;

use super::atlas::Atlas;
use super::grid_projection::GridProjection;
use super::needed::LevelRule;
use super::page_table::{LevelInfo, PageTable, TableVersion};
use super::selection::units_log2;
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::target::{Group, TextureName};
pub(crate) use crate::gpu::wgsl::shared::terrain::Terrain as TerrainUniform;
use crate::pyramid::{LevelSize, TileStore};

/// The tiles of heights.
const HEIGHT_TILES: TextureName = TextureName {
    name: "height tiles",
    content: Group::Surface.shows("Tiles of heights that are on the GPU, in metres, side by side"),
};

impl TerrainUniform {
    /// Computes the uniform of a view. `anchor` is the sample that grid coordinates count from; `earth_inverse_radius`
    /// is that of the earth itself, which may be less curved than the earth of the view.
    pub(super) fn new(
        store: &dyn TileStore,
        grid_projection: &GridProjection,
        anchor: DVec2,
        rule: &LevelRule,
        earth_inverse_radius: f64,
    ) -> Self {
        let camera_m = rule.camera_m;
        let local = grid_projection.around(anchor, camera_m.truncate());
        let size = store.levels()[0];
        let units = f64::from(units_log2(size)).exp2();
        let [min_m, max_m] = store.range_m();
        let first = -anchor * units;
        let last = (DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1)) - anchor) * units;
        // The coarse part is in sixteenths of a metre: exact in f32 up to a million metres.
        let coarse_m = (camera_m.z * 16.0).round() / 16.0;
        Self {
            terms: local.terms,
            extent_units: [first.x as i32, first.y as i32, last.x as i32, last.y as i32],
            grid_unit: local.grid_unit,
            world_unit: local.world_unit,
            degree: local.degree as i32,
            level_count: store.levels().len() as i32,
            camera_z_coarse_m: coarse_m as f32,
            camera_z_fine_m: (camera_m.z - coarse_m) as f32,
            min_z_m: (f64::from(min_m) - camera_m.z) as f32,
            max_z_m: (f64::from(max_m) - camera_m.z) as f32,
            spacing_m: grid_projection.spacing_m() as f32,
            level_error_px: rule.error_px as f32,
            world_origin_m: local.world_origin_m,
            focal_px: rule.focal_px as f32,
            units_per_sample: units as f32,
            inverse_radius: rule.earth_curvature.inverse_radius as f32,
            earth_inverse_radius: earth_inverse_radius as f32,
        }
    }
}

/// The uniform and the page table on the GPU, in buffers that grow on demand.
pub(super) struct TerrainBuffers {
    /// The page table that the buffers contain and its version, so that an unchanged table is written only once.
    page_table: PageTable,
    version: Option<TableVersion>,
    written_levels: Vec<LevelInfo>,
    uniform: GrowingBuffer,
    levels: GrowingBuffer,
    rows: GrowingBuffer,
    tiles: GrowingBuffer,
}

impl TerrainBuffers {
    /// Creates small, empty buffers.
    pub(super) fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        Self {
            page_table: PageTable::default(),
            version: None,
            written_levels: Vec::new(),
            uniform: GrowingBuffer::new(gpu, "terrain", Usage::UNIFORM),
            levels: GrowingBuffer::new(gpu, "levels", Usage::STORAGE),
            rows: GrowingBuffer::new(gpu, "tile rows", Usage::STORAGE),
            tiles: GrowingBuffer::new(gpu, "tiles", Usage::STORAGE),
        }
    }

    /// Writes the uniform, and the page table as far as it has changed: `table` builds it if its `version` is new.
    pub(super) fn write(
        &mut self,
        gpu: &Gpu,
        version: TableVersion,
        table: impl FnOnce() -> PageTable,
        levels: &[LevelSize],
        anchor: DVec2,
        uniform: TerrainUniform,
    ) {
        if self.version.replace(version) != Some(version) {
            let page_table = table();
            if page_table != self.page_table {
                self.rows.write(gpu, &page_table.rows);
                self.tiles.write(gpu, &page_table.tiles);
                self.page_table = page_table;
            }
        }
        let registered = self.page_table.registered(levels, anchor);
        if registered != self.written_levels {
            self.levels.write(gpu, &registered);
            self.written_levels = registered;
        }
        self.uniform.write(gpu, &[uniform]);
    }

    /// Returns the size of the buffers in bytes.
    pub(super) fn bytes(&self) -> u64 {
        let buffers = [&self.uniform, &self.levels, &self.rows, &self.tiles];
        buffers.iter().map(|buffer| buffer.buffer().size()).sum()
    }

    /// Returns the uniform alone.
    pub(super) fn uniform(&self) -> Named {
        ("terrain", self.uniform.binding())
    }

    /// Returns the uniform, the page table and the heights, under their names in the shaders.
    pub(super) fn resources(&self, atlas: &Atlas) -> [Named; 5] {
        [
            self.uniform(),
            ("levels", self.levels.binding()),
            ("tile_rows", self.rows.binding()),
            ("tiles", self.tiles.binding()),
            ("heights", Resource::Texture(HEIGHT_TILES, atlas.view().clone())),
        ]
    }
}
