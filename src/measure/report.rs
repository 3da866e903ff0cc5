//! `report.json`: the results of a benchmark. A value that was not measured is null, never 0.
//!
//! Scripts read this file: a field that is renamed here keeps its key by `#[serde(rename)]`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::comparison::Comparison;
use super::governed::GovernedRun;
use super::settings::Settings;
use super::statistics::{FrameRecord, Percentiles, pass_names};
use super::work::{BusyGpu, Caches, CpuTimes, FrameWork, Start, Untimed};
use crate::file::unnamed::head;
use crate::file::{FileError, atomic};
use crate::lines::strokes::LeftOut;

/// Named numbers; the names include their units.
pub(crate) type Metrics = BTreeMap<String, Option<f64>>;

/// The results of a benchmark, the content of `report.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Report {
    /// The GPU and its driver.
    pub adapter: String,
    /// Width and height of the pictures.
    #[serde(rename = "size")]
    pub size_px: [u32; 2],
    /// Size of the world.
    pub world: WorldSize,
    /// Whether the GPU is the processor: its times say nothing about a GPU.
    #[serde(default)]
    pub is_software: bool,
    /// How the report was made; null in reports of earlier versions.
    #[serde(default)]
    pub settings: Option<Settings>,
    /// One run for each style.
    pub runs: Vec<Run>,
    /// Changes since an earlier report, if there is one to compare with.
    #[serde(default)]
    pub comparison: Option<Comparison>,
}

/// The size of a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WorldSize {
    /// Number of height samples at full resolution.
    pub samples: u64,
    /// Extent to the east and to the north, in metres.
    pub extent_m: [f64; 2],
}

/// One flight along the camera path with one style.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    /// Name of the style.
    pub style: String,
    /// The value of `--eyes`: `mono`, `left`, `right`, `side-by-side`, `anaglyph` or `grey-anaglyph`.
    pub eyes: String,
    /// `none` or `temporal`.
    pub antialias: String,
    /// Number of frames drawn.
    pub frames: u64,
    /// Time from the beginning of a frame to its end, by the CPU's clock.
    pub frame_ms: Option<Percentiles>,
    /// Time of a whole frame on the GPU.
    pub gpu_ms: Option<Percentiles>,
    /// Time per frame that the frame thread spends on tiles and patches.
    pub prepare_ms: Option<Percentiles>,
    /// Time per frame that the frame thread takes to record and submit passes, with a timer around each, and to wait.
    #[serde(default)]
    pub cpu_ms: CpuTimes,
    /// Work of a frame on the GPU: of the frames that were traced (the last ones of the flight, drawn once more), the one
    /// that moved most bytes.
    pub work: Option<FrameWork>,
    /// Mean bytes that a frame of a flight reads and writes, over several places of the path: the cost of a setting where
    /// times say nothing. Null without `--sweep`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flight_bytes: Option<u64>,
    /// Frames without a timer around each pass.
    pub untimed: Option<Untimed>,
    /// GPU times of frames that follow each other without a pause; null on a software driver.
    #[serde(default)]
    pub busy: Option<BusyGpu>,
    /// Pipelines and times that the first frame waited for.
    pub start: Option<Start>,
    /// Hits and misses of each cache.
    #[serde(default)]
    pub caches: Caches,
    /// Number of frames that took more than twice the median, and would not have if the frame thread had spent the
    /// median time on tiles and patches.
    pub hitches: Option<u64>,
    /// Passes in drawing order, each by the name of its shader. `work.wgpu_passes` counts other passes, those of the API.
    pub passes: Vec<Pass>,
    /// Memory at the end of the run.
    pub memory: Memory,
    /// Tiles over the whole run.
    pub tiles: TileCounts,
    /// Percentiles of the frames' largest projected errors, without late frames ([`FrameRecord::late`]) and frames over
    /// budget ([`FrameRecord::over_budget`]).
    pub lod_error_px: Option<ErrorPercentiles>,
    /// Percentiles of the error that the terrain's mesh was allowed: more than requested in frames over budget.
    pub allowed_error_px: Option<ErrorPercentiles>,
    /// Number of frames over budget: the requested error needs more triangles than a frame may have.
    pub over_budget_frames: Option<u64>,
    /// Median number of triangles in a frame; of an even number of frames, the lower middle one.
    pub triangles: Option<u64>,
    /// Median number of strokes, over the frames in which they were counted; of an even number, the lower middle one.
    pub strokes: Option<u64>,
    /// Largest numbers of edges, segments and strokes that were left out of a frame for lack of room.
    pub strokes_left_out: Option<LeftOut>,
    /// Steadiness from frame to frame: [`super::temporal::TemporalTotals::metrics`].
    pub temporal: Option<Metrics>,
    /// Agreement of the two eyes: [`super::stereo::StereoTotals::metrics`].
    pub stereo: Option<Metrics>,
    /// The values of `--sweep` with which the style was drawn, by their keys; empty for the style as it is.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub setting: BTreeMap<String, String>,
    /// Exactness against a converged reference: [`super::exactness::ExactnessTotals::metrics`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exactness: Option<Metrics>,
    /// How a governor held the budget; null without `--budget`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub governed: Option<GovernedRun>,
    /// Whether no other setting of the style is better in one respect and as good in all ([`super::trade`]); null without
    /// `--sweep`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub is_on_front: Option<bool>,
}

/// A pass of the frame: all runs of a named shader.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pass {
    /// Name, as in the profiler and `src/frame_passes.md`.
    pub name: String,
    /// GPU time in the frames that ran it; null if the GPU has no timestamp queries.
    pub gpu_ms: Option<PassTime>,
    /// Number of frames that ran it: some passes do not run in every frame.
    pub frames: Option<u64>,
    /// Mean GPU time per frame, over all frames of the run, including those without the pass.
    pub mean_ms: Option<f64>,
    /// Bytes of the textures and buffers that it reads in a frame, each resource once: a picture whole, a list as far as
    /// the frame filled it, an atlas with the tiles that the view needs. Null if no frame with it was traced.
    pub bytes_read: Option<u64>,
    /// Bytes of the textures and buffers that it writes, counted in the same way.
    pub bytes_written: Option<u64>,
    /// Number of times that it runs in a frame: its dispatches, or its render passes.
    pub runs: Option<u64>,
}

/// Percentiles of a pass's time, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassTime {
    /// Median time of the pass.
    pub p50: f64,
    /// The time that 95 % of the frames do not exceed.
    pub p95: f64,
    /// The time that 99 % of the frames do not exceed.
    pub p99: f64,
}

/// Memory in use, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Memory {
    /// Buffers and textures on the GPU.
    pub gpu_bytes: Option<u64>,
    /// Pictures and buffers that the passes of a frame bind, blocks of rows of hachures, and the maps of tiles that shadows
    /// and water require, without
    /// the tiles of the land: the memory that the style needs at this size. Of the traced frames, the one with most counts. Unlike `gpu_bytes` it depends neither on the
    /// GPU nor on the other styles of the run; what styles share counts for each of them.
    #[serde(default)]
    pub drawing_bytes: Option<u64>,
    /// Heights of the tiles that are on the GPU; `gpu_bytes` includes the free slots too.
    #[serde(rename = "tile_cache_bytes")]
    pub gpu_tile_bytes: Option<u64>,
    /// Decoded tiles in main memory.
    pub cpu_tile_bytes: Option<u64>,
    /// Resident memory of the process: [`super::memory::rss_bytes`].
    pub rss_bytes: Option<u64>,
}

/// Counts of tiles, counts of late frames, and the time until full detail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct TileCounts {
    /// Tiles read and uploaded to the GPU.
    pub loaded: Option<u64>,
    /// Tiles on the GPU that were replaced by others.
    pub evicted: Option<u64>,
    /// Tiles no longer wanted before they arrived.
    pub cancelled: Option<u64>,
    /// Tiles that could not be read.
    pub failed: Option<u64>,
    /// Late frames: some terrain was coarser than its allowed error, because tiles were still loading.
    pub late_frames: Option<u64>,
    /// Late frames that ended more than a second after the start of the run and after the latest jump of the camera.
    pub late_frames_after_1s: Option<u64>,
    /// Time from a jump of the camera ([`FrameRecord::jumped`]) to the end of the first frame that is not late.
    pub full_detail_ms: Option<FullDetail>,
    /// Largest factor by which the surface was coarser than requested because its tiles did not fit into the memory for
    /// tiles; 1 if they always fit ([`FrameRecord::memory_factor`]).
    pub memory_factor: Option<f64>,
}

/// Time until the terrain has full detail, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FullDetail {
    /// Number of jumps in the recorded frames.
    pub jumps: u64,
    /// Median of the times after the jumps.
    pub p50: f64,
    /// Longest time. A jump that is followed by the next one before full detail counts with the time between them.
    pub max: f64,
}

/// Percentiles of an error of the terrain's mesh, measured or allowed, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ErrorPercentiles {
    /// Median of the errors of the frames.
    pub p50: f64,
    /// The error that 99 % of the frames do not exceed.
    pub p99: f64,
    /// Largest error of a frame.
    pub max: f64,
}

impl Run {
    /// Computes the statistics of a run's frames. Memory (also that of passes), tiles (except late frames), `temporal`
    /// and `stereo` are left unmeasured, for the caller to fill in.
    pub(crate) fn of_frames(style: &str, eyes: &str, frames: &[FrameRecord]) -> Self {
        let passes = pass_names(frames).into_iter().map(|name| {
            let times = frames.iter().flat_map(|frame| &frame.pass_gpu_ms).filter(|(pass, _)| pass == name);
            let times_ms: Vec<f64> = times.map(|&(_, time_ms)| time_ms).collect();
            let gpu_ms = Percentiles::of(times_ms.iter().copied());
            Pass {
                name: name.to_owned(),
                frames: gpu_ms.map(|_| times_ms.len() as u64),
                // Picoseconds are beyond the timer's precision, and meaningless digits do not survive a round trip
                // through text.
                mean_ms: gpu_ms.map(|_| (times_ms.iter().sum::<f64>() / frames.len() as f64 * 1e6).round() / 1e6),
                gpu_ms: gpu_ms.map(|Percentiles { p50, p95, p99, .. }| PassTime { p50, p95, p99 }),
                bytes_read: None,
                bytes_written: None,
                runs: None,
            }
        });
        // Frames that are late or over budget exceed the requested error.
        let on_time = frames.iter().filter(|frame| frame.late != Some(true) && frame.over_budget != Some(true));
        let lod_error_px = Percentiles::of(on_time.filter_map(|frame| frame.lod_error_px));
        let prepare_ms = Percentiles::of(frames.iter().filter_map(|frame| frame.prepare_ms));
        let percentiles = |values: Option<Percentiles>| {
            values.map(|Percentiles { p50, p99, max, .. }| ErrorPercentiles { p50, p99, max })
        };
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
            cpu_ms: CpuTimes::of(frames),
            work: frames.iter().filter_map(|frame| frame.work).max_by_key(FrameWork::bytes),
            hitches: hitches(frames),
            passes: passes.collect(),
            tiles: TileCounts {
                late_frames,
                late_frames_after_1s: late_after_1s(frames),
                full_detail_ms: full_detail_ms(frames),
                memory_factor: frames.iter().filter_map(|frame| frame.memory_factor).reduce(f64::max),
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

/// Counts the frames that took more than twice the median because of streaming ([`Run::hitches`]).
fn hitches(frames: &[FrameRecord]) -> Option<u64> {
    let times: Vec<(f64, f64)> = frames.iter().filter_map(|frame| Some((frame.frame_ms?, frame.prepare_ms?))).collect();
    let frame_ms = Percentiles::of(times.iter().map(|(frame_ms, _)| *frame_ms))?.p50;
    let prepare_ms = Percentiles::of(times.iter().map(|(_, prepare_ms)| *prepare_ms))?.p50;
    let is_hitch = |(whole_ms, tiles_ms): &&(f64, f64)| {
        *whole_ms > 2.0 * frame_ms && whole_ms - (tiles_ms - prepare_ms).max(0.0) <= 2.0 * frame_ms
    };
    Some(times.iter().filter(is_hitch).count() as u64)
}

/// Counts the late frames more than 1 s after the start or a jump ([`TileCounts::late_frames_after_1s`]).
fn late_after_1s(frames: &[FrameRecord]) -> Option<u64> {
    let (mut jump_s, mut late) = (0.0, None);
    for frame in frames {
        let (wall_s, is_late) = (frame.wall_s?, frame.late?);
        if frame.jumped == Some(true) {
            jump_s = wall_s - frame.frame_ms.unwrap_or(0.0) / 1000.0;
        }
        *late.get_or_insert(0) += u64::from(is_late && wall_s - jump_s > 1.0);
    }
    late
}

/// Returns the times from a jump of the camera until no frame is late ([`TileCounts::full_detail_ms`]).
fn full_detail_ms(frames: &[FrameRecord]) -> Option<FullDetail> {
    let (mut times_ms, mut since_s) = (Vec::new(), None);
    let mut last_s = 0.0;
    for frame in frames {
        let start_s = frame.wall_s? - frame.frame_ms? / 1000.0;
        last_s = frame.wall_s?;
        if frame.jumped == Some(true) {
            times_ms.extend(since_s.map(|since_s| (start_s - since_s) * 1000.0));
            since_s = Some(start_s);
        }
        if frame.late == Some(false) {
            times_ms.extend(since_s.take().map(|since_s: f64| (last_s - since_s) * 1000.0));
        }
    }
    times_ms.extend(since_s.map(|since_s| (last_s - since_s) * 1000.0));
    let Percentiles { p50, max, .. } = Percentiles::of(times_ms.iter().copied())?;
    Some(FullDetail { jumps: times_ms.len() as u64, p50, max })
}

/// Returns the median; of an even number of counts, the lower of the two in the middle.
fn median(counts: impl Iterator<Item = u64>) -> Option<u64> {
    let mut counts: Vec<u64> = counts.collect();
    counts.sort_unstable();
    counts.get(counts.len().div_ceil(2).saturating_sub(1)).copied()
}

impl Report {
    /// Returns the report's warnings, one line each: for every run in which strokes were left out, and for every run
    /// with frames over the triangle budget.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let strokes = |run: &Run| Some(format!("{}: per frame, up to {}", run.style, run.strokes_left_out?.message()?));
        let terrain = |run: &Run| {
            let (frames, allowed) = (run.over_budget_frames.filter(|frames| *frames > 0)?, run.allowed_error_px?);
            let (style, of, most) = (&run.style, run.frames, allowed.max);
            Some(format!(
                "{style}: {frames} of {of} frames were over the triangle budget; the allowed error rose to {most:.2} px"
            ))
        };
        self.runs.iter().flat_map(|run| [strokes(run), terrain(run)]).flatten().collect()
    }

    /// Writes `report.json`, as a complete file or not at all.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub(crate) fn write_json(&self, path: &Path) -> Result<(), FileError> {
        let mut json = serde_json::to_vec_pretty(self).map_err(|error| FileError::write(path, error))?;
        json.push(b'\n');
        atomic::write(path, &json).map_err(|error| FileError::write(path, error))
    }

    /// Returns whether the file at `path` is a report, judged by its first keys.
    pub(crate) fn is_report(path: &Path) -> bool {
        let head = String::from_utf8_lossy(&head(path, 4096)).into_owned();
        let words: Vec<&str> = head.split('"').collect();
        // The keys in the order in which they are written; the adapter may have any name.
        head.starts_with('{')
            && words.get(1) == Some(&"adapter")
            && words.get(5) == Some(&"size")
            && words.get(7) == Some(&"world")
    }
}
