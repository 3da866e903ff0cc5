//! Percentiles of a run, and the table of its frames.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::file::{FileError, atomic};
use crate::lines::strokes::LeftOut;

/// Percentiles by nearest rank: each is one of the values measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// The median.
    pub p50: f64,
    /// 95 % of the values are at most this.
    pub p95: f64,
    /// 99 % of the values are at most this.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Percentiles {
    /// Of the finite values among these; none if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        // In integers: 0.95 × 20 must be rank 19.
        let at = |percent: usize| values.get((values.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some(Self { p50: at(50)?, p95: at(95)?, p99: at(99)?, max: at(100)? })
    }
}

/// What was measured of one frame; none is what was not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameRecord {
    /// Counted from 0.
    pub frame: u64,
    /// The time on the camera path, in seconds.
    pub t_s: f64,
    /// From the begin of the frame to its end, as the CPU's clock sees it.
    pub frame_ms: Option<f64>,
    /// The time of the whole frame on the GPU.
    pub gpu_ms: Option<f64>,
    /// The time of each pass on the GPU, in milliseconds, under its own name and in drawing order.
    pub pass_gpu_ms: Vec<(String, f64)>,
    /// The largest projected error of the terrain in this frame, in pixels.
    pub lod_error_px: Option<f64>,
    /// Triangles drawn.
    pub triangles: Option<u64>,
    /// Strokes drawn.
    pub strokes: Option<u64>,
    /// What of the strokes found no room.
    pub strokes_left_out: Option<LeftOut>,
    /// Tiles that arrived during the frame.
    pub tiles_loaded: Option<u64>,
    /// Whether some of the terrain was coarser than its error allows: tiles were on their way.
    pub late: Option<bool>,
    /// The error that the terrain's mesh was allowed, in pixels: what was asked for, or more.
    pub allowed_error_px: Option<f64>,
    /// Whether it was more, because what was asked for takes more triangles than a frame has.
    pub over_budget: Option<bool>,
    /// What the frame thread spent on tiles and patches.
    pub prepare_ms: Option<f64>,
    /// Whether the camera jumped to this frame.
    pub jumped: Option<bool>,
    /// The time since the run began, by the clock on the wall, when the frame was done.
    pub wall_s: Option<f64>,
}

/// The frames of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunFrames {
    /// The name of the style.
    pub style: String,
    /// mono, side-by-side or anaglyph.
    pub eyes: String,
    /// In time order.
    pub frames: Vec<FrameRecord>,
}

/// Names in the order in which they first appear.
pub(super) fn pass_names<'a>(frames: impl IntoIterator<Item = &'a FrameRecord>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in frames.into_iter().flat_map(|frame| &frame.pass_gpu_ms) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

/// Writes one line per frame of all runs, whole or not at all. After the fixed columns stands one `gpu_ms.PASS` for
/// each pass; what was not measured is empty.
///
/// # Errors
/// A file that cannot be written.
pub fn write_frames_csv(path: &Path, runs: &[RunFrames]) -> Result<(), FileError> {
    let passes = pass_names(runs.iter().flat_map(|run| &run.frames));
    let mut table = csv::Writer::from_writer(Vec::new());
    let fixed = ["style", "eyes", "frame", "t_s", "frame_ms", "gpu_ms", "lod_error_px", "triangles", "strokes"];
    let header = fixed
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
