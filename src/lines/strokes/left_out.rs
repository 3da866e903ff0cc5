//! Edges, segments and strokes that exceeded the limits of a frame. The passes count them; windows and commands report
//! them.

use serde::{Deserialize, Serialize};

use super::samples::SampleCounts;
use super::{COUNTS, DrawnStrokes, StrokeCounts};
use crate::gpu::async_readback::AsyncReadback;
use crate::gpu::{Gpu, GpuError, readback};

/// Numbers of edges, segments and strokes that were not drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct LeftOut {
    /// Edges beyond [`MAX_EDGES`](crate::surface::edges::MAX_EDGES).
    pub edges: u32,
    /// Segments beyond [`MAX_FRAME_SEGMENTS`](super::MAX_FRAME_SEGMENTS).
    pub segments: u32,
    /// Strokes beyond the style's budget; the shortest are left out.
    pub strokes: u32,
}

impl LeftOut {
    fn of(counts: &StrokeCounts, samples: &SampleCounts) -> Self {
        Self { edges: counts.edges_lost, segments: counts.segments_lost, strokes: samples.left_out }
    }

    /// Returns a message, or `None` if nothing was left out.
    pub(crate) fn message(self) -> Option<String> {
        let Self { edges, segments, strokes } = self;
        (self != Self::default()).then(|| {
            format!("{edges} edges, {segments} segments and {strokes} strokes exceed the limits and are not drawn")
        })
    }

    /// Logs the message as a warning.
    pub(crate) fn warn(self) {
        if let Some(text) = self.message() {
            tracing::warn!("{text}");
        }
    }

    /// Returns the larger of each number.
    #[must_use]
    pub(crate) fn most(self, other: Self) -> Self {
        Self {
            edges: self.edges.max(other.edges),
            segments: self.segments.max(other.segments),
            strokes: self.strokes.max(other.strokes),
        }
    }
}

impl DrawnStrokes<'_> {
    /// Reads back how many edges, segments and strokes the last frame left out. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub(crate) fn left_out(&self, gpu: &Gpu) -> Result<LeftOut, GpuError> {
        let Some(counts) = self.buffer(&COUNTS) else { return Ok(LeftOut::default()) };
        let counts: Vec<StrokeCounts> = readback::read_buffer(gpu, &counts.raw, 1)?;
        let samples: Vec<SampleCounts> = readback::read_buffer(gpu, &self.samples().counts.raw, 1)?;
        Ok(LeftOut::of(&counts.first().copied().unwrap_or_default(), &samples.first().copied().unwrap_or_default()))
    }
}

/// The number of strokes of a frame, and what was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StrokeNumbers {
    /// Strokes that are drawn, without those that are fading.
    pub drawn: u32,
    pub left_out: LeftOut,
}

/// The numbers of interactive frames, read back asynchronously: no frame waits for its own numbers, and a later one
/// receives them. There are none at first.
pub(crate) struct AsyncStrokeNumbers {
    readback: AsyncReadback,
    last: Option<StrokeNumbers>,
}

impl Default for AsyncStrokeNumbers {
    fn default() -> Self {
        let bytes = size_of::<StrokeCounts>() + size_of::<SampleCounts>();
        Self { readback: AsyncReadback::new(bytes as u64), last: None }
    }
}

impl AsyncStrokeNumbers {
    /// Requests the numbers of the frame that was just drawn. If it has no strokes, earlier numbers are discarded.
    pub(crate) fn request(&mut self, gpu: &Gpu, strokes: Option<DrawnStrokes<'_>>) {
        let Some((strokes, counts)) = strokes.and_then(|strokes| Some((strokes, strokes.buffer(&COUNTS)?))) else {
            self.readback.forget();
            self.last = None;
            return;
        };
        let counts = (&counts.raw, size_of::<StrokeCounts>() as u64);
        let samples = (&strokes.samples().counts.raw, size_of::<SampleCounts>() as u64);
        self.readback.request(gpu, &[counts, samples]);
    }

    /// Returns the latest numbers that have arrived.
    pub(crate) fn last(&mut self) -> Option<StrokeNumbers> {
        while let Some(bytes) = self.readback.take() {
            let (counts, samples) = bytes.split_at(size_of::<StrokeCounts>());
            let counts: StrokeCounts = bytemuck::pod_read_unaligned(counts);
            let samples: SampleCounts = bytemuck::pod_read_unaligned(samples);
            self.last = Some(StrokeNumbers { drawn: samples.strokes, left_out: LeftOut::of(&counts, &samples) });
        }
        self.last
    }
}
