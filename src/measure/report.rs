//! `report.json`: what a bench measured. What it did not measure is null, never 0.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::statistics::{FrameRecord, Percentiles, pass_names};
use crate::file::{FileError, atomic};
use crate::lines::strokes::LeftOut;

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
    /// none or temporal.
    pub antialias: String,
    /// How many were drawn.
    pub frames: u64,
    /// From the begin of a frame to its end, by the CPU's clock.
    pub frame_ms: Option<Percentiles>,
    /// A whole frame on the GPU.
    pub gpu_ms: Option<Percentiles>,
    /// Of a frame, what the frame thread spends on tiles and patches.
    pub prepare_ms: Option<Percentiles>,
    /// Frames that took more than twice the median because of streaming: without what the frame thread spent on tiles
    /// and patches beyond its median, they would not have.
    pub hitches: Option<u64>,
    /// In drawing order.
    pub passes: Vec<Pass>,
    /// At the end of the run.
    pub memory: Memory,
    /// Over the whole run.
    pub tiles: TileCounts,
    /// Of the frames' largest projected errors; without frames that were late or over budget.
    pub lod_error_px: Option<LodError>,
    /// The error that the terrain's mesh was allowed in the frames: more than what was asked for where they were over
    /// budget.
    pub allowed_error_px: Option<LodError>,
    /// Frames in which the error that was asked for takes more triangles than a frame has.
    pub over_budget_frames: Option<u64>,
    /// In the median frame.
    pub triangles: Option<u64>,
    /// In the median of the frames in which they were counted.
    pub strokes: Option<u64>,
    /// What of the strokes found no room: the most of each in a frame.
    pub strokes_left_out: Option<LeftOut>,
    /// How steady the drawing is from frame to frame: [`super::temporal::TemporalTotals::metrics`].
    pub temporal: Option<Metrics>,
    /// How well both eyes agree.
    pub stereo: Option<Metrics>,
}

/// A pass of the frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// As the profiler and `frame_passes.md` name it.
    pub name: String,
    /// Its time on the GPU in the frames that had it; null where the GPU has no timers.
    pub gpu_ms: Option<PassTime>,
    /// The frames that had it: some passes run now and then.
    pub frames: Option<u64>,
    /// Its time on the GPU by the frame, over all frames of the run, also those that did not have it.
    pub mean_ms: Option<f64>,
    /// Bytes of the pictures and buffers that it reads in a frame, each whole and once; null where no frame was traced
    /// that had it.
    pub bytes_read: Option<u64>,
    /// The same of what it writes.
    pub bytes_written: Option<u64>,
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
    /// Decoded tiles in memory.
    pub cpu_tile_bytes: Option<u64>,
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
    /// Frames in which some of the terrain was coarser than its error allows.
    pub late_frames: Option<u64>,
    /// Those among them that were drawn more than a second after the start or after a jump.
    pub late_frames_after_1s: Option<u64>,
    /// From a jump of the camera (and from the opening of the world) until nothing is late.
    pub full_detail_ms: Option<FullDetail>,
}

/// How long the terrain takes to full detail, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FullDetail {
    /// Jumps, the opening included.
    pub jumps: u64,
    /// The median.
    pub p50: f64,
    /// The longest. A jump before whose detail the next one came counts with that time.
    pub max: f64,
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
    /// The statistics of a run's frames. Memory (also that of the passes), tiles (but for the late frames), temporal
    /// and stereo are left unmeasured, for the caller to fill in.
    pub fn of_frames(style: &str, eyes: &str, frames: &[FrameRecord]) -> Self {
        let passes = pass_names(frames).into_iter().map(|name| {
            let times = frames.iter().flat_map(|frame| &frame.pass_gpu_ms).filter(|(pass, _)| pass == name);
            let times_ms: Vec<f64> = times.map(|&(_, time_ms)| time_ms).collect();
            let gpu_ms = Percentiles::of(times_ms.iter().copied());
            Pass {
                name: name.to_owned(),
                frames: gpu_ms.map(|_| times_ms.len() as u64),
                // Picoseconds are not measured, and digits that say nothing do not survive a text.
                mean_ms: gpu_ms.map(|_| (times_ms.iter().sum::<f64>() / frames.len() as f64 * 1e6).round() / 1e6),
                gpu_ms: gpu_ms.map(|Percentiles { p50, p95, p99, .. }| PassTime { p50, p95, p99 }),
                bytes_read: None,
                bytes_written: None,
            }
        });
        // A late frame makes no promise, and one over budget another.
        let punctual = frames.iter().filter(|frame| frame.late != Some(true) && frame.over_budget != Some(true));
        let lod_error_px = Percentiles::of(punctual.filter_map(|frame| frame.lod_error_px));
        let prepare_ms = Percentiles::of(frames.iter().filter_map(|frame| frame.prepare_ms));
        let percentiles =
            |values: Option<Percentiles>| values.map(|Percentiles { p50, p99, max, .. }| LodError { p50, p99, max });
        let allowed_error_px = Percentiles::of(frames.iter().filter_map(|frame| frame.allowed_error_px));
        let over_budget: Vec<bool> = frames.iter().filter_map(|frame| frame.over_budget).collect();
        let over_budget_frames =
            (!over_budget.is_empty()).then(|| over_budget.iter().filter(|&&over_budget| over_budget).count() as u64);
        let late: Vec<bool> = frames.iter().filter_map(|frame| frame.late).collect();
        let late_frames = (!late.is_empty()).then(|| late.iter().filter(|&&late| late).count() as u64);
        Self {
            style: style.to_owned(),
            eyes: eyes.to_owned(),
            frames: frames.len() as u64,
            frame_ms: Percentiles::of(frames.iter().filter_map(|frame| frame.frame_ms)),
            gpu_ms: Percentiles::of(frames.iter().filter_map(|frame| frame.gpu_ms)),
            prepare_ms,
            hitches: hitches(frames),
            passes: passes.collect(),
            tiles: TileCounts {
                late_frames,
                late_frames_after_1s: late_after_1s(frames),
                full_detail_ms: full_detail_ms(frames),
                ..TileCounts::default()
            },
            lod_error_px: percentiles(lod_error_px),
            allowed_error_px: percentiles(allowed_error_px),
            over_budget_frames,
            triangles: median(frames.iter().filter_map(|frame| frame.triangles)),
            strokes: median(frames.iter().filter_map(|frame| frame.strokes)),
            strokes_left_out: frames.iter().filter_map(|frame| frame.strokes_left_out).reduce(LeftOut::most),
            ..Self::default()
        }
    }
}

/// See [`Run::hitches`].
fn hitches(frames: &[FrameRecord]) -> Option<u64> {
    let times: Vec<(f64, f64)> = frames.iter().filter_map(|frame| Some((frame.frame_ms?, frame.prepare_ms?))).collect();
    let frame_ms = Percentiles::of(times.iter().map(|(frame_ms, _)| *frame_ms))?.p50;
    let prepare_ms = Percentiles::of(times.iter().map(|(_, prepare_ms)| *prepare_ms))?.p50;
    let is_hitch = |(whole_ms, tiles_ms): &&(f64, f64)| {
        *whole_ms > 2.0 * frame_ms && whole_ms - (tiles_ms - prepare_ms).max(0.0) <= 2.0 * frame_ms
    };
    Some(times.iter().filter(is_hitch).count() as u64)
}

/// See [`TileCounts::late_frames_after_1s`].
fn late_after_1s(frames: &[FrameRecord]) -> Option<u64> {
    let (mut since_s, mut late) = (0.0, None);
    for frame in frames {
        let (wall_s, is_late) = (frame.wall_s?, frame.late?);
        if frame.jumped == Some(true) {
            since_s = wall_s - frame.frame_ms.unwrap_or(0.0) / 1000.0;
        }
        *late.get_or_insert(0) += u64::from(is_late && wall_s - since_s > 1.0);
    }
    late
}

/// See [`TileCounts::full_detail_ms`].
fn full_detail_ms(frames: &[FrameRecord]) -> Option<FullDetail> {
    let (mut times_ms, mut since_s) = (Vec::new(), None);
    let mut last_s = 0.0;
    for frame in frames {
        let begun_s = frame.wall_s? - frame.frame_ms? / 1000.0;
        last_s = frame.wall_s?;
        if frame.jumped == Some(true) {
            times_ms.extend(since_s.map(|since_s| (begun_s - since_s) * 1000.0));
            since_s = Some(begun_s);
        }
        if frame.late == Some(false) {
            times_ms.extend(since_s.take().map(|since_s: f64| (last_s - since_s) * 1000.0));
        }
    }
    times_ms.extend(since_s.map(|since_s| (last_s - since_s) * 1000.0));
    let Percentiles { p50, max, .. } = Percentiles::of(times_ms.iter().copied())?;
    Some(FullDetail { jumps: times_ms.len() as u64, p50, max })
}

fn median(counts: impl Iterator<Item = u64>) -> Option<u64> {
    let mut counts: Vec<u64> = counts.collect();
    counts.sort_unstable();
    counts.get(counts.len().div_ceil(2).saturating_sub(1)).copied()
}

impl Report {
    /// A line for each run in which strokes found no room, or the terrain too few triangles.
    pub fn warnings(&self) -> Vec<String> {
        let strokes = |run: &Run| Some(format!("{}: in a frame up to {}", run.style, run.strokes_left_out?.told()?));
        let terrain = |run: &Run| {
            let (frames, allowed) = (run.over_budget_frames.filter(|frames| *frames > 0)?, run.allowed_error_px?);
            let (style, of, most) = (&run.style, run.frames, allowed.max);
            Some(format!(
                "{style}: {frames} of {of} frames were over the triangle budget; their allowed error rose to {most:.2} px"
            ))
        };
        self.runs.iter().flat_map(|run| [strokes(run), terrain(run)]).flatten().collect()
    }

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
