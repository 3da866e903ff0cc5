//! Frames without a timer around each pass, as a window draws them: how long one takes, and how many follow each other.

use std::collections::VecDeque;
use std::time::Instant;

use super::style_run::StyleRun;
use crate::gpu::recorder::Submits;
use crate::gpu::{Gpu, GpuError};
use crate::measure::statistics::Percentiles;
use crate::measure::work::Untimed;
use crate::scene::camera::Camera;

/// Number of frames on the way at the same time: the GPU draws one while the thread prepares the next.
const IN_FLIGHT: usize = 2;
/// Frames before the first one that counts.
const WARM_UP_FRAMES: usize = 2;

impl StyleRun {
    /// Draws the frames of `cameras` twice, waiting for each frame, and waiting only for the frame before the last.
    pub(super) fn measure_untimed(
        &mut self,
        gpu: &Gpu,
        size_px: [u32; 2],
        cameras: &[(Camera, f64)],
    ) -> Result<(), GpuError> {
        if cameras.len() <= WARM_UP_FRAMES {
            return Ok(());
        }
        self.set_submits(Submits::Whole);
        let (mut latencies_ms, mut parts_ms) = (Vec::new(), [const { Vec::new() }; 3]);
        for (number, (camera, t_s)) in cameras.iter().enumerate() {
            let start = Instant::now();
            let prepare_ms = self.draw_only(gpu, size_px, camera, *t_s)?;
            gpu.wait();
            if number >= WARM_UP_FRAMES {
                latencies_ms.push(start.elapsed().as_secs_f64() * 1000.0);
                let cpu = self.cpu();
                for (part, value) in parts_ms.iter_mut().zip([prepare_ms, cpu.record_ms, cpu.submit_ms]) {
                    part.push(value);
                }
            }
        }
        let mut on_the_way = VecDeque::new();
        let mut start = Instant::now();
        for (number, (camera, t_s)) in cameras.iter().enumerate() {
            if number == WARM_UP_FRAMES {
                gpu.wait();
                on_the_way.clear();
                start = Instant::now();
            }
            self.draw_only(gpu, size_px, camera, *t_s)?;
            // An empty submit ends when everything before it has ended.
            on_the_way.push_back(gpu.queue.submit([]));
            if on_the_way.len() >= IN_FLIGHT
                && let Some(oldest) = on_the_way.pop_front()
            {
                gpu.wait_for(oldest);
            }
        }
        gpu.wait();
        let frames = (cameras.len() - WARM_UP_FRAMES) as u64;
        let throughput_ms = start.elapsed().as_secs_f64() * 1000.0 / frames as f64;
        self.set_submits(Submits::Timed);
        gpu.check()?;
        let median = |values: Vec<f64>| Percentiles::of(values).map_or(0.0, |values| values.p50);
        let [prepare_ms, record_ms, submit_ms] = parts_ms.map(median);
        self.untimed = Percentiles::of(latencies_ms).map(|latency_ms| Untimed {
            frames,
            latency_ms,
            throughput_ms,
            prepare_ms,
            record_ms,
            submit_ms,
        });
        Ok(())
    }
}
