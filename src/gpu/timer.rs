//! GPU time by pass, each under its own name.

use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

use super::{Gpu, GpuError};

/// The time that one pass took.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass, by the name of its shader.
    pub name: String,
    /// Begin to end on the GPU's clock.
    pub gpu_ms: f64,
}

/// Times the passes of a frame.
pub struct Timer {
    profiler: GpuProfiler,
    period_ns: f32,
}

impl Timer {
    /// A timer; on a device without timestamps it measures nothing, and says so with an empty list.
    ///
    /// # Errors
    /// [`GpuError::Device`] when the queries cannot be made.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let settings = GpuProfilerSettings { max_num_pending_frames: 8, ..Default::default() };
        let profiler = GpuProfiler::new(&gpu.device, settings).map_err(|error| GpuError::Device(error.to_string()))?;
        Ok(Self { profiler, period_ns: gpu.queue.get_timestamp_period() })
    }

    /// Opens the scope in which a frame is recorded.
    pub fn frame<'a>(
        &'a self,
        encoder: &'a mut wgpu::CommandEncoder,
    ) -> wgpu_profiler::Scope<'a, wgpu::CommandEncoder> {
        self.profiler.scope("frame", encoder)
    }

    /// Call before the encoder is finished.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.profiler.resolve_queries(encoder);
    }

    /// Call after the frame is submitted.
    pub fn end_frame(&mut self) {
        // Fails only when a scope is still open, which the borrow of `frame` rules out.
        if let Err(error) = self.profiler.end_frame() {
            tracing::warn!("GPU timer: {error}");
        }
    }

    /// The times of the oldest finished frame that has not been asked for: `frame` first, then its passes.
    pub fn take(&mut self) -> Option<Vec<PassTime>> {
        let results = self.profiler.process_finished_frame(self.period_ns)?;
        let mut times = Vec::new();
        collect(&results, &mut times);
        Some(times)
    }
}

fn collect(results: &[GpuTimerQueryResult], times: &mut Vec<PassTime>) {
    for result in results {
        if let Some(range) = &result.time {
            times.push(PassTime { name: result.label.clone(), gpu_ms: (range.end - range.start) * 1000.0 });
        }
        collect(&result.nested_queries, times);
    }
}
