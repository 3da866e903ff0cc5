//! Samples: what is drawn of strokes, and what lasts of them from frame to frame.
//!
//! Chains have points where edges of the mesh end. Here they become samples at even distances
//! (`shaders/lines/strokes/samples.wgsl`), the longest strokes first if there are more than the budget has room for
//! (`budget`, `budget_choose`, `sizes`). There are two lists of samples: one of this frame, one of the frame before.

use bytemuck::{Pod, Zeroable};

use super::chain::ChainPass;
use super::points::PointsPass;
use super::scan::{ScanPass, ScanSize, buffer};
use super::{Lists, MOST_PIECES};
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named, texture};
use crate::gpu::shared::describe;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::gpu::{Gpu, GpuError, readback};

/// Samples of a frame, at most: half a million pixels of line.
pub const MOST_SAMPLES: u32 = 1 << 18;
/// Samples are at most so far apart along a stroke: `SPACING_PX` in `shaders/shared/stroke_samples.wgsl`.
pub const SPACING_PX: f32 = 2.0;
/// How far lines grow, or shrink, at each end in a style's `fade_s`, in pixels. They grow from seeds 64 px apart
/// (`shaders/shared/stroke_samples.wgsl`), so all of a line is there after twice that time.
pub(super) const GROWTH_PX: f64 = 16.0;
/// `CLASSES` in the same file.
const CLASSES: u64 = 64;
/// Where `StrokeCounts` has the number of chains.
const CHAINS_INDEX: u32 = 2;

/// A place on a stroke.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sample {
    /// Camera-relative metres, in the frame that the list belongs to.
    pub position_m: [f32; 3],
    /// How strongly the pen is pressed: 0 nothing, 1 full.
    pub pressure: f32,
    /// On the picture.
    pub px: [f32; 2],
    /// The texture's parameter.
    pub along_px: f32,
    /// At full pressure.
    pub half_width_px: f32,
    /// Distance along the view axis.
    pub depth_m: f32,
    /// How far along the stroke it is to where drawing ends: above 0 the sample is drawn, below it is not.
    pub shown_px: f32,
    /// Whose it is; lasts across frames. Not 0. When a stroke falls into several, all of them keep it.
    pub stroke: u32,
    /// [`Sample::FIRST`], [`Sample::LAST`], [`Sample::FADING`], [`Sample::IS_CLOSED`], and the kind of edge in bits 8 on.
    pub flags: u32,
    /// How far from its own place it is held by the line before: a part of `px`.
    pub held_px: [f32; 2],
    /// Nothing.
    pub padding: [f32; 2],
}

describe!(Sample as "Sample" in "lines/strokes/samples":
    position_m, pressure, px, along_px, half_width_px, depth_m, shown_px, stroke, flags, held_px, padding);

impl Sample {
    /// The first of its stroke.
    pub const FIRST: u32 = 1;
    /// The last of its stroke.
    pub const LAST: u32 = 2;
    /// Of a stroke that is not seen any more.
    pub const FADING: u32 = 4;
    /// Of a loop: the last sample is where the first one is.
    pub const IS_CLOSED: u32 = 8;

    /// As [`Edge::kind`](super::Edge::kind): 0 a contour, 1 the border of the land, 2 a crease.
    pub fn kind(&self) -> u32 {
        self.flags >> 8
    }
}

/// What a sample found in the frame before. Only the GPU writes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Match {
    stroke: u32,
    along_px: f32,
    pressure: f32,
    sense: f32,
    toward_px: [f32; 2],
    half_width_px: f32,
    at_px: f32,
    shown_px: f32,
    padding: f32,
}

describe!(Match as "Match" in "lines/strokes/samples":
    stroke, along_px, pressure, sense, toward_px, half_width_px, at_px, shown_px, padding);

/// How many samples there are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct SampleCounts {
    /// All of the list.
    pub samples: u32,
    /// Those of this frame's chains, which come first; the others fade.
    pub fresh: u32,
    /// Strokes of this frame's chains.
    pub strokes: u32,
    /// Strokes that the budget left out.
    pub left_out: u32,
    /// Strokes that continue one of the frame before.
    pub carried: u32,
    /// The shortest class of strokes that the budget had room for, four to an octave of pixels.
    pub least_class: u32,
    /// Nothing.
    pub padding: [u32; 2],
}

describe!(SampleCounts as "SampleCounts" in "lines/strokes/samples":
    samples, fresh, strokes, left_out, carried, least_class, padding);

/// `Carry` in `shaders/shared/stroke_samples.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct CarryUniform {
    pub step_m: [f32; 3],
    pub has_history: u32,
    pub pressure_step: f32,
    pub hold: f32,
    pub growth_px: f32,
    pub capacity: u32,
    pub seed: u32,
    pub rests: u32,
    pub padding_a: u32,
    pub padding_b: u32,
    pub camera_blocks: [i32; 3],
    pub padding_c: u32,
    pub camera_rest_m: [f32; 3],
    pub padding_d: u32,
}

describe!(CarryUniform as "Carry" in "lines/strokes/samples":
    step_m, has_history, pressure_step, hold, growth_px, capacity, seed, rests, padding_a, padding_b, camera_blocks,
    padding_c, camera_rest_m, padding_d);

/// The samples of a frame.
pub struct SampleList {
    /// [`Sample`]s.
    pub samples: wgpu::Buffer,
    /// [`SampleCounts`].
    pub counts: wgpu::Buffer,
}

impl SampleList {
    fn new(gpu: &Gpu) -> Self {
        let bytes = u64::from(MOST_SAMPLES) * size_of::<Sample>() as u64;
        Self {
            samples: buffer(gpu, "stroke samples", bytes, wgpu::BufferUsages::STORAGE),
            counts: buffer(gpu, "sample counts", size_of::<SampleCounts>() as u64, wgpu::BufferUsages::STORAGE),
        }
    }

    /// Reads it back; waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<(SampleCounts, Vec<Sample>), GpuError> {
        let counts: Vec<SampleCounts> = readback::read_buffer(gpu, &self.counts, 1)?;
        let counts = counts.first().copied().unwrap_or_default();
        let samples = readback::read_buffer(gpu, &self.samples, counts.samples.min(MOST_SAMPLES) as usize)?;
        Ok((counts, samples))
    }
}

/// The passes, the lists, and what they hand to [`CarryPass`](super::carry::CarryPass).
pub struct SamplesPass {
    budget: ComputePass,
    choose: ComputePass,
    sizes: ComputePass,
    samples: ComputePass,
    size: ScanSize,
    classes: wgpu::Buffer,
    starts: wgpu::Buffer,
    matches: wgpu::Buffer,
    uniform: GrowingBuffer,
    draws: wgpu::Buffer,
    lists: [SampleList; 2],
    current: usize,
}

impl SamplesPass {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        let storage = |label, bytes| buffer(gpu, label, bytes, wgpu::BufferUsages::STORAGE);
        Self {
            budget: ComputePass::new(gpu, "lines/strokes/budget"),
            choose: ComputePass::new(gpu, "lines/strokes/budget_choose"),
            sizes: ComputePass::new(gpu, "lines/strokes/sizes"),
            samples: ComputePass::new(gpu, "lines/strokes/samples"),
            size: ScanSize::new(gpu, CHAINS_INDEX, MOST_PIECES),
            classes: storage("stroke classes", 4 * CLASSES),
            starts: storage("stroke starts", 4 * (u64::from(MOST_PIECES) + 1)),
            matches: storage("stroke matches", u64::from(MOST_SAMPLES) * size_of::<Match>() as u64),
            uniform: GrowingBuffer::new(gpu, "stroke carry", wgpu::BufferUsages::UNIFORM),
            draws: buffer(gpu, "stroke draws", 32, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT),
            lists: [SampleList::new(gpu), SampleList::new(gpu)],
            current: 0,
        }
    }

    /// Begins a frame: the list of the last one becomes the list before.
    pub(super) fn begin(&mut self, gpu: &Gpu, uniform: CarryUniform) {
        self.current = 1 - self.current;
        self.uniform.write(gpu, &[CarryUniform { capacity: uniform.capacity.clamp(2, MOST_SAMPLES), ..uniform }]);
    }

    /// The samples of this frame.
    pub fn now(&self) -> &SampleList {
        &self.lists[self.current]
    }

    /// The samples of the frame before.
    pub fn before(&self) -> &SampleList {
        &self.lists[1 - self.current]
    }

    /// Indirect draws of six vertices for each sample: at byte 0 of this frame's strokes, at 16 of those that fade.
    pub(super) fn draw_arguments(&self) -> &wgpu::Buffer {
        &self.draws
    }

    pub(super) fn draws(&self) -> Named<'_> {
        ("draws", self.draws.as_entire_binding())
    }

    pub(super) fn starts(&self) -> Named<'_> {
        ("starts", self.starts.as_entire_binding())
    }

    /// How many samples this frame has.
    pub(super) fn list(&self) -> Named<'_> {
        ("list", self.now().counts.as_entire_binding())
    }

    pub(super) fn samples(&self) -> Named<'_> {
        ("samples", self.now().samples.as_entire_binding())
    }

    /// How many samples the frame before had.
    pub(super) fn old_list(&self) -> Named<'_> {
        ("old_list", self.before().counts.as_entire_binding())
    }

    pub(super) fn old_samples(&self) -> Named<'_> {
        ("old_samples", self.before().samples.as_entire_binding())
    }

    pub(super) fn matches(&self) -> Named<'_> {
        ("matches", self.matches.as_entire_binding())
    }

    pub(super) fn carry(&self) -> Named<'_> {
        ("carry", self.uniform.binding())
    }

    /// Reads chains and points; writes the list of this frame and what each sample found in `ids` and the list of the
    /// frame before.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        lists: &Lists,
        chain: &ChainPass,
        points: &PointsPass,
        scan: &ScanPass,
        ids: &Target,
    ) {
        let along = || ("along_units", points.along().binding());
        let classes = || ("classes", self.classes.as_entire_binding());
        let (arguments, offset) = points.per_piece();

        let resources = [lists.strokes(), lists.counts(), chain.named_chains(), along(), classes()];
        self.budget.run_indirect(gpu, recorder, arguments, offset, &resources);
        self.choose.run_groups(gpu, recorder, [1, 1], &[self.carry(), classes(), self.list(), self.draws()]);
        let sizes = ("sizes", self.starts.as_entire_binding());
        let resources = [lists.strokes(), lists.counts(), chain.named_chains(), along(), self.list(), sizes];
        self.sizes.run_indirect(gpu, recorder, arguments, offset, &resources);
        scan.run(gpu, recorder, &self.size, lists.counts.buffer(), &self.starts);
        let resources = [
            ("view", view),
            lists.strokes(),
            self.carry(),
            lists.counts(),
            chain.named_chains(),
            ("points", points.list().binding()),
            along(),
            self.starts(),
            self.list(),
            self.samples(),
            self.old_samples(),
            ("ids", texture(&ids.view)),
            self.matches(),
        ];
        self.samples.run_groups(gpu, recorder, [MOST_SAMPLES.div_ceil(64), 1], &resources);
    }
}
