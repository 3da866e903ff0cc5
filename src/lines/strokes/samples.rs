//! Samples: the points along strokes that are drawn and carried from frame to frame.
//!
//! The points of a chain are where edges of the mesh end. Here they are resampled at even distances
//! (`shaders/lines/strokes/samples.wgsl`); if there are more than the budget allows, the longest strokes come first
//! (`budget`, `sizes`). There are two lists of samples: one of this frame, one of the previous frame.

use super::chain::Chains;
use super::points::Points;
use super::{Lists, MAX_FRAME_SEGMENTS};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{self, Count};
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::Match;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::Sample;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::SampleCounts;
pub(crate) use crate::gpu::wgsl::shared::stroke_samples::Temporal as TemporalUniform;
use crate::gpu::{Gpu, GpuError, readback};

/// Largest number of samples of a frame: half a million pixels of line.
pub(crate) const MAX_SAMPLES: u32 = 1 << 18;
/// Largest distance between samples along a stroke, in pixels: `SPACING_PX` in `shaders/shared/stroke_samples.wgsl`.
pub(crate) const SPACING_PX: f32 = crate::gpu::wgsl::shared::stroke_samples::SPACING_PX;
/// How far lines grow, or shrink, at each end in a style's `fade_s`, in pixels. They grow from seeds 64 px apart
/// (`shaders/shared/stroke_samples.wgsl`), so a whole line is visible after twice that time.
pub(super) const GROWTH_PX: f64 = 16.0;
/// `CLASSES` in `shaders/shared/stroke_samples.wgsl`.
const CLASSES: u64 = crate::gpu::wgsl::shared::stroke_samples::CLASSES as u64;
/// Index of the number of chains in `StrokeCounts`.
const CHAINS_INDEX: u32 = 2;

/// Offsets in bytes of the numbers of workgroups in [`SampleList::draws`]: for the samples of this frame, and for these
/// and the fading ones. A thread for each sample that the list could hold would be several times as slow on a software
/// driver, where a thread without a sample costs as much as one that has one.
const FRESH_GROUPS: u64 = 32;
const ALL_GROUPS: u64 = 4 * crate::gpu::wgsl::shared::stroke_samples::ALL_GROUPS as u64;

impl Sample {
    /// Flag of the first sample of a stroke.
    pub(crate) const FIRST: u32 = 1;
    /// Flag of the last sample of a stroke.
    pub(crate) const LAST: u32 = 2;
    /// Flag of a stroke that has disappeared and fades out.
    pub(crate) const FADING: u32 = 4;
    /// Flag of a loop: the last sample coincides with the first one.
    pub(crate) const IS_CLOSED: u32 = 8;
    /// Flag of the first or last sample of a stroke that continues beyond the picture's border.
    pub(crate) const RUNS_OFF: u32 = 16;

    /// Returns the kind of edge, as in [`Edge::kind`](crate::surface::edges::Edge::kind): 0 is a contour, 1 a border of
    /// the land, 2 a crease.
    pub(crate) fn kind(&self) -> u32 {
        self.flags >> 8
    }
}

/// Samples of all strokes, equally spaced, one stroke after another: [`Sample`]s.
const SAMPLES: BufferKind = BufferKind::storage("stroke samples");
const COUNTS: BufferKind = BufferKind::storage("sample counts");
/// Number of strokes in each length class.
const CLASSES_OF: BufferKind = BufferKind::storage("stroke classes");
/// Index of the first sample of each chain.
const STARTS: BufferKind = BufferKind::storage("stroke starts");
/// The sample that each sample matched in the previous frame, or in the other eye.
const MATCHES: BufferKind = BufferKind::storage("stroke matches");
/// Arguments of the draws and dispatches of a [`SampleList`].
const DRAWS: BufferKind = BufferKind::indirect("stroke draws");

/// The samples of one frame.
#[derive(Clone, Debug)]
pub(crate) struct SampleList {
    /// [`Sample`]s, one stroke after another.
    pub samples: Buffer,
    /// [`SampleCounts`].
    pub counts: Buffer,
    /// Arguments of indirect draws of six vertices per sample: this frame's strokes at byte 0, fading strokes at byte
    /// 16. After them, the workgroups of dispatches with one thread per sample.
    pub draws: Buffer,
}

impl SampleList {
    /// Allocates an empty list.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            samples: Buffer::new(gpu, &SAMPLES, u64::from(MAX_SAMPLES) * size_of::<Sample>() as u64),
            counts: Buffer::new(gpu, &COUNTS, size_of::<SampleCounts>() as u64),
            draws: Buffer::new(gpu, &DRAWS, 64),
        }
    }

    /// Reads the list back; waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<(SampleCounts, Vec<Sample>), GpuError> {
        let counts: Vec<SampleCounts> = readback::read_buffer(gpu, &self.counts.raw, 1)?;
        let counts = counts.first().copied().unwrap_or_default();
        let samples = readback::read_buffer(gpu, &self.samples.raw, counts.samples.min(MAX_SAMPLES) as usize)?;
        Ok((counts, samples))
    }
}

/// The samples of this frame and of the previous one, and the buffers that the passes share.
pub(crate) struct SampleWork {
    /// Samples of this frame.
    pub now: SampleList,
    /// Samples of the previous frame.
    pub before: SampleList,
    temporal: Resource,
    starts: Buffer,
    matches: Buffer,
}

impl SampleWork {
    /// Creates the shared buffers of a frame.
    pub(super) fn new(recorder: &mut Recorder<'_>, [now, before]: [&SampleList; 2], uniform: TemporalUniform) -> Self {
        let uniform = TemporalUniform { capacity: uniform.capacity.clamp(2, MAX_SAMPLES), ..uniform };
        Self {
            now: now.clone(),
            before: before.clone(),
            temporal: recorder.uniform("temporal strokes", &uniform),
            starts: recorder.buffer(&STARTS, 4 * (u64::from(MAX_FRAME_SEGMENTS) + 1)),
            matches: recorder.buffer(&MATCHES, u64::from(MAX_SAMPLES) * size_of::<Match>() as u64),
        }
    }

    /// Returns the arguments of a dispatch with one thread per sample of this frame, fading ones left out.
    pub(super) fn per_fresh(&self) -> (&Buffer, u64) {
        (&self.now.draws, FRESH_GROUPS)
    }

    /// Returns the arguments of a dispatch with one thread per sample of the previous frame. There are no workgroups if
    /// there was no frame.
    pub(super) fn per_old(&self) -> (&Buffer, u64) {
        (&self.before.draws, ALL_GROUPS)
    }

    pub(super) fn named_draws(&self) -> Named {
        ("draws", self.now.draws.binding())
    }

    pub(super) fn starts(&self) -> Named {
        ("starts", self.starts.binding())
    }

    /// Returns the binding of this frame's sample counts.
    pub(super) fn sample_counts(&self) -> Named {
        ("sample_counts", self.now.counts.binding())
    }

    pub(super) fn samples(&self) -> Named {
        ("samples", self.now.samples.binding())
    }

    /// Returns the binding of the previous frame's sample counts.
    pub(super) fn old_sample_counts(&self) -> Named {
        ("old_sample_counts", self.before.counts.binding())
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

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Depth of the surface, for the steps in depth at strokes.
    pub depth: &'a Target,
    /// The reference image, for the lines at the ends of strokes.
    pub ids: &'a Target,
    /// The lists, for the numbers of segments and chains.
    pub lists: &'a Lists,
    /// The chains of this frame.
    pub chains: &'a Chains,
    /// The points of this frame.
    pub points: &'a Points,
    /// The output: this frame's list is written.
    pub work: &'a SampleWork,
}

/// Computes the samples of this frame.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let Inputs { view, depth, ids, lists, chains, points, work } = *inputs;
    let along = || ("along_units", points.along.binding());
    let classes = recorder.buffer(&CLASSES_OF, 4 * CLASSES);
    let classes = || ("classes", classes.binding());
    let (arguments, offset) = chains.per_segment();

    let resources = [
        lists.strokes(),
        lists.counts(),
        chains.named(),
        along(),
        classes(),
        work.sample_counts(),
        ("sizes", work.starts.binding()),
        ("points", points.list.binding()),
        ("depth", depth.into()),
        ("ids", ids.into()),
    ];
    recorder.indirect("lines/strokes/budget", arguments, offset, &resources);
    let resources = [
        lists.strokes(),
        work.temporal(),
        lists.counts(),
        chains.named(),
        along(),
        classes(),
        work.sample_counts(),
        work.named_draws(),
        ("sizes", work.starts.binding()),
    ];
    recorder.indirect("lines/strokes/sizes", arguments, offset, &resources);
    let (numbers, capacity) = (&lists.counts, MAX_FRAME_SEGMENTS);
    scan::run(recorder, Count::Counted { numbers, index: CHAINS_INDEX, capacity }, &work.starts);
    let resources = [
        ("view", view.clone()),
        ("depth", depth.into()),
        lists.strokes(),
        work.temporal(),
        chains.named(),
        ("points", points.list.binding()),
        along(),
        work.starts(),
        work.sample_counts(),
        work.samples(),
        work.matches(),
        classes(),
    ];
    let (arguments, offset) = work.per_fresh();
    recorder.indirect("lines/strokes/samples", arguments, offset, &resources);
}
