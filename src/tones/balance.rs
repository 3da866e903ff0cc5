//! Ink balance: corrects the ink of hatching marks so that its local mean is the requested tone.
//!
//! A map of marks is even over the tile and around every place of it (`tonal_art_map`), but a picture shows marks of
//! two scales, of several layers and charts, cut by the land. Rows of two scales coincide in some places and interleave
//! in others, and their mean ink varies with that. So the ink is counted once all marks are known, in small cells; a
//! step of Newton's method, for the mean in a bell-shaped window around each cell, computes how much darker or lighter
//! to draw; and the marks are redrawn accordingly, from what the first pass stored at each pixel (`Cover`: how far the
//! nearest mark reaches, and how fast it grows). This is the local histogram equalisation of `tonal_art_map::equalise`,
//! at the one tone that is requested, on the picture. The windows are as wide as those of the marks on the ground, so
//! the correction varies as slowly as these do.
//!
//! Why: `docs/decisions/ink-balance.md`.

pub(crate) mod balanced_ink;
pub(crate) mod ink_sums;
pub(crate) mod ink_windows;

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind, Targets};
pub(crate) use crate::gpu::wgsl::shared::cover::Balance as BalanceUniform;
use crate::style::hatching::Hatching;

/// Unclamped ink, its derivative by darkness, the requested darkness, and whether there is a surface.
const COVER: TargetKind = TargetKind::storage(
    "cover",
    wgpu::TextureFormat::Rgba16Float,
    Group::Ink.shows("Ink of hatching marks before its balance, and the requested darkness"),
);
/// For each cell: missing ink, how fast ink grows with darkness, and the number of pixels.
const SUMS: TargetKind = TargetKind::storage(
    "ink sums",
    wgpu::TextureFormat::Rgba32Float,
    Group::Ink.shows("Ink that hatching marks lack in each block of pixels"),
);
/// For each cell: the correction that is added to the darkness.
const MORE: TargetKind = TargetKind::storage(
    "more ink",
    wgpu::TextureFormat::R32Float,
    Group::Ink.shows("Darkness that is added so that hatching marks have the requested ink"),
);
/// A replacement of [`MORE`] without balance: one texel, which stays 0.
const NO_MORE: TargetKind = TargetKind::storage(
    "no more ink",
    wgpu::TextureFormat::R32Float,
    Group::Ink.shows("One texel that stands for the balance of a style without one"),
);
/// Ink of the marks, 0 to 1.
pub(crate) const MARKS: TargetKind =
    TargetKind::storage("marks", wgpu::TextureFormat::R32Float, Group::Ink.shows("Ink of hatching marks"));

/// The targets that the passes share.
#[derive(Clone)]
pub(crate) struct Inputs {
    pub view: Resource,
    /// The `Balance` uniform.
    pub balance: Resource,
    /// Ink of the marks and its derivative by darkness.
    pub cover: Target,
    /// Sums of the cells; `None` without balance.
    pub sums: Option<Target>,
    /// The correction of the cells, which is added to the darkness.
    pub more: Target,
    /// The output: ink of the marks.
    pub marks: Target,
}

impl Inputs {
    /// Allocates the targets for the marks of a style. Cells are aligned to the whole picture, so a part of it may
    /// overlap one more cell.
    pub(crate) fn new(
        recorder: &mut Recorder<'_>,
        targets: &mut Targets,
        view: &Resource,
        hatching: &Hatching,
    ) -> Self {
        let cell_px = if hatching.balance { hatching.cell_px() } else { 1 };
        let of_picture = targets.size_px().map(|side| side.div_ceil(cell_px) + 1);
        // Without balance one cell stands for all.
        let cells = if hatching.balance { of_picture } else { [1, 1] };
        let gpu = recorder.gpu();
        let uniform = BalanceUniform { cell_px: cell_px as i32, pad: 0, cells };
        Self {
            view: view.clone(),
            balance: recorder.uniform("balance", &uniform),
            cover: targets.whole(gpu, &COVER),
            sums: hatching.balance.then(|| targets.sized(gpu, &SUMS, cells)),
            more: targets.sized(gpu, if hatching.balance { &MORE } else { &NO_MORE }, cells),
            marks: targets.whole(gpu, &MARKS),
        }
    }
}

/// The other eye of a stereo pair.
pub(crate) struct Partner<'a> {
    /// The other eye's `View`.
    pub view: &'a Resource,
    /// Position of the surface, as this eye sees it.
    pub distance: &'a Target,
    /// The correction of the other eye.
    pub more: &'a Target,
}

/// Computes the correction of the darkness of [`Inputs::cover`], if the style balances its ink.
pub(crate) fn count(recorder: &mut Recorder<'_>, inputs: &Inputs) {
    if let Some(sums) = &inputs.sums {
        ink_sums::run(recorder, inputs, sums);
        ink_windows::run(recorder, inputs, sums);
    }
}

/// Writes [`Inputs::marks`]. An eye of a stereo pair adds the mean of both eyes' corrections at the same place of the
/// surface, so that marks are equally dark in both.
pub(crate) fn draw(recorder: &mut Recorder<'_>, inputs: &Inputs, partner: Option<&Partner<'_>>) {
    balanced_ink::run(recorder, inputs, partner.filter(|_| inputs.sums.is_some()));
}
