//! Percentiles of a run, and the CSV table of its frames.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::file::unnamed::head;
use crate::file::{FileError, atomic};
use crate::lines::strokes::LeftOut;

/// Percentiles by nearest rank: each is one of the measured values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Percentiles {
    pub p50: f64,
    /// The value that 95 % of the values do not exceed.
    pub p95: f64,
    /// The value that 99 % of the values do not exceed.
    pub p99: f64,
    pub max: f64,
}

impl Percentiles {
    /// Returns the percentiles of the finite values; `None` if there are none.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        // With integers, because 0.95 × 20 must give rank 19 exactly.
        let at = |percent: usize| values.get((values.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some(Self { p50: at(50)?, p95: at(95)?, p99: at(99)?, max: at(100)? })
    }
}

/// The measurements of one frame; `None` is not measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FrameRecord {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Time on the camera path, in seconds.
    pub t_s: f64,
    /// Time from the beginning of the frame to its end, by the CPU's clock.
    pub frame_ms: Option<f64>,
    /// Time of the whole frame on the GPU.
    pub gpu_ms: Option<f64>,
    /// GPU time of each pass in milliseconds, by name and in drawing order.
    pub pass_gpu_ms: Vec<(String, f64)>,
    /// Largest projected error of the terrain, in pixels.
    pub lod_error_px: Option<f64>,
    /// Number of drawn triangles.
    pub triangles: Option<u64>,
    /// Number of drawn strokes.
    pub strokes: Option<u64>,
    /// Numbers of edges, segments and strokes that were left out for lack of room.
    pub strokes_left_out: Option<LeftOut>,
    /// Number of tiles that arrived during the frame.
    pub tiles_loaded: Option<u64>,
    /// Whether some terrain was coarser than its allowed error because tiles were still loading.
    pub late: Option<bool>,
    /// Allowed error of the terrain's mesh, in pixels: the requested error, or more if over budget.
    pub allowed_error_px: Option<f64>,
    /// Whether the allowed error was raised, because the requested one needs more triangles than a frame may have.
    pub over_budget: Option<bool>,
    /// Time that the frame thread spent on tiles and patches.
    pub prepare_ms: Option<f64>,
    /// Whether the camera jumped to this frame. The first frame of a world counts as a jump; benchmarks draw it before
    /// the recorded frames.
    pub jumped: Option<bool>,
    /// Wall-clock time from the start of the run to the end of the frame.
    pub wall_s: Option<f64>,
}

/// The frames of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RunFrames {
    /// Name of the style.
    pub style: String,
    /// `mono`, `side-by-side` or `anaglyph`.
    pub eyes: String,
    /// Frames in order of time.
    pub frames: Vec<FrameRecord>,
}

/// Returns the names of passes in order of their first appearance.
pub(super) fn pass_names<'a>(frames: impl IntoIterator<Item = &'a FrameRecord>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in frames.into_iter().flat_map(|frame| &frame.pass_gpu_ms) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

/// The first columns of `frames.csv`.
const FIRST_COLUMNS: [&str; 9] =
    ["style", "eyes", "frame", "t_s", "frame_ms", "gpu_ms", "lod_error_px", "triangles", "strokes"];

/// Returns whether the file at `path` has such rows, judged by its first columns.
pub(crate) fn is_frames_csv(path: &Path) -> bool {
    let columns = FIRST_COLUMNS.join(",");
    head(path, columns.len()) == columns.as_bytes()
}

/// Writes a row for each frame of all runs, as a complete file or not at all. After the fixed columns there is a column
/// `gpu_ms.PASS` for each pass. What was not measured is empty.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_frames_csv(path: &Path, runs: &[RunFrames]) -> Result<(), FileError> {
    let passes = pass_names(runs.iter().flat_map(|run| &run.frames));
    let mut table = csv::Writer::from_writer(Vec::new());
    let header = FIRST_COLUMNS
        .into_iter()
        .chain(["tiles_loaded", "late", "prepare_ms", "jumped", "wall_s", "allowed_error_px", "over_budget"])
        .map(str::to_owned);
    let header = header.chain(passes.iter().map(|pass| format!("gpu_ms.{pass}")));
    let failed = |error: csv::Error| FileError::write(path, error);
    table.write_record(header).map_err(failed)?;
    for run in runs {
        for frame in &run.frames {
            let fixed = [
                run.style.clone(),
                run.eyes.clone(),
                frame.frame.to_string(),
                frame.t_s.to_string(),
                text(frame.frame_ms),
                text(frame.gpu_ms),
                text(frame.lod_error_px),
                text(frame.triangles),
                text(frame.strokes),
                text(frame.tiles_loaded),
                text(frame.late.map(u8::from)),
                text(frame.prepare_ms),
                text(frame.jumped.map(u8::from)),
                text(frame.wall_s),
                text(frame.allowed_error_px),
                text(frame.over_budget.map(u8::from)),
            ];
            let times = passes
                .iter()
                .map(|&pass| text(frame.pass_gpu_ms.iter().find(|(name, _)| name == pass).map(|(_, time_ms)| time_ms)));
            table.write_record(fixed.into_iter().chain(times)).map_err(failed)?;
        }
    }
    let bytes = table.into_inner().map_err(|error| FileError::write(path, error))?;
    atomic::write(path, &bytes).map_err(|error| FileError::write(path, error))
}

fn text(value: Option<impl ToString>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}
