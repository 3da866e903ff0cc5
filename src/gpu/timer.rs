//! GPU time by pass, each under its own name.
//!
//! On a GPU the clock is the GPU's: timestamps around each pass, through wgpu-profiler, read a few frames later without
//! waiting. On a software driver timestamps do not time compute passes (Mesa's writes both when the next picture is
//! rasterised), but the driver's work is the CPU's: there each pass is submitted by itself and timed until it is done.
//!
//! Why: `docs/decisions/timing.md`.

use std::time::Instant;

use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

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
        Ok(Self { profiler, period_ns: gpu.queue.get_timestamp_period(), waits, waited: None })
    }

    /// Starts a frame.
    pub fn record<'a>(&'a mut self, gpu: &'a Gpu) -> Recorder<'a> {
        Recorder { gpu, encoder: encoder(gpu), times: Vec::new(), timer: self }
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
}

/// Records the passes of a frame.
pub struct Recorder<'a> {
    gpu: &'a Gpu,
    timer: &'a mut Timer,
    encoder: wgpu::CommandEncoder,
    times: Vec<PassTime>,
}

impl Recorder<'_> {
    /// Records a compute pass.
    pub fn compute(&mut self, name: &'static str, record: impl FnOnce(&mut wgpu::ComputePass)) {
        let query = (!self.timer.waits).then(|| self.timer.profiler.begin_pass_query(name, &mut self.encoder));
        let timestamp_writes = query.as_ref().and_then(|query| query.compute_pass_timestamp_writes());
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        record(&mut self.encoder.begin_compute_pass(&descriptor));
        self.end(name, query);
    }

    /// Records a render pass; the descriptor's timestamps are set here.
    pub fn render(
        &mut self,
        name: &'static str,
        descriptor: &wgpu::RenderPassDescriptor<'_>,
        record: impl FnOnce(&mut wgpu::RenderPass),
    ) {
        let query = (!self.timer.waits).then(|| self.timer.profiler.begin_pass_query(name, &mut self.encoder));
        {
            let timestamp_writes = query.as_ref().and_then(|query| query.render_pass_timestamp_writes());
            let descriptor = wgpu::RenderPassDescriptor { timestamp_writes, ..descriptor.clone() };
            record(&mut self.encoder.begin_render_pass(&descriptor));
        }
        self.end(name, query);
    }

    /// Submits the frame.
    pub fn submit(mut self) {
        if self.timer.waits {
            let gpu_ms = self.times.iter().map(|time| time.gpu_ms).sum();
            self.times.insert(0, PassTime { name: FRAME.to_owned(), gpu_ms });
            self.timer.waited = Some(self.times);
            return;
        }
        self.timer.profiler.resolve_queries(&mut self.encoder);
        self.gpu.queue.submit([self.encoder.finish()]);
        // Fails only when a query is still open, and each is ended where it is begun.
        if let Err(error) = self.timer.profiler.end_frame() {
            tracing::warn!("GPU timer: {error}");
        }
    }

    fn end(&mut self, name: &'static str, query: Option<wgpu_profiler::GpuProfilerQuery>) {
        if let Some(query) = query {
            self.timer.profiler.end_query(&mut self.encoder, query);
            return;
        }
        // Uploads that wait in the queue are not the pass's work.
        self.gpu.queue.submit([]);
        self.gpu.wait();
        let recorded = std::mem::replace(&mut self.encoder, encoder(self.gpu));
        let start = Instant::now();
        self.gpu.queue.submit([recorded.finish()]);
        self.gpu.wait();
        add(&mut self.times, PassTime { name: name.to_owned(), gpu_ms: start.elapsed().as_secs_f64() * 1000.0 });
    }
}

/// A pass that runs in several batches has one time.
fn add(times: &mut Vec<PassTime>, time: PassTime) {
    match times.iter_mut().find(|known| known.name == time.name) {
        Some(known) => known.gpu_ms += time.gpu_ms,
        None => times.push(time),
    }
}

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(FRAME) })
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
