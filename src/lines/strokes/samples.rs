//! Samples: what is drawn of strokes, and what lasts of them from frame to frame.
//!
//! Chains have points where edges of the mesh end. Here they become samples at even distances
//! (`shaders/lines/strokes/samples.wgsl`), the longest strokes first if there are more than the budget has room for
//! (`budget`, `budget_choose`, `sizes`). There are two lists of samples: one of this frame, one of the frame before.

use super::chain::Chains;
use super::points::Points;
use super::{Lists, MOST_SEGMENTS};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::scan;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::Match;
pub use crate::gpu::wgsl::shared::stroke_samples::Sample;
pub use crate::gpu::wgsl::shared::stroke_samples::SampleCounts;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::Temporal as TemporalUniform;
use crate::gpu::{Gpu, GpuError, readback};

/// Samples of a frame, at most: half a million pixels of line.
pub const MOST_SAMPLES: u32 = 1 << 18;
/// Samples are at most so far apart along a stroke: `SPACING_PX` in `shaders/shared/stroke_samples.wgsl`.
pub const SPACING_PX: f32 = crate::gpu::wgsl::shared::stroke_samples::SPACING_PX;
/// How far lines grow, or shrink, at each end in a style's `fade_s`, in pixels. They grow from seeds 64 px apart
/// (`shaders/shared/stroke_samples.wgsl`), so all of a line is there after twice that time.
pub(super) const GROWTH_PX: f64 = 16.0;
/// `CLASSES` in the same file.
const CLASSES: u64 = crate::gpu::wgsl::shared::stroke_samples::CLASSES as u64;
/// Where `StrokeCounts` has the number of chains.
const CHAINS_INDEX: u32 = 2;

/// Workgroups of 64 for every sample.
pub(super) const GROUPS: [u32; 2] = [MOST_SAMPLES.div_ceil(64), 1];

impl Sample {
    /// The first of its stroke.
    pub const FIRST: u32 = 1;
    /// The last of its stroke.
    pub const LAST: u32 = 2;
    /// Of a stroke that is not seen any more.
    pub const FADING: u32 = 4;
    /// Of a loop: the last sample is where the first one is.
    pub const IS_CLOSED: u32 = 8;
    /// The first or last of a stroke, at the picture's border: the stroke runs on, out of it.
    pub const RUNS_OFF: u32 = 16;

    /// As [`Edge::kind`](crate::surface::edges::Edge::kind): 0 a contour, 1 the border of the land, 2 a crease.
    pub fn kind(&self) -> u32 {
        self.flags >> 8
    }
}

/// [`Sample`]s.
const SAMPLES: BufferKind = BufferKind::storage("stroke samples");
/// [`SampleCounts`].
const COUNTS: BufferKind = BufferKind::storage("sample counts");
/// How many strokes of each length there are.
const CLASSES_OF: BufferKind = BufferKind::storage("stroke classes");
/// Where each chain's samples begin.
const STARTS: BufferKind = BufferKind::storage("stroke starts");
/// What each sample found in the frame before, or in the other eye.
const MATCHES: BufferKind = BufferKind::storage("stroke matches");
/// Of [`SampleList`].
const DRAWS: BufferKind = BufferKind::indirect("stroke draws");

/// The samples of a frame.
#[derive(Clone, Debug)]
pub struct SampleList {
    /// [`Sample`]s.
    pub samples: Buffer,
    /// [`SampleCounts`].
    pub counts: Buffer,
    /// Indirect draws of six vertices for each sample: at byte 0 of this frame's strokes, at 16 of those that fade.
    pub draws: Buffer,
}

impl SampleList {
    /// An empty one.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            samples: Buffer::new(gpu, &SAMPLES, u64::from(MOST_SAMPLES) * size_of::<Sample>() as u64),
            counts: Buffer::new(gpu, &COUNTS, size_of::<SampleCounts>() as u64),
            draws: Buffer::new(gpu, &DRAWS, 32),
        }
    }

    /// Reads it back; waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<(SampleCounts, Vec<Sample>), GpuError> {
        let counts: Vec<SampleCounts> = readback::read_buffer(gpu, &self.counts.raw, 1)?;
        let counts = counts.first().copied().unwrap_or_default();
        let samples = readback::read_buffer(gpu, &self.samples.raw, counts.samples.min(MOST_SAMPLES) as usize)?;
        Ok((counts, samples))
    }
}

/// The samples of this frame and of the one before, and what the passes hand to each other.
pub struct SampleWork {
    /// Of this frame.
    pub now: SampleList,
    /// Of the frame before.
    pub before: SampleList,
    temporal: Resource,
    starts: Buffer,
    matches: Buffer,
}

impl SampleWork {
    /// For a frame.
    pub(super) fn new(recorder: &mut Recorder<'_>, [now, before]: [&SampleList; 2], uniform: TemporalUniform) -> Self {
        let uniform = TemporalUniform { capacity: uniform.capacity.clamp(2, MOST_SAMPLES), ..uniform };
        Self {
            now: now.clone(),
            before: before.clone(),
            temporal: recorder.uniform("temporal strokes", &uniform),
            starts: recorder.buffer(&STARTS, 4 * (u64::from(MOST_SEGMENTS) + 1)),
            matches: recorder.buffer(&MATCHES, u64::from(MOST_SAMPLES) * size_of::<Match>() as u64),
        }
    }

    pub(super) fn named_draws(&self) -> Named {
        ("draws", self.now.draws.binding())
    }

    pub(super) fn starts(&self) -> Named {
        ("starts", self.starts.binding())
    }

    /// How many samples this frame has.
    pub(super) fn list(&self) -> Named {
        ("list", self.now.counts.binding())
    }

    pub(super) fn samples(&self) -> Named {
        ("samples", self.now.samples.binding())
    }

    /// How many samples the frame before had.
    pub(super) fn old_list(&self) -> Named {
        ("old_list", self.before.counts.binding())
    }

    pub(super) fn old_samples(&self) -> Named {
        ("old_samples", self.before.samples.binding())
    }

    pub(super) fn matches(&self) -> Named {
        ("matches", self.matches.binding())
    }

    pub(super) fn temporal(&self) -> Named {
        ("temporal", self.temporal.clone())
    }
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface, for the steps in depth at strokes.
    pub depth: &'a Target,
    /// For the numbers of segments and chains.
    pub lists: &'a Lists,
    /// Of this frame.
    pub chains: &'a Chains,
    /// Of this frame.
    pub points: &'a Points,
    /// Out: this frame.
    pub work: &'a SampleWork,
}

/// Makes the list of this frame.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let Inputs { view, depth, lists, chains, points, work } = *inputs;
    let along = || ("along_units", points.along.binding());
    let classes = recorder.buffer(&CLASSES_OF, 4 * CLASSES);
    let classes = || ("classes", classes.binding());
    let (arguments, offset) = points.per_segment();

    let resources = [lists.strokes(), lists.counts(), chains.named(), along(), classes()];
    recorder.indirect("lines/strokes/budget", arguments, offset, &resources);
    recorder.groups(
        "lines/strokes/budget_choose",
        [1, 1],
        &[work.temporal(), classes(), work.list(), work.named_draws()],
    );
    let sizes = ("sizes", work.starts.binding());
    let resources = [lists.strokes(), lists.counts(), chains.named(), along(), work.list(), sizes];
    recorder.indirect("lines/strokes/sizes", arguments, offset, &resources);
    let numbers = &lists.counts;
    scan::run(recorder, &scan::Inputs { numbers, index: CHAINS_INDEX, capacity: MOST_SEGMENTS, values: &work.starts });
    let resources = [
        ("view", view.clone()),
        ("depth", depth.into()),
        lists.strokes(),
        work.temporal(),
        chains.named(),
        ("points", points.list.binding()),
        along(),
        work.starts(),
        work.list(),
        work.samples(),
        work.matches(),
    ];
    recorder.groups("lines/strokes/samples", GROUPS, &resources);
}
