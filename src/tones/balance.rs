//! Marks whose mean ink is the tone that was asked for.
//!
//! A map of marks is even over the tile and about every place of it (`tonal_art_map`), but what a picture shows are
//! marks of two scales, of several layers and charts, cut by the land. Rows of two scales fall on each other here and
//! between each other there, and the mean of their ink goes up and down with that. So the ink is counted after all
//! marks are known, in small cells; a step of Newton's method, for the mean in a bell about each cell, says
//! how much darker or lighter to draw; and the marks are drawn again so, from what the first time left at each pixel
//! (`Cover`: how far the nearest mark reaches, and how fast it grows). It is the local histogram equalisation of
//! `tonal_art_map::equalise`, at the one tone that is asked for, on the picture. The windows are those of the marks on
//! the ground, so the step changes as slowly as these do.
//!
//! Why: `docs/decisions/ink-balance.md`.

pub mod balanced_ink;
pub mod ink_sums;
pub mod ink_windows;

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::target::Target;
use crate::style::hatching::Hatching;

/// Ink without bounds, its rise, the darkness that was asked for, and whether there is a surface.
pub const COVER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// What a cell lacks of ink, how fast it grows, its pixels.
pub const SUMS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Ink of marks, 0 to 1; what is added to the darkness.
pub const MARKS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Side of a cell for marks of their recipes' size; the bell's standard deviation is 1.6 cells, two spacings of marks.
const CELL_PX: u32 = 8;
/// Cells that may look at each other: the bell's reach, the cell itself, and what lies between two.
const REACH_CELLS: u32 = 6;

/// `Balance` in `shaders/shared/cover.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct BalanceUniform {
    cell_px: i32,
    pad_a: i32,
    pad_b: i32,
    pad_c: i32,
}

crate::gpu::shared::describe!(BalanceUniform as "Balance" in "tones/balance/balanced_ink": cell_px, pad_a, pad_b, pad_c);

/// Side of the cells in which the ink of a style's marks is counted: it grows with the largest marks.
pub fn cell_px(hatching: &Hatching) -> u32 {
    let largest = hatching.layers.iter().map(|layer| layer.size).fold(1.0, f32::max);
    CELL_PX * (largest.ceil() as u32).next_power_of_two()
}

/// How far a style's ink is balanced, in pixels: the margin of a part of a large picture.
pub fn reach_px(hatching: &Hatching) -> u32 {
    if hatching.balance { REACH_CELLS * cell_px(hatching) } else { 0 }
}

/// The pictures between the passes.
pub struct BalanceTargets {
    uniform: GrowingBuffer,
    /// What marks ink, and would if they were darker.
    pub cover: Target,
    /// Of cells.
    pub sums: Target,
    /// Of cells: added to the darkness. One texel, which stays 0, where nothing is balanced.
    pub more: Target,
    /// Ink.
    pub marks: Target,
}

impl BalanceTargets {
    /// Makes them, with cells of side `cell_px`; 0 is without. They are counted in the whole picture, so a part may see
    /// one more.
    pub fn new(gpu: &Gpu, size_px: [u32; 2], cell_px: u32) -> Self {
        let cells = if cell_px == 0 { [1, 1] } else { size_px.map(|side| side.div_ceil(cell_px) + 1) };
        let mut uniform = GrowingBuffer::new(gpu, "balance", wgpu::BufferUsages::UNIFORM);
        uniform.write(gpu, &[BalanceUniform { cell_px: cell_px.max(1) as i32, pad_a: 0, pad_b: 0, pad_c: 0 }]);
        Self {
            uniform,
            cover: Target::storage(gpu, "cover", size_px, COVER_FORMAT),
            sums: Target::storage(gpu, "ink sums", cells, SUMS_FORMAT),
            more: Target::storage(gpu, "more ink", cells, MARKS_FORMAT),
            marks: Target::storage(gpu, "marks", size_px, MARKS_FORMAT),
        }
    }

    /// `Balance`.
    pub(super) fn uniform(&self) -> wgpu::BindingResource<'_> {
        self.uniform.binding()
    }

    /// All of them.
    pub fn all(&self) -> [&Target; 4] {
        [&self.cover, &self.sums, &self.more, &self.marks]
    }
}
