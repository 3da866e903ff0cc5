//! Marks whose mean ink is the tone that was asked for.
//!
//! A map of marks is even over the tile and about every place of it (`tonal_art_map`), but what a picture shows are
//! marks of two scales, of several layers and charts, cut by the land. Rows of two scales fall on each other here and
//! between each other there, and the mean of their ink goes up and down with that. So the ink is counted after all
//! marks are known, in cells of 8 × 8 pixels; a step of Newton's method, for the mean in a bell about each cell, says
//! how much darker or lighter to draw; and the marks are drawn again so, from what the first time left at each pixel
//! (`Cover`: how far the nearest mark reaches, and how fast it grows). It is the local histogram equalisation of
//! `tonal_art_map::equalise`, at the one tone that is asked for, on the picture. The windows are those of the marks on
//! the ground, so the step changes as slowly as these do.

use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// Ink without bounds, and its rise.
pub const COVER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;
/// Ink of marks, 0 to 1.
pub const MARKS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// The names of the passes, in order.
pub const PASSES: [&str; 3] = ["tones/balance/sums", "tones/balance/windows", "tones/balance/ink"];
/// How far ink is balanced: a part of a large picture needs this margin.
pub const REACH_PX: u32 = 8 * 6;

/// Side of a cell; `shaders/shared/cover.wgsl` has it too.
const CELL_PX: u32 = 8;
/// Rows of a workgroup that are cells.
const CELLS_PER_GROUP: u32 = 8;

/// The pictures between the passes.
pub struct BalanceTargets {
    /// What marks ink, and would if they were darker.
    pub cover: Target,
    /// Of cells.
    pub sums: Target,
    /// Of cells: added to the darkness.
    pub more: Target,
    /// Ink.
    pub marks: Target,
}

impl BalanceTargets {
    /// Makes them. Cells are counted in the whole picture, so a part may see one more.
    pub fn new(gpu: &Gpu, size_px: [u32; 2]) -> Self {
        let cells = size_px.map(|side| side.div_ceil(CELL_PX) + 1);
        Self {
            cover: Target::storage(gpu, "cover", size_px, COVER_FORMAT),
            sums: Target::storage(gpu, "ink sums", cells, wgpu::TextureFormat::Rgba32Float),
            more: Target::storage(gpu, "more ink", cells, wgpu::TextureFormat::R32Float),
            marks: Target::storage(gpu, "marks", size_px, MARKS_FORMAT),
        }
    }

    /// All of them.
    pub fn all(&self) -> [&Target; 4] {
        [&self.cover, &self.sums, &self.more, &self.marks]
    }
}

/// The passes.
pub struct BalancePasses {
    sums: ComputePass,
    windows: ComputePass,
    ink: ComputePass,
}

impl BalancePasses {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        let [sums, windows, ink] = PASSES.map(|name| ComputePass::new(gpu, name));
        Self { sums, windows, ink }
    }

    /// Draws the marks of `targets.cover` into `targets.marks`. `tone`'s alpha is the tone that was asked for.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        position: &Target,
        tone: &Target,
        targets: &BalanceTargets,
    ) {
        let [cover, sums, more, marks] = targets.all().map(|target| texture(&target.view));
        let cells = [targets.sums.texture.width(), targets.sums.texture.height()];
        let counted = [
            ("view", view.clone()),
            ("position", texture(&position.view)),
            ("tone", texture(&tone.view)),
            ("cover", cover.clone()),
            ("sums", sums.clone()),
        ];
        self.sums.run_groups(gpu, recorder, [cells[0].div_ceil(CELLS_PER_GROUP), cells[1]], &counted);
        self.windows.run(gpu, recorder, cells, &[("sums", sums), ("more", more.clone())]);
        self.ink.run(gpu, recorder, size_px, &[("view", view), ("cover", cover), ("more", more), ("marks", marks)]);
    }
}
