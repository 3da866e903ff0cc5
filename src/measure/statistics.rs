//! Percentiles of a run, and the CSV table of its frames.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::work::FrameWork;
use crate::file::input;
use crate::file::unnamed::head;
use crate::file::{FileError, atomic};
use crate::lines::strokes::LeftOut;

/// Percentiles by nearest rank: each is one of the measured values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// Factor by which the surface was coarser than requested because its tiles do not fit into the memory for tiles; 1
    /// if they fit.
    pub memory_factor: Option<f64>,
    /// Time that the frame thread spent on tiles and patches.
    pub prepare_ms: Option<f64>,
    /// Whether the camera jumped to this frame. The first frame of a world counts as a jump; benchmarks draw it before
    /// the recorded frames.
    pub jumped: Option<bool>,
    /// Wall-clock time from the start of the run to the end of the frame.
    pub wall_s: Option<f64>,
    /// Time to record the passes.
    pub record_ms: Option<f64>,
    /// Time to upload uniforms and to submit; `None` on a software driver.
    pub submit_ms: Option<f64>,
    /// Time spent waiting for the GPU; `None` on a software driver.
    pub wait_ms: Option<f64>,
    /// Work of the frame on the GPU, if it was drawn once more with a trace after the flight.
    pub work: Option<FrameWork>,
}

/// The frames of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RunFrames {
    /// Name of the style.
    pub style: String,
    /// The value of `--eyes`: `mono`, `left`, `right`, `side-by-side`, `anaglyph` or `grey-anaglyph`.
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

/// The columns of the processor's times and of the work of a frame.
const COST_COLUMNS: [&str; 10] = [
    "record_ms",
    "submit_ms",
    "wait_ms",
    "bytes_read",
    "bytes_written",
    "wgpu_passes",
    "dispatches",
    "draws",
    "copies",
    "barriers",
];
/// Begins the column of a pass.
const PASS_COLUMN: &str = "gpu_ms.";
/// Largest table that is read: half a million frames of 60 passes.
const LARGEST_TABLE_BYTES: u64 = 256 << 20;

/// Returns whether the file at `path` has such rows, judged by its first columns.
pub(crate) fn is_frames_csv(path: &Path) -> bool {
    let columns = FIRST_COLUMNS.join(",");
    head(path, columns.len()) == columns.as_bytes()
}

/// Writes a row for each frame of all runs, as a complete file or not at all. After the fixed columns there is a column
/// `gpu_ms.PASS` for each pass. Values that were not measured are empty.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_frames_csv(path: &Path, runs: &[RunFrames]) -> Result<(), FileError> {
    let passes = pass_names(runs.iter().flat_map(|run| &run.frames));
    let mut table = csv::Writer::from_writer(Vec::new());
    let header = FIRST_COLUMNS
        .into_iter()
        .chain([
            "tiles_loaded",
            "late",
            "prepare_ms",
            "jumped",
            "wall_s",
            "allowed_error_px",
            "over_budget",
            "memory_factor",
        ])
        .chain(COST_COLUMNS)
        .map(str::to_owned);
    let header = header.chain(passes.iter().map(|pass| format!("{PASS_COLUMN}{pass}")));
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
                text(frame.memory_factor),
                text(frame.record_ms),
                text(frame.submit_ms),
                text(frame.wait_ms),
            ];
            let of_work = |part: fn(FrameWork) -> u64| text(frame.work.map(part));
            let work = [
                of_work(|work| work.bytes_read),
                of_work(|work| work.bytes_written),
                of_work(|work| work.wgpu_passes),
                of_work(|work| work.dispatches),
                of_work(|work| work.draws),
                of_work(|work| work.copies),
                of_work(|work| work.barriers),
            ];
            let times = passes
                .iter()
                .map(|&pass| text(frame.pass_gpu_ms.iter().find(|(name, _)| name == pass).map(|(_, time_ms)| time_ms)));
            table.write_record(fixed.into_iter().chain(work).chain(times)).map_err(failed)?;
        }
    }
    let bytes = table.into_inner().map_err(|error| FileError::write(path, error))?;
    atomic::write(path, &bytes).map_err(|error| FileError::write(path, error))
}

/// Reads the times of such a table: of frames, and of their passes. Other columns are ignored.
///
/// # Errors
/// The file cannot be read, or is not a table of frames.
pub(crate) fn read_frames_csv(path: &Path) -> Result<Vec<RunFrames>, FileError> {
    let failed = |cause: String| FileError::Read { path: path.to_owned(), cause };
    let bytes = input::read_bytes(path, LARGEST_TABLE_BYTES).map_err(|error| failed(error.to_string()))?;
    let mut table = csv::Reader::from_reader(bytes.as_slice());
    let header = table.headers().map_err(|error| failed(error.to_string()))?.clone();
    let column = |name: &str| {
        let at = header.iter().position(|column| column == name);
        at.ok_or_else(|| failed(format!("it has no column {name}, so it is not a frames.csv of bench")))
    };
    let [style, eyes, frame, t_s] = [column("style")?, column("eyes")?, column("frame")?, column("t_s")?];
    let [frame_ms, gpu_ms, prepare_ms] = [column("frame_ms")?, column("gpu_ms")?, column("prepare_ms")?];
    // Earlier versions had no such columns.
    let [record_ms, submit_ms] = ["record_ms", "submit_ms"].map(|name| header.iter().position(|known| known == name));
    let mut runs: Vec<RunFrames> = Vec::new();
    for row in table.records() {
        let row = row.map_err(|error| failed(error.to_string()))?;
        let number =
            |at: usize| row.get(at).and_then(|cell| cell.parse::<f64>().ok()).filter(|number| number.is_finite());
        let words = |at: usize| row.get(at).unwrap_or_default();
        if runs.last().is_none_or(|run| run.style != words(style) || run.eyes != words(eyes) || words(frame) == "0") {
            let [style, eyes] = [style, eyes].map(|at| words(at).to_owned());
            runs.push(RunFrames { style, eyes, frames: Vec::new() });
        }
        let passes =
            header.iter().enumerate().filter_map(|(at, name)| Some((name.strip_prefix(PASS_COLUMN)?, number(at)?)));
        let record = FrameRecord {
            frame: number(frame).map_or(0, |frame| frame as u64),
            t_s: number(t_s).unwrap_or_default(),
            frame_ms: number(frame_ms),
            gpu_ms: number(gpu_ms),
            prepare_ms: number(prepare_ms),
            record_ms: record_ms.and_then(number),
            submit_ms: submit_ms.and_then(number),
            pass_gpu_ms: passes.map(|(name, time_ms)| (name.to_owned(), time_ms)).collect(),
            ..FrameRecord::default()
        };
        if let Some(run) = runs.last_mut() {
            run.frames.push(record);
        }
    }
    Ok(runs)
}

fn text(value: Option<impl ToString>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}
