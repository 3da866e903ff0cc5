//! Density control of lines: where lines are crowded, the least important ones are left out. A cap limits the fraction
//! of the paper that lines cover.
//!
//! Far ranges become lines on top of each other, and maps are full of speckle; a draughtsman draws the skyline and
//! leaves out the rest. Each pixel of a line has a [`mod@rank`]; the ink of each rank is counted in cells; from a
//! window of 4 × 4 cells follows the [`bar`], the rank above which there is no more ink than the style allows; and
//! [`thin`] removes lines below the bar, with a soft transition. All of these are smooth functions of the picture, also
//! between the middles of cells, so nothing jumps in a flight. The method is the density control of Grabli et al. 2010
//! (Programmable rendering of line drawing from 3D scenes, section 5.2), applied to pixels; strokes apply it to their
//! samples ([`strokes::crowd`](super::strokes::crowd)).

pub(crate) mod bar;
pub(crate) mod rank;
pub(crate) mod thin;

use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind, Targets};
use crate::gpu::wgsl::shared::crowd::CELL_WORDS;
pub(crate) use crate::gpu::wgsl::shared::crowd::Crowd as CrowdUniform;

/// Ink of each rank, for each cell.
pub(crate) const COUNTS: BufferKind = BufferKind::storage("crowd counts");
/// For each cell: the bar, and the factor of lines above it.
const BARS: TargetKind = TargetKind::storage(
    "crowd bars",
    wgpu::TextureFormat::Rgba32Float,
    Group::Lines.shows("Importance that a line needs to be drawn where lines are crowded"),
);

/// Cells along a side of the window.
const CELLS: f32 = 4.0;

/// The fraction of the paper that lines may cover, and the window in which it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cap {
    /// The largest covered fraction, 0 to 1.
    pub most: f32,
    /// Side of the window, in pixels.
    pub window_px: f32,
}

impl Cap {
    /// Returns the cap of a style's `crowd` and `crowd_px`; a `crowd` of 1 disables the cap.
    pub(crate) fn of(most: f32, window_px: f32) -> Option<Self> {
        (most < 1.0).then_some(Self { most, window_px })
    }
}

/// The cells of one eye.
#[derive(Clone)]
pub(crate) struct Cells {
    /// The `Crowd` uniform.
    pub crowd: Resource,
    pub counts: Buffer,
    /// The output of [`bar`].
    pub bars: Target,
}

impl Cells {
    /// Allocates the cells of an eye. `apart_m` is the distance to the other eye of a stereo pair; 0 if there is none.
    /// Cells are aligned to the whole picture, so a part of it may overlap one more cell.
    pub(crate) fn new(recorder: &mut Recorder<'_>, targets: &mut Targets, cap: Cap, apart_m: f32) -> Self {
        let cell_px = (cap.window_px / CELLS).round().max(1.0) as u32;
        let cells = targets.size_px().map(|side| side.div_ceil(cell_px) + 1);
        let uniform = CrowdUniform { most: cap.most, cell_px, cells, apart_m, ..CrowdUniform::default() };
        Self {
            crowd: recorder.uniform("crowd", &uniform),
            counts: recorder.buffer(&COUNTS, u64::from(cells[0]) * u64::from(cells[1]) * u64::from(4 * CELL_WORDS)),
            bars: targets.sized(recorder.gpu(), &BARS, cells),
        }
    }
}

/// Inputs of the density control.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub distance: &'a Target,
    /// Line strength: 0 no line, 1 full.
    pub line: &'a Target,
    pub cap: Cap,
    /// Distance to the other eye of a stereo pair, with which lines are to agree, in metres; 0 if there is none.
    pub apart_m: f32,
}

/// Thins the lines of an eye, and returns the remaining ones. Each eye of a stereo pair counts in the cells of its own
/// picture; of the lines that remain in both, [`agree`](super::stereo::agree) then leaves each eye the fainter one.
/// Surfaces so near that their contours differ between the eyes are not thinned.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let &Inputs { view, distance, line, cap, apart_m } = inputs;
    let cells = Cells::new(recorder, targets, cap, apart_m);
    let [rank, thinned] = [&rank::RANK, &thin::UNCROWDED].map(|kind| targets.whole(recorder.gpu(), kind));
    rank::run(recorder, &rank::Inputs { view, cells: &cells, distance, line, rank: &rank });
    bar::run(recorder, view, &cells);
    thin::run(recorder, &thin::Inputs { view, line, rank: &rank, cells: &cells, thinned: &thinned });
    thinned
}
