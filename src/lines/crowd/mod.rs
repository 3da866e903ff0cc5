//! Lines that are crowded are thinned out, the least ones first: a cap for the part of the paper that they cover.
//!
//! Far ranges are lines on top of each other, and a map is full of crumbs: a draughtsman draws the skyline and leaves the
//! rest out. Each pixel of a line has a [`rank`]; ink is [`count`]ed by rank in cells; a window of four cells to a side
//! says how high the [`bar`] is above which there is no more ink than the style allows; and [`thin`] takes what is below
//! it, in a soft step. Everything is a smooth function of the picture, between the middles of cells too, so that nothing
//! jumps in a flight. It is the density control of Grabli et al. 2010 (Programmable rendering of line drawing from 3D
//! scenes, section 5.2), of pixels; strokes have it by their
//! samples ([`strokes::crowd`](super::strokes::crowd)).

pub mod bar;
pub mod count;
pub mod rank;
pub mod thin;

use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind, Targets};
use crate::gpu::wgsl::shared::crowd::CELL_WORDS;
pub(crate) use crate::gpu::wgsl::shared::crowd::Crowd as CrowdUniform;

/// For each cell the ink of each rank.
pub const COUNTS: BufferKind = BufferKind::storage("crowd counts");
/// Of cells: the bar, and what is left of lines above it.
const BARS: TargetKind = TargetKind::storage("crowd bars", wgpu::TextureFormat::Rgba32Float);

/// Cells to a side of the window.
const CELLS: f32 = 4.0;
/// How far a line's rank and its bar look, in sides of the window: half of one, a cell, and what lies between two.
const REACH: f32 = 1.25;

/// What lines may cover, and in what window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    /// The part of the paper.
    pub most: f32,
    /// Side of the window.
    pub window_px: f32,
}

impl Cap {
    /// Of a style's `crowd` and `crowd_px`; 1 is none.
    pub fn of(most: f32, window_px: f32) -> Option<Self> {
        (most < 1.0).then_some(Self { most, window_px })
    }

    /// How far around a line ink counts: the margin of a part of a large picture.
    pub fn reach_px(&self) -> u32 {
        (self.window_px * REACH).ceil() as u32
    }
}

/// The cells of an eye.
#[derive(Clone)]
pub struct Cells {
    /// `Crowd`.
    pub crowd: Resource,
    /// [`COUNTS`].
    pub counts: Buffer,
    /// Out of [`bar`].
    pub bars: Target,
}

impl Cells {
    /// For the pictures of an eye, whose partner of a pair is `apart_m` away; 0 is none. Cells are counted in the whole picture, so a part may see one more.
    pub fn new(recorder: &mut Recorder<'_>, targets: &mut Targets, cap: Cap, apart_m: f32) -> Self {
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

/// What is thinned out.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub position: &'a Target,
    /// Lines: 0 none, 1 full.
    pub line: &'a Target,
    /// What is left of them.
    pub cap: Cap,
    /// To the other eye of a pair, with which lines are to agree; 0 is none.
    pub apart_m: f32,
}

/// Thins the lines of an eye, and returns what is left. Each eye of a pair counts in cells of its own picture; of what
/// both have left, [`agree`](super::stereo::agree) then leaves each the lesser. What is so near that its contours lie
/// elsewhere for each eye is left as it is.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let &Inputs { view, position, line, cap, apart_m } = inputs;
    let cells = Cells::new(recorder, targets, cap, apart_m);
    let [rank, thinned] = [&rank::RANK, &thin::UNCROWDED].map(|kind| targets.whole(recorder.gpu(), kind));
    rank::run(recorder, &rank::Inputs { view, cells: &cells, position, line, rank: &rank });
    count::run(recorder, view, line, &rank, &cells);
    bar::run(recorder, view, &cells);
    thin::run(recorder, &thin::Inputs { view, line, rank: &rank, cells: &cells, thinned: &thinned });
    thinned
}
