//! The last frames of a flight, drawn again: without a timer around each pass, as a window draws them, for the time of a
//! frame and the time from one to the next; with timers, but without waiting, for the times of passes on a GPU that is
//! busy; and with traces, for the work that the frames give the GPU. A traced frame waits for the GPU and reads
//! counters back, so its times are not reported, and no frame of the flight itself is traced.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use super::style_run::StyleRun;
use crate::gpu::recorder::Submits;
use crate::gpu::timer::{FRAME, PassTime};
use crate::gpu::{Gpu, GpuError};
use crate::measure::statistics::Percentiles;
use crate::measure::work::{BusyGpu, Untimed};
use crate::scene::camera::Camera;

/// Number of frames in flight at the same time: the GPU draws one while the thread prepares the next.
const IN_FLIGHT: usize = 2;
/// Frames before the first one that counts.
const WARM_UP_FRAMES: usize = 2;
/// Least time for which frames are drawn before they are measured, since a GPU that was idle raises its clocks slowly.
const WARM_UP: Duration = Duration::from_millis(300);
/// Number of times that each frame is drawn for [`BusyGpu`]. The first drawing counts, and the others give the GPU
/// something to do while the frame thread prepares the next frame.
const REPEATS: usize = 3;
/// Least number of frames that are traced; of a style with strokes, one more than it takes until they are rebuilt.
const TRACED_FRAMES: usize = 4;

impl StyleRun {
    /// Draws the frames of `cameras` twice, waiting for each frame, and waiting only for the frame before the last. Each
    /// camera has its time on the path.
    pub(super) fn measure_untimed(&mut self, gpu: &Gpu, cameras: &[(Camera, f64)]) -> Result<(), GpuError> {
        if cameras.len() <= WARM_UP_FRAMES {
            return Ok(());
        }
        self.set_submits(Submits::Whole);
        let begun = Instant::now();
        for number in 0.. {
            let (camera, t_s) = &cameras[to_and_fro(number, cameras.len())];
            self.draw_only(gpu, camera, *t_s)?;
            gpu.wait();
            if number >= WARM_UP_FRAMES && begun.elapsed() > WARM_UP {
                break;
            }
        }
        let (mut latencies_ms, mut parts_ms) = (Vec::new(), [const { Vec::new() }; 3]);
        for (number, (camera, t_s)) in cameras.iter().enumerate() {
            let start = Instant::now();
            let prepare_ms = self.draw_only(gpu, camera, *t_s)?;
            gpu.wait();
            if number >= WARM_UP_FRAMES {
                latencies_ms.push(start.elapsed().as_secs_f64() * 1000.0);
                let cpu = self.cpu();
                for (part, value) in parts_ms.iter_mut().zip([prepare_ms, cpu.record_ms, cpu.submit_ms]) {
                    part.push(value);
                }
            }
        }
        let mut in_flight = VecDeque::new();
        let mut start = Instant::now();
        for (number, (camera, t_s)) in cameras.iter().enumerate() {
            if number == WARM_UP_FRAMES {
                gpu.wait();
                in_flight.clear();
                start = Instant::now();
            }
            self.draw_only(gpu, camera, *t_s)?;
            // An empty submit ends when everything before it has ended.
            in_flight.push_back(gpu.queue.submit([]));
            if in_flight.len() >= IN_FLIGHT
                && let Some(oldest) = in_flight.pop_front()
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

    /// Draws the frames of `cameras` with a timer around each pass, without waiting for any but the frame before the
    /// last, so that the GPU is never idle. Does nothing on a software driver, which waits for each timed pass.
    pub(super) fn measure_busy(&mut self, gpu: &Gpu, cameras: &[(Camera, f64)]) -> Result<(), GpuError> {
        if gpu.is_software() || cameras.len() <= WARM_UP_FRAMES {
            return Ok(());
        }
        self.set_submits(Submits::Timed);
        while self.take_times().is_some() {}
        let begun = Instant::now();
        let (mut in_flight, mut counted, mut times) = (VecDeque::new(), VecDeque::new(), Vec::new());
        // The frames are drawn until the clocks are up, and then once more.
        let mut counting = None;
        for number in 0.. {
            if counting.is_none() && number >= WARM_UP_FRAMES && begun.elapsed() > WARM_UP {
                counting = Some(number);
            }
            if counting.is_some_and(|from| number == from + cameras.len()) {
                break;
            }
            let (camera, t_s) = &cameras[to_and_fro(number, cameras.len())];
            let frame = self.begin_frame(gpu, camera, *t_s);
            for repeat in 0..REPEATS {
                self.draw_begun(gpu, &frame)?;
                counted.push_back(counting.is_some() && repeat == 0);
                in_flight.push_back(gpu.queue.submit([]));
                if in_flight.len() >= IN_FLIGHT
                    && let Some(oldest) = in_flight.pop_front()
                {
                    gpu.wait_for(oldest);
                }
                self.take_counted(&mut counted, &mut times);
            }
        }
        gpu.wait();
        self.take_counted(&mut counted, &mut times);
        gpu.check()?;
        self.busy = busy(&times);
        Ok(())
    }

    /// Takes the times of all frames that the GPU has finished, and adds those of frames that count. `counted` says which
    /// of the frames under way count, the oldest first.
    fn take_counted(&mut self, counted: &mut VecDeque<bool>, times: &mut Vec<Vec<PassTime>>) {
        while let Some(of_frame) = self.take_times() {
            times.extend(counted.pop_front().unwrap_or(false).then_some(of_frame));
        }
    }

    /// Draws frames of `cameras` with traces, and stores the work that each of them gave the GPU in the record of its
    /// frame. `cameras` are those of the last records, from the last one back. Each frame is first drawn without a
    /// trace, because the next frame of a view omits passes when the GPU has reported that they draw nothing, as those
    /// of water where there is none: otherwise it would depend on chance which passes are traced.
    pub(super) fn trace(&mut self, gpu: &Gpu, cameras: &[(Camera, f64)]) -> Result<(), GpuError> {
        if cameras.is_empty() {
            return Ok(());
        }
        self.set_submits(Submits::Whole);
        let update_every = self.variant.style.strokes().map_or(1, |strokes| strokes.update_every as usize);
        let traced = TRACED_FRAMES.max(update_every + 1);
        let first = cameras.len().saturating_sub(WARM_UP_FRAMES + traced);
        let cameras = &cameras[first..];
        // To the other end of the list and back, and then as many frames as in other measurements.
        let untraced = 2 * (cameras.len() - 1) + WARM_UP_FRAMES;
        for number in 0..untraced + traced {
            // The last camera that was drawn is the last one of the list.
            let index = to_and_fro(number + cameras.len() - 1, cameras.len());
            let (camera, t_s) = &cameras[index];
            self.set_traces(number >= untraced);
            self.draw_only(gpu, camera, *t_s)?;
            gpu.wait();
            let work = self.take_work();
            if let Some(record) = self.records.iter_mut().rev().nth(first + index) {
                record.work = work.or(record.work);
            }
        }
        self.set_traces(false);
        self.set_submits(Submits::Timed);
        gpu.check()
    }
}

/// Returns the percentiles of whole frames, and the medians of passes over the frames that ran them; `None` without times.
fn busy(times: &[Vec<PassTime>]) -> Option<BusyGpu> {
    let mut by_pass: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for time in times.iter().flatten() {
        by_pass.entry(&time.name).or_default().push(time.gpu_ms);
    }
    let frames_ms = by_pass.remove(FRAME)?;
    let frames = frames_ms.len() as u64;
    let median = |(name, times_ms): (&str, Vec<f64>)| Some((name.to_owned(), Percentiles::of(times_ms)?.p50));
    Some(BusyGpu {
        frames,
        gpu_ms: Percentiles::of(frames_ms)?,
        passes_ms: by_pass.into_iter().filter_map(median).collect(),
    })
}

/// Returns the index of the `number`th item if a list of `length` items is walked from the first to the last, back to the
/// first, and so on.
fn to_and_fro(number: usize, length: usize) -> usize {
    let last = length.saturating_sub(1);
    let at = number % (2 * last).max(1);
    if at <= last { at } else { 2 * last - at }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_has_the_median_of_the_frames_that_ran_it() {
        let time = |name: &str, gpu_ms| PassTime { name: name.to_owned(), gpu_ms };
        let frames = [
            vec![time(FRAME, 5.0), time("raster", 2.0)],
            vec![time(FRAME, 7.0), time("raster", 4.0), time("strokes", 3.0)],
            vec![time(FRAME, 6.0), time("raster", 3.0)],
        ];
        let busy = busy(&frames).expect("frames were timed");
        assert_eq!((busy.frames, busy.gpu_ms.p50, busy.gpu_ms.max), (3, 6.0, 7.0));
        let passes: Vec<_> = busy.passes_ms.iter().map(|(name, ms)| (name.as_str(), *ms)).collect();
        assert_eq!(passes, [("raster", 3.0), ("strokes", 3.0)]);
        assert_eq!(super::busy(&[]), None);
    }

    #[test]
    fn cameras_are_visited_to_and_fro() {
        let walk = |length| (0..8).map(|number| to_and_fro(number, length)).collect::<Vec<_>>();
        assert_eq!(walk(4), [0, 1, 2, 3, 2, 1, 0, 1]);
        assert_eq!(walk(2), [0, 1, 0, 1, 0, 1, 0, 1]);
        assert_eq!((walk(1), walk(0)), (vec![0; 8], vec![0; 8]));
    }
}
