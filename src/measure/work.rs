//! Figures of a benchmark for the work of a frame, independent of the GPU: bytes, wgpu passes, the processor's share,
//! caches.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::statistics::{FrameRecord, Percentiles};
use crate::gpu::trace::{FrameCounts, PassBytes, PassTrace};

/// The work of a frame on the GPU. It depends on the style, the world and the picture, not on the GPU. [`trace`] defines
/// its terms.
///
/// [`trace`]: crate::gpu::trace
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FrameWork {
    /// Bytes of the textures and buffers that passes read: each resource once for each pass, as `PassBytes` counts.
    pub bytes_read: u64,
    /// Bytes of the textures and buffers that passes write, counted in the same way.
    pub bytes_written: u64,
    /// wgpu passes: compute and render passes of the API. Consecutive dispatches share one.
    #[serde(alias = "passes")]
    pub wgpu_passes: u64,
    /// Compute dispatches, direct and indirect.
    pub dispatches: u64,
    /// Draws in render passes.
    pub draws: u64,
    /// Copies between buffers, and clears of buffers.
    pub copies: u64,
    /// Number of times that work must wait for what earlier work of the frame wrote or read.
    pub barriers: u64,
}

impl FrameWork {
    /// Returns the work of a frame that was traced.
    pub(crate) fn of(trace: &[PassTrace]) -> Self {
        let mut names: Vec<&str> = trace.iter().map(|pass| pass.name).collect();
        names.sort_unstable();
        names.dedup();
        let bytes: Vec<PassBytes> = names.iter().map(|name| PassBytes::of(trace, name)).collect();
        let FrameCounts { wgpu_passes, dispatches, draws, copies, barriers } = FrameCounts::of(trace);
        Self {
            bytes_read: bytes.iter().map(|bytes| bytes.read).sum(),
            bytes_written: bytes.iter().map(|bytes| bytes.written).sum(),
            wgpu_passes: wgpu_passes.into(),
            dispatches: dispatches.into(),
            draws: draws.into(),
            copies: copies.into(),
            barriers: barriers.into(),
        }
    }

    /// Returns the bytes read and written.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes_read + self.bytes_written
    }
}

/// Times of the thread that draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct CpuTimes {
    /// Time to record the passes, in milliseconds.
    pub record: Option<Percentiles>,
    /// Time to upload uniforms and to submit, in milliseconds; null on a software driver, whose passes are submitted
    /// and waited for one by one.
    pub submit: Option<Percentiles>,
    /// Time spent waiting until the GPU has finished the frame, in milliseconds; null on a software driver.
    pub wait: Option<Percentiles>,
}

impl CpuTimes {
    /// Returns the percentiles over the frames.
    pub(crate) fn of(frames: &[FrameRecord]) -> Self {
        let of = |value: fn(&FrameRecord) -> Option<f64>| Percentiles::of(frames.iter().filter_map(value));
        Self {
            record: of(|frame| frame.record_ms),
            submit: of(|frame| frame.submit_ms),
            wait: of(|frame| frame.wait_ms),
        }
    }
}

/// Frames that were drawn again after the flight, without a timer around each pass, as a window draws them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Untimed {
    /// Number of frames, drawn once for each of the two measurements.
    pub frames: u64,
    /// Time from the beginning of a frame until the GPU has finished it, when the next frame begins after that.
    pub latency_ms: Percentiles,
    /// Mean time from one frame to the next when a frame begins while the GPU draws the one before, with at most two
    /// frames in flight.
    pub throughput_ms: f64,
    /// Median time for tiles and patches.
    pub prepare_ms: f64,
    /// Median time to record the passes.
    pub record_ms: f64,
    /// Median time to upload uniforms and to submit.
    pub submit_ms: f64,
}

/// GPU times of frames that were drawn again after the flight, with a timer around each pass, but one after the other, so
/// that the GPU is never idle. A GPU that waits for the CPU lowers its clocks, and its times say little.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct BusyGpu {
    /// Number of frames.
    pub frames: u64,
    /// Time of a whole frame on the GPU.
    pub gpu_ms: Percentiles,
    /// Median time of each pass over the frames that ran it, in milliseconds.
    pub passes_ms: BTreeMap<String, f64>,
}

/// The pipelines and times that a style's first frame waited for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Start {
    /// Number of pipelines that were compiled in the frame. Those that an earlier style of the run has compiled are
    /// shared.
    pub pipelines: u64,
    /// Time to compile them, in milliseconds, summed over all threads.
    pub compile_ms: f64,
    /// Time until the GPU had finished the frame, in milliseconds; its land may still be coarse.
    pub frame_ms: f64,
}

/// Hits and misses of a cache, over the frames of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct CacheUse {
    /// Requests that found the value in the cache.
    pub hits: u64,
    /// Requests after which it had to be made or loaded.
    pub misses: u64,
}

impl CacheUse {
    /// Returns the share of hits among the requests; `None` if there was no request.
    pub(crate) fn hit_rate(&self) -> Option<f64> {
        let requests = self.hits + self.misses;
        (requests > 0).then(|| self.hits as f64 / requests as f64)
    }
}

/// The key of the tiles on the GPU among [`Caches`]: a hit is a tile that a view begins to need and that is there.
pub(crate) const GPU_TILES: &str = "gpu_tiles";
/// The key of the decoded tiles in main memory: a hit is a tile that is uploaded without being read.
pub(crate) const CPU_TILES: &str = "cpu_tiles";

/// The caches by name.
pub(crate) type Caches = BTreeMap<String, CacheUse>;

/// Returns how a cache is called in tables, by its key in [`Caches`].
pub(crate) fn cache_label(key: &str) -> String {
    match key {
        GPU_TILES => "tiles on the GPU".to_owned(),
        CPU_TILES => "tiles in main memory".to_owned(),
        key => key.replace('_', " "),
    }
}

/// Formats a hit rate in percent. A rate below 100 % is never rounded up to it.
pub(crate) fn percent(rate: f64) -> String {
    if rate < 1.0 { format!("{:.2}", (rate * 10_000.0).floor() / 100.0) } else { "100".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_100_percent_only_if_nothing_was_missed() {
        let rate = |hits, misses| CacheUse { hits, misses }.hit_rate();
        assert_eq!(rate(0, 0), None);
        assert_eq!(rate(7, 0).map(percent), Some("100".to_owned()));
        assert_eq!(rate(999_999, 1).map(percent), Some("99.99".to_owned()));
        assert_eq!(rate(0, 3).map(percent), Some("0.00".to_owned()));
    }
}
