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

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind, Targets};
pub(crate) use crate::gpu::wgsl::shared::cover::Balance as BalanceUniform;
use crate::style::hatching::Hatching;

/// Ink without bounds, its rise, the darkness that was asked for, and whether there is a surface.
const COVER: TargetKind = TargetKind::storage("cover", wgpu::TextureFormat::Rgba16Float);
/// What a cell lacks of ink, how fast it grows, its pixels.
const SUMS: TargetKind = TargetKind::storage("ink sums", wgpu::TextureFormat::Rgba32Float);
/// What is added to the darkness of a cell.
const MORE: TargetKind = TargetKind::storage("more ink", wgpu::TextureFormat::R32Float);
/// In place of it where nothing is balanced: one texel, which stays 0.
const NO_MORE: TargetKind = TargetKind::storage("no more ink", wgpu::TextureFormat::R32Float);
/// Ink of marks, 0 to 1.
pub const MARKS: TargetKind = TargetKind::storage("marks", wgpu::TextureFormat::R32Float);

/// Side of a cell for marks of their recipes' size; the bell's standard deviation is 1.6 cells, two spacings of marks.
const CELL_PX: u32 = 8;
/// Cells that may look at each other: the bell's reach, the cell itself, and what lies between two.
const REACH_CELLS: u32 = 6;

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
#[derive(Clone)]
pub struct Inputs {
    /// `View`.
    pub view: Resource,
    /// `Balance`.
    pub balance: Resource,
    /// What marks ink, and would if they were darker.
    pub cover: Target,
    /// Of cells; none where nothing is balanced.
    pub sums: Option<Target>,
    /// Of cells: added to the darkness.
    pub more: Target,
    /// Out: ink.
    pub marks: Target,
}

impl Inputs {
    /// For the marks of a style. Cells are counted in the whole picture, so a part may see one more.
    pub fn new(recorder: &mut Recorder<'_>, targets: &mut Targets, view: &Resource, hatching: &Hatching) -> Self {
        let cell_px = if hatching.balance { cell_px(hatching) } else { 1 };
        let cells = targets.size_px().map(|side| side.div_ceil(cell_px) + 1);
        let gpu = recorder.gpu();
        let uniform = BalanceUniform { cell_px: cell_px as i32, pad_a: 0, pad_b: 0, pad_c: 0 };
        Self {
            view: view.clone(),
            balance: recorder.uniform("balance", &uniform),
            cover: targets.whole(gpu, &COVER),
            sums: hatching.balance.then(|| targets.sized(gpu, &SUMS, cells)),
            more: if hatching.balance {
                targets.sized(gpu, &MORE, cells)
            } else {
                targets.sized(gpu, &NO_MORE, [1, 1])
            },
            marks: targets.whole(gpu, &MARKS),
        }
    }
}

/// The other eye of a pair.
pub struct Partner<'a> {
    /// Its `View`.
    pub view: &'a Resource,
    /// Of the surface, as this eye sees it.
    pub position: &'a Target,
    /// What the other eye would add to the darkness.
    pub more: &'a Target,
}

/// Finds what is to be added to the darkness of [`Inputs::cover`], if the style says so.
pub fn count(recorder: &mut Recorder<'_>, inputs: &Inputs) {
    if let Some(sums) = &inputs.sums {
        ink_sums::run(recorder, inputs, sums);
        ink_windows::run(recorder, inputs, sums);
    }
}

/// Writes [`Inputs::marks`]. An eye of a pair adds the mean of what both eyes would add at the same place of the
/// surface: so marks are as dark in both.
pub fn draw(recorder: &mut Recorder<'_>, inputs: &Inputs, partner: Option<&Partner<'_>>) {
    balanced_ink::run(recorder, inputs, partner.filter(|_| inputs.sums.is_some()));
}
