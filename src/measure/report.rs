//! `report.json`: what a bench measured. What it did not measure is null, never 0.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::statistics::{FrameRecord, Percentiles, pass_names};
use crate::file::{FileError, atomic};

/// Named numbers; names carry their units.
pub type Metrics = BTreeMap<String, Option<f64>>;

/// The whole report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The GPU and its driver.
    pub adapter: String,
    /// Width and height of the pictures, in pixels.
    pub size: [u32; 2],
    /// What was flown over.
    pub world: WorldSize,
    /// One for each style and setting.
    pub runs: Vec<Run>,
}

/// How large the world is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldSize {
    /// The number of height samples at full resolution; null where the heights are computed.
    pub samples: Option<u64>,
    /// East and north, in metres.
    pub extent_m: [f64; 2],
}

/// One flight with one style.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The name of the style.
    pub style: String,
    /// mono, side-by-side or anaglyph.
    pub eyes: String,
    /// How many were drawn.
    pub frames: u64,
    /// From the begin of a frame to its end, by the CPU's clock.
    pub frame_ms: Option<Percentiles>,
    /// A whole frame on the GPU.
    pub gpu_ms: Option<Percentiles>,
    /// In drawing order.
    pub passes: Vec<Pass>,
    /// At the end of the run.
    pub memory: Memory,
    /// Over the whole run.
    pub tiles: TileCounts,
    /// Of the frames' largest projected errors.
    pub lod_error_px: Option<LodError>,
    /// In the median frame.
    pub triangles: Option<u64>,
    /// In the median frame.
    pub strokes: Option<u64>,
    /// How steady the drawing is from frame to frame.
    pub temporal: Option<Metrics>,
    /// How well both eyes agree.
    pub stereo: Option<Metrics>,
}

/// A pass of the frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// As the profiler and `frame_passes.md` name it.
    pub name: String,
    /// Its time on the GPU; null where the GPU has no timers.
    pub gpu_ms: Option<PassTime>,
}

/// Percentiles of a pass's time, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassTime {
    /// The median.
    pub p50: f64,
    /// 95 % of the frames took at most this.
    pub p95: f64,
    /// 99 % of the frames took at most this.
    pub p99: f64,
}

/// What is held, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Buffers and textures on the GPU.
    pub gpu_bytes: Option<u64>,
    /// The tiles that are held on the GPU: the used part of the room that `gpu_bytes` has for them.
    pub tile_cache_bytes: Option<u64>,
    /// The whole process, resident: [`super::memory::rss_bytes`].
    pub rss_bytes: Option<u64>,
}

/// What became of the tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TileCounts {
    /// Read and brought to the GPU.
    pub loaded: Option<u64>,
    /// Given up for others.
    pub evicted: Option<u64>,
    /// No longer wanted before they were there.
    pub cancelled: Option<u64>,
    /// Not readable.
    pub failed: Option<u64>,
    /// Frames that were drawn while tiles that they wanted were on their way.
    pub late_frames: Option<u64>,
}

/// Percentiles of the level-of-detail error, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LodError {
    /// The median.
    pub p50: f64,
    /// 99 % of the frames have at most this.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Run {
    /// The statistics of a run's frames. Memory, tiles (but for the late frames), temporal and stereo are left
    /// unmeasured, for the caller to fill in.
    pub fn of_frames(style: &str, eyes: &str, frames: &[FrameRecord]) -> Self {
        let passes = pass_names(frames).into_iter().map(|name| {
            let times_ms = frames.iter().flat_map(|frame| &frame.pass_gpu_ms).filter(|(pass, _)| pass == name);
            let gpu_ms = Percentiles::of(times_ms.map(|&(_, time_ms)| time_ms));
            Pass {
                name: name.to_owned(),
                gpu_ms: gpu_ms.map(|Percentiles { p50, p95, p99, .. }| PassTime { p50, p95, p99 }),
            }
        });
        let lod_error_px = Percentiles::of(frames.iter().filter_map(|frame| frame.lod_error_px));
        let late: Vec<bool> = frames.iter().filter_map(|frame| frame.late).collect();
        let late_frames = (!late.is_empty()).then(|| late.iter().filter(|&&late| late).count() as u64);
        Self {
            style: style.to_owned(),
            eyes: eyes.to_owned(),
            frames: frames.len() as u64,
            frame_ms: Percentiles::of(frames.iter().filter_map(|frame| frame.frame_ms)),
            gpu_ms: Percentiles::of(frames.iter().filter_map(|frame| frame.gpu_ms)),
            passes: passes.collect(),
            tiles: TileCounts { late_frames, ..TileCounts::default() },
            lod_error_px: lod_error_px.map(|Percentiles { p50, p99, max, .. }| LodError { p50, p99, max }),
            triangles: median(frames.iter().filter_map(|frame| frame.triangles)),
            strokes: median(frames.iter().filter_map(|frame| frame.strokes)),
            ..Self::default()
        }
    }
}

fn median(counts: impl Iterator<Item = u64>) -> Option<u64> {
    let mut counts: Vec<u64> = counts.collect();
    counts.sort_unstable();
    counts.get(counts.len().div_ceil(2).saturating_sub(1)).copied()
}

impl Report {
    /// Writes `report.json`, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_json(&self, path: &Path) -> Result<(), FileError> {
        let mut json = serde_json::to_vec_pretty(self).map_err(|error| FileError::write(path, error))?;
        json.push(b'\n');
        atomic::write(path, &json).map_err(|error| FileError::write(path, error))
    }
}
