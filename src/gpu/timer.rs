//! Measures the GPU time of each pass.
//!
//! Nothing is measured unless it is requested ([`Submits::Timed`]), because timestamps keep dispatches apart.
//!
//! On a GPU, wgpu-profiler writes timestamps around each pass, and they are read a few frames later without waiting. On
//! a software driver timestamps do not time compute passes (Mesa's writes both when the next picture is rasterised).
//! But the driver works on the CPU, so there each pass is submitted alone and timed by the CPU's clock until it is
//! done.
//!
//! Why: `docs/decisions/timing.md`.

use std::collections::VecDeque;
use std::time::Instant;

use wgpu_profiler::{GpuProfiler, GpuProfilerQuery, GpuProfilerSettings, GpuTimerQueryResult};

use super::recorder::Submits;
use super::{Gpu, GpuError};

/// The name under which the time of the whole frame is listed among its passes.
pub(crate) const FRAME: &str = "frame";

/// Largest number of frames whose times have not been taken.
const MOST_PENDING: usize = 8;
/// The points at which the time of a whole frame begins and ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum Mark {
    Begin,
    End,
}

/// The names of the empty passes at [`Mark`]s.
const MARKS: [&str; 2] = ["frame begin", "frame end"];
/// The name of the only time of a frame that is not timed by passes, on a software driver.
const WHOLE: &str = "whole frame";

/// The GPU time of one pass in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass, which is that of its shader, or [`FRAME`].
    pub name: String,
    /// Time from begin to end in milliseconds, summed over all runs of the pass in the frame.
    pub gpu_ms: f64,
}

/// Measures the passes of frames.
pub struct Timer {
    profiler: GpuProfiler,
    /// Nanoseconds per tick of the GPU's clock.
    period_ns: f32,
    /// Whether the driver is a software driver, whose passes are timed by waiting for them.
    is_software: bool,
    /// Times of the frame that is being submitted, on a software driver.
    current_times: Vec<PassTime>,
    /// Times of the last finished frame, on a software driver.
    finished_times: Option<Vec<PassTime>>,
    /// Tag of the next frame.
    pub(crate) tag: u64,
    /// Tags of the frames whose times have not been taken, oldest first.
    tags: VecDeque<u64>,
}

impl Timer {
    /// Creates a timer. On a device without timestamp queries its lists of times are empty.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the queries cannot be created.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let settings = GpuProfilerSettings { max_num_pending_frames: MOST_PENDING, ..Default::default() };
        let profiler = GpuProfiler::new(&gpu.device, settings).map_err(|error| GpuError::Device(error.to_string()))?;
        let period_ns = gpu.queue.get_timestamp_period();
        Ok(Self {
            profiler,
            period_ns,
            is_software: gpu.is_software(),
            current_times: Vec::new(),
            finished_times: None,
            tag: 0,
            tags: VecDeque::new(),
        })
    }

    /// Returns the times of the oldest finished frame whose times have not been taken: [`FRAME`] first, then its
    /// passes; and the tag of the frame.
    pub fn take(&mut self) -> Option<(u64, Vec<PassTime>)> {
        if self.is_software {
            let times = self.finished_times.take()?;
            return Some((self.tags.drain(..).next_back().unwrap_or_default(), times));
        }
        let results = self.profiler.process_finished_frame(self.period_ns)?;
        let tag = self.tags.pop_front().unwrap_or_default();
        let mut times = Vec::new();
        collect(&results, &mut times);
        let end = |times: &[(f64, f64, PassTime)]| times.iter().map(|time| time.1).fold(f64::MIN, f64::max);
        let start = |times: &[(f64, f64, PassTime)]| times.iter().map(|time| time.0).fold(f64::MAX, f64::min);
        let frame = (!times.is_empty())
            .then(|| PassTime { name: FRAME.to_owned(), gpu_ms: (end(&times) - start(&times)) * 1000.0 });
        let mut passes = Vec::from_iter(frame);
        let of_passes = times.into_iter().filter(|(_, _, time)| !MARKS.contains(&&*time.name));
        of_passes.for_each(|(_, _, time)| add(&mut passes, time));
        Some((tag, passes))
    }

    /// Records an empty pass, at which the time of a whole frame begins or ends. Does nothing on a software driver.
    pub(super) fn mark(&self, mark: Mark, encoder: &mut wgpu::CommandEncoder) {
        let name = MARKS[mark as usize];
        let Some(query) = self.begin(name, encoder) else { return };
        let timestamp_writes = query.compute_pass_timestamp_writes();
        drop(encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes }));
        self.end(encoder, query);
    }

    /// Begins the time of a whole frame that is submitted now, on a software driver.
    pub(super) fn begin_frame(&self, gpu: &Gpu) -> Option<Instant> {
        self.is_software.then(|| {
            gpu.wait();
            Instant::now()
        })
    }

    /// Waits for the frame, and adds its time.
    pub(super) fn end_whole_frame(&mut self, gpu: &Gpu, begun: Instant) {
        gpu.wait();
        let time = PassTime { name: WHOLE.to_owned(), gpu_ms: begun.elapsed().as_secs_f64() * 1000.0 };
        self.current_times.push(time);
    }

    /// Returns whether each pass is submitted alone and waited for.
    pub(super) fn times_by_waiting(&self, submits: Submits) -> bool {
        self.is_software && submits == Submits::Timed
    }

    /// Begins the timestamp query of a pass. Returns `None` on a software driver.
    pub(super) fn begin(&self, name: &'static str, encoder: &mut wgpu::CommandEncoder) -> Option<GpuProfilerQuery> {
        (!self.is_software).then(|| self.profiler.begin_pass_query(name, encoder))
    }

    /// Ends a query of [`Timer::begin`].
    pub(super) fn end(&self, encoder: &mut wgpu::CommandEncoder, query: GpuProfilerQuery) {
        self.profiler.end_query(encoder, query);
    }

    /// Submits a pass alone, waits for it, and adds its time.
    pub(super) fn submit_and_time(&mut self, gpu: &Gpu, name: &'static str, recorded: wgpu::CommandBuffer) {
        // Finishes pending uploads first, so that they do not count as time of the pass.
        gpu.queue.submit([]);
        gpu.wait();
        let start = Instant::now();
        gpu.queue.submit([recorded]);
        gpu.wait();
        add(
            &mut self.current_times,
            PassTime { name: name.to_owned(), gpu_ms: start.elapsed().as_secs_f64() * 1000.0 },
        );
    }

    /// Drops the times of the frame that is being recorded, because it is not submitted. Times of earlier frames that
    /// have not been taken are lost too.
    pub(super) fn forget(&mut self, gpu: &Gpu) {
        self.current_times.clear();
        if !self.is_software {
            match Self::new(gpu) {
                Ok(timer) => *self = Self { tag: self.tag, ..timer },
                Err(error) => tracing::warn!("GPU timer: {error}"),
            }
        }
    }

    /// Records the reading of the timestamps. Must be called before the frame's last submit.
    pub(super) fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if !self.is_software {
            self.profiler.resolve_queries(encoder);
        }
    }

    /// Ends the frame. Must be called after its last submit.
    pub(super) fn end_frame(&mut self) {
        self.tags.push_back(self.tag);
        // The profiler drops the oldest frames, too.
        self.tags.drain(..self.tags.len().saturating_sub(MOST_PENDING));
        if self.is_software {
            let mut times = std::mem::take(&mut self.current_times);
            if !times.is_empty() {
                let gpu_ms = times.iter().map(|time| time.gpu_ms).sum();
                times.insert(0, PassTime { name: FRAME.to_owned(), gpu_ms });
                times.retain(|time| time.name != WHOLE);
            }
            self.finished_times = Some(times);
        } else if let Err(error) = self.profiler.end_frame() {
            // This fails only if a query is still open, and the recorder ends every query that it begins.
            tracing::warn!("GPU timer: {error}");
        }
    }
}

/// Adds a time to the list. The runs of a pass in one frame are summed.
fn add(times: &mut Vec<PassTime>, time: PassTime) {
    match times.iter_mut().find(|known| known.name == time.name) {
        Some(known) => known.gpu_ms += time.gpu_ms,
        None => times.push(time),
    }
}

/// Appends start and end in seconds and the time of each measured pass.
fn collect(results: &[GpuTimerQueryResult], times: &mut Vec<(f64, f64, PassTime)>) {
    for result in results {
        if let Some(range) = &result.time {
            let gpu_ms = (range.end - range.start) * 1000.0;
            times.push((range.start, range.end, PassTime { name: result.label.clone(), gpu_ms }));
        }
        collect(&result.nested_queries, times);
    }
}
