//! GPU time by pass, each under its own name.
//!
//! On a GPU the clock is the GPU's: timestamps around each pass, through wgpu-profiler, read a few frames later without
//! waiting. On a software driver timestamps do not time compute passes (Mesa's writes both when the next picture is
//! rasterised), but the driver's work is the CPU's: there each pass is submitted by itself and timed until it is done.
//!
//! Why: `docs/decisions/timing.md`.

use std::time::Instant;

use wgpu_profiler::{GpuProfiler, GpuProfilerQuery, GpuProfilerSettings, GpuTimerQueryResult};

use super::recorder::Submits;
use super::{Gpu, GpuError};

/// The name of the whole frame among the times of its passes.
pub const FRAME: &str = "frame";

/// The time that one pass took.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass, by the name of its shader; [`FRAME`] for all of them.
    pub name: String,
    /// Begin to end.
    pub gpu_ms: f64,
}

/// Times the passes of frames.
pub struct Timer {
    profiler: GpuProfiler,
    period_ns: f32,
    waits: bool,
    /// Of the frame that is being recorded.
    waiting: Vec<PassTime>,
    waited: Option<Vec<PassTime>>,
}

impl Timer {
    /// A timer; on a device without timestamps it measures nothing, and says so with an empty list.
    ///
    /// # Errors
    /// [`GpuError::Device`] when the queries cannot be made.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let settings = GpuProfilerSettings { max_num_pending_frames: 8, ..Default::default() };
        let profiler = GpuProfiler::new(&gpu.device, settings).map_err(|error| GpuError::Device(error.to_string()))?;
        let waits = gpu.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        Ok(Self { profiler, period_ns: gpu.queue.get_timestamp_period(), waits, waiting: Vec::new(), waited: None })
    }

    /// The times of the oldest finished frame that has not been asked for: [`FRAME`] first, then its passes.
    pub fn take(&mut self) -> Option<Vec<PassTime>> {
        if self.waits {
            return self.waited.take();
        }
        let results = self.profiler.process_finished_frame(self.period_ns)?;
        let mut times = Vec::new();
        collect(&results, &mut times);
        let end = |times: &[(f64, f64, PassTime)]| times.iter().map(|time| time.1).fold(f64::MIN, f64::max);
        let start = |times: &[(f64, f64, PassTime)]| times.iter().map(|time| time.0).fold(f64::MAX, f64::min);
        let frame = (!times.is_empty())
            .then(|| PassTime { name: FRAME.to_owned(), gpu_ms: (end(&times) - start(&times)) * 1000.0 });
        let mut passes = Vec::from_iter(frame);
        times.into_iter().for_each(|(_, _, time)| add(&mut passes, time));
        Some(passes)
    }

    /// Whether each pass is submitted by itself and waited for.
    pub(super) fn waits(&self, submits: Submits) -> bool {
        self.waits && submits == Submits::Timed
    }

    /// Begins a pass, where the clock is the GPU's.
    pub(super) fn begin(&self, name: &'static str, encoder: &mut wgpu::CommandEncoder) -> Option<GpuProfilerQuery> {
        (!self.waits).then(|| self.profiler.begin_pass_query(name, encoder))
    }

    /// Ends what [`Timer::begin`] began.
    pub(super) fn end(&self, encoder: &mut wgpu::CommandEncoder, query: GpuProfilerQuery) {
        self.profiler.end_query(encoder, query);
    }

    /// Submits a pass by itself and waits for it.
    pub(super) fn time(&mut self, gpu: &Gpu, name: &'static str, recorded: wgpu::CommandEncoder) {
        // Uploads that wait in the queue are not the pass's work.
        gpu.queue.submit([]);
        gpu.wait();
        let start = Instant::now();
        gpu.queue.submit([recorded.finish()]);
        gpu.wait();
        add(&mut self.waiting, PassTime { name: name.to_owned(), gpu_ms: start.elapsed().as_secs_f64() * 1000.0 });
    }

    /// Drops the frame that is being recorded: it is not submitted. What was submitted before and not asked for goes
    /// too.
    pub(super) fn forget(&mut self, gpu: &Gpu) {
        self.waiting.clear();
        if !self.waits {
            match Self::new(gpu) {
                Ok(timer) => *self = timer,
                Err(error) => tracing::warn!("GPU timer: {error}"),
            }
        }
    }

    /// Before the frame's last submit.
    pub(super) fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if !self.waits {
            self.profiler.resolve_queries(encoder);
        }
    }

    /// After it.
    pub(super) fn end_frame(&mut self) {
        if self.waits {
            let mut times = std::mem::take(&mut self.waiting);
            if !times.is_empty() {
                let gpu_ms = times.iter().map(|time| time.gpu_ms).sum();
                times.insert(0, PassTime { name: FRAME.to_owned(), gpu_ms });
            }
            self.waited = Some(times);
        } else if let Err(error) = self.profiler.end_frame() {
            // Fails only when a query is still open, and each is ended where it is begun.
            tracing::warn!("GPU timer: {error}");
        }
    }
}

/// A pass that runs in several batches has one time.
fn add(times: &mut Vec<PassTime>, time: PassTime) {
    match times.iter_mut().find(|known| known.name == time.name) {
        Some(known) => known.gpu_ms += time.gpu_ms,
        None => times.push(time),
    }
}

fn collect(results: &[GpuTimerQueryResult], times: &mut Vec<(f64, f64, PassTime)>) {
    for result in results {
        if let Some(range) = &result.time {
            let gpu_ms = (range.end - range.start) * 1000.0;
            times.push((range.start, range.end, PassTime { name: result.label.clone(), gpu_ms }));
        }
        collect(&result.nested_queries, times);
    }
}
