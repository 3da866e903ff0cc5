//! What found no room in a frame: counted by the passes, told by whoever shows their pictures.

use serde::{Deserialize, Serialize};

use super::samples::SampleCounts;
use super::{COUNTS, DrawnStrokes, StrokeCounts};
use crate::gpu::async_readback::AsyncReadback;
use crate::gpu::{Gpu, GpuError, readback};

/// What found no room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Of [`MOST_EDGES`](crate::surface::edges::MOST_EDGES).
    pub edges: u32,
    /// Of [`MOST_SEGMENTS`](super::MOST_SEGMENTS).
    pub segments: u32,
    /// Of the style's budget, the shortest.
    pub strokes: u32,
}

impl LeftOut {
    fn of(counts: &StrokeCounts, samples: &SampleCounts) -> Self {
        Self { edges: counts.edges_lost, segments: counts.segments_lost, strokes: samples.left_out }
    }

    /// In words; none where everything had room.
    pub fn told(self) -> Option<String> {
        let Self { edges, segments, strokes } = self;
        (self != Self::default()).then(|| {
            format!("{edges} edges, {segments} segments and {strokes} strokes found no room: they are missing")
        })
    }

    /// Says so in the log.
    pub fn warn(self) {
        if let Some(text) = self.told() {
            tracing::warn!("{text}");
        }
    }

    /// The larger of each number.
    #[must_use]
    pub fn most(self, other: Self) -> Self {
        Self {
            edges: self.edges.max(other.edges),
            segments: self.segments.max(other.segments),
            strokes: self.strokes.max(other.strokes),
        }
    }
}

impl DrawnStrokes<'_> {
    /// What found no room in the last frame: edges, segments of edges, and the strokes that the budget left out. Waits
    /// for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub fn left_out(&self, gpu: &Gpu) -> Result<LeftOut, GpuError> {
        let Some(counts) = self.buffer(&COUNTS) else { return Ok(LeftOut::default()) };
        let counts: Vec<StrokeCounts> = readback::read_buffer(gpu, &counts.raw, 1)?;
        let samples: Vec<SampleCounts> = readback::read_buffer(gpu, &self.samples().counts.raw, 1)?;
        Ok(LeftOut::of(&counts.first().copied().unwrap_or_default(), &samples.first().copied().unwrap_or_default()))
    }
}

/// How many strokes a frame has, and what it left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StrokeNumbers {
    /// Without those that only fade.
    pub drawn: u32,
    /// What found no room.
    pub left_out: LeftOut,
}

/// The numbers of frames that are shown as they come: no frame waits for its own, a later one finds them. At first
/// there are none.
pub struct NumbersLater {
    later: AsyncReadback,
    last: Option<StrokeNumbers>,
}

impl Default for NumbersLater {
    fn default() -> Self {
        let bytes = size_of::<StrokeCounts>() + size_of::<SampleCounts>();
        Self { later: AsyncReadback::new(bytes as u64), last: None }
    }
}

impl NumbersLater {
    /// Asks for the numbers of the frame that was just drawn; without strokes there are none.
    pub fn ask(&mut self, gpu: &Gpu, strokes: Option<DrawnStrokes<'_>>) {
        let Some((strokes, counts)) = strokes.and_then(|strokes| Some((strokes, strokes.buffer(&COUNTS)?))) else {
            self.later.forget();
            self.last = None;
            return;
        };
        let counts = (&counts.raw, size_of::<StrokeCounts>() as u64);
        let samples = (&strokes.samples().counts.raw, size_of::<SampleCounts>() as u64);
        self.later.ask(gpu, &[counts, samples]);
    }

    /// The newest that have come.
    pub fn last(&mut self) -> Option<StrokeNumbers> {
        while let Some(bytes) = self.later.take() {
            let (counts, samples) = bytes.split_at(size_of::<StrokeCounts>());
            let counts: StrokeCounts = bytemuck::pod_read_unaligned(counts);
            let samples: SampleCounts = bytemuck::pod_read_unaligned(samples);
            self.last = Some(StrokeNumbers { drawn: samples.strokes, left_out: LeftOut::of(&counts, &samples) });
        }
        self.last
    }
}
