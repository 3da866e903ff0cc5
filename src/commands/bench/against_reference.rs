//! Exactness: each setting draws some views at rest, and so does a converged reference of its style.

use std::time::Duration;

use super::BenchArgs;
use super::style_run::StyleRun;
use super::sweep::Variant;
use crate::commands::progress::Bar;
use crate::frame::Antialias;
use crate::gpu::recorder::Submits;
use crate::gpu::{Gpu, GpuError};
use crate::measure::lod_error;
use crate::measure::temporal::{self, DrawnFrame};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::source::Progress;
use crate::tiles::Terrain;

/// Number of views, spread over the path.
const VIEWS: usize = 8;
/// Longest wait for the tiles of a view. A drawing without them would be compared with one that has them.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// Samples of a picture at rest that is the mean of several frames.
const SAMPLES: u32 = 16;

/// A short flight begins at every second view, for the bytes of a frame in flight.
const VIEWS_PER_FLIGHT: usize = 2;
/// Frames per second of that flight.
const FLIGHT_FPS: f64 = 60.0;
/// Frames of a flight before the first that is traced: whether a picture shows water, for example, is only known after
/// it was drawn.
const FLIGHT_WARM_UP: usize = 2;
/// Number of frames that are traced at each place: one interval of rebuilding strokes, within these limits.
const TRACED: std::ops::RangeInclusive<usize> = 2..=12;

/// The frames of short flights, and the bytes that they read and wrote.
#[derive(Default)]
pub(super) struct Flown {
    frames: u64,
    bytes: u64,
}

impl Flown {
    /// Returns the mean bytes of a frame; `None` without frames.
    pub(super) fn mean_bytes(&self) -> Option<u64> {
        self.bytes.checked_div(self.frames)
    }
}

/// A picture of a view at rest, and the largest error of its surface in pixels.
struct AtRest {
    drawn: DrawnFrame,
    surface_px: Option<f64>,
    /// Whether all tiles were loaded.
    is_settled: bool,
}

/// Compares the settings of one style, whose name is `name`, with its reference.
pub(super) fn measure(
    gpu: &Gpu,
    args: &BenchArgs,
    scene: &Scene,
    path: &CameraPath,
    name: &str,
    runs: &mut [StyleRun],
) -> anyhow::Result<()> {
    let bar = Bar::default();
    let mut reference = StyleRun::new(gpu, Variant::reference(args, name)?, args.tile_memory_mib(), scene)?;
    if let Some(run) = runs.first() {
        reference.world.scene.sun = run.world.scene.sun;
    }
    let mut unsettled = 0;
    for (view, (t_s, camera)) in path.spread_s(VIEWS).zip(path.spread(VIEWS)).enumerate() {
        bar.report(&format!("comparing {name} with its reference"), view as f32 / VIEWS as f32);
        let truth = reference.draw_at_rest(gpu, &camera, None)?;
        let mut is_settled = truth.is_settled;
        let true_land = &reference.world.surfaces.terrain;
        for run in runs.iter_mut() {
            let AtRest { drawn, surface_px, is_settled: of_run } = run.draw_at_rest(gpu, &camera, Some(true_land))?;
            run.exactness.add(&drawn, &truth.drawn, surface_px)?;
            is_settled &= of_run;
            if view % VIEWS_PER_FLIGHT == 0 {
                run.trace_flight(gpu, path, t_s)?;
            }
        }
        unsettled += u32::from(!is_settled);
    }
    if unsettled > 0 {
        tracing::warn!(
            "--sweep: {unsettled} of {VIEWS} views of {name} lacked tiles after {} s, so their errors are measured too large; give more --tile-memory, or fewer \
             settings",
            LONGEST_WAIT.as_secs()
        );
    }
    Ok(())
}

impl StyleRun {
    /// Draws a view until its tiles are loaded and its strokes have settled, with one eye. Its surface is compared with
    /// the heights of `true_land`, or with its own if there is none.
    fn draw_at_rest(&mut self, gpu: &Gpu, camera: &Camera, true_land: Option<&Terrain>) -> Result<AtRest, GpuError> {
        let pair = self.pair.take();
        let drawn = self.draw_settled(gpu, camera, true_land);
        self.pair = pair;
        drawn
    }

    /// Draws a short flight, which begins at a time of the path where a picture at rest was drawn, and traces its frames.
    fn trace_flight(&mut self, gpu: &Gpu, path: &CameraPath, t_s: f64) -> Result<(), GpuError> {
        let interval = self.variant.style.strokes().map_or(1, |strokes| strokes.update_every as usize);
        let traced = interval.clamp(*TRACED.start(), *TRACED.end());
        let frames = FLIGHT_WARM_UP + traced;
        // At its end, the path is flown back.
        let end_s = path.times_s().last().copied().unwrap_or_default();
        let direction = if t_s + frames as f64 / FLIGHT_FPS > end_s { -1.0 } else { 1.0 };
        self.set_submits(Submits::Whole);
        for frame in 0..frames {
            let now_s = t_s + direction * frame as f64 / FLIGHT_FPS;
            self.set_traces(frame >= FLIGHT_WARM_UP);
            self.draw_only(gpu, &path.sample(now_s), now_s)?;
            gpu.wait();
            if let Some(work) = self.take_work() {
                self.flown.frames += 1;
                self.flown.bytes += work.bytes();
            }
        }
        self.set_traces(false);
        self.set_submits(Submits::Timed);
        gpu.check()
    }

    fn draw_settled(&mut self, gpu: &Gpu, camera: &Camera, true_land: Option<&Terrain>) -> Result<AtRest, GpuError> {
        self.forget();
        let is_settled = self.settle(gpu, camera, 0.0, LONGEST_WAIT)?;
        let samples = if self.variant.antialias == Antialias::Temporal { SAMPLES } else { 1 };
        let mut rig = None;
        for _ in 0..samples {
            rig = Some(self.draw(gpu, camera, 0.0)?.0);
        }
        let rig = rig.ok_or_else(|| GpuError::Readback("no frame was drawn".to_owned()))?;
        let drawn = temporal::read_drawn(gpu, self.renderer(), &rig, 0, &self.variant.style)?;
        let terrain = true_land.unwrap_or(&self.world.surfaces.terrain);
        let surface_px = lod_error::largest_px(gpu, self.renderer(), &rig.eyes[0], terrain, 0)?;
        Ok(AtRest { drawn, surface_px, is_settled })
    }
}
