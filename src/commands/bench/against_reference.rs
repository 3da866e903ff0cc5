//! Exactness: each setting draws some views at rest, and so does a converged reference of its style.

use super::BenchArgs;
use super::style_run::StyleRun;
use super::sweep::Variant;
use crate::commands::progress::Bar;
use crate::frame::Antialias;
use crate::gpu::{Gpu, GpuError};
use crate::measure::lod_error;
use crate::measure::temporal::{self, DrawnFrame};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::source::Progress;

/// Number of views, spread over the path.
const VIEWS: usize = 8;
/// Samples of a picture at rest that is the mean of several frames.
const SAMPLES: u32 = 16;

/// A picture of a view at rest, and the largest error of its surface in pixels.
struct AtRest {
    drawn: DrawnFrame,
    surface_px: Option<f64>,
    /// Whether all tiles were there.
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
    for (view, camera) in path.spread(VIEWS).enumerate() {
        bar.report(&format!("comparing {name} with its reference"), view as f32 / VIEWS as f32);
        let truth = reference.draw_at_rest(gpu, &camera)?;
        let mut is_settled = truth.is_settled;
        for run in runs.iter_mut() {
            let AtRest { drawn, surface_px, is_settled: of_run } = run.draw_at_rest(gpu, &camera)?;
            run.exactness.add(&drawn, &truth.drawn, surface_px)?;
            is_settled &= of_run;
        }
        unsettled += u32::from(!is_settled);
    }
    if unsettled > 0 {
        tracing::warn!(
            "--sweep: {unsettled} of {VIEWS} views of {name} lacked tiles after 10 s, so their errors are too large"
        );
    }
    Ok(())
}

impl StyleRun {
    /// Draws a view until its tiles are there and its strokes have settled, with one eye.
    fn draw_at_rest(&mut self, gpu: &Gpu, camera: &Camera) -> Result<AtRest, GpuError> {
        let pair = self.pair.take();
        let drawn = self.draw_settled(gpu, camera);
        self.pair = pair;
        drawn
    }

    fn draw_settled(&mut self, gpu: &Gpu, camera: &Camera) -> Result<AtRest, GpuError> {
        self.forget();
        let is_settled = self.settle(gpu, camera, 0.0)?;
        let samples = if self.variant.antialias == Antialias::Temporal { SAMPLES } else { 1 };
        let mut rig = None;
        for _ in 0..samples {
            rig = Some(self.draw(gpu, camera, 0.0)?.0);
        }
        let rig = rig.ok_or_else(|| GpuError::Readback("no frame was drawn".to_owned()))?;
        let drawn = temporal::read_drawn(gpu, self.renderer(), &rig, 0, &self.variant.style)?;
        let terrain = &self.world.surfaces.terrain;
        let surface_px = lod_error::largest_px(gpu, self.renderer(), &rig.eyes[0], terrain, 0)?;
        Ok(AtRest { drawn, surface_px, is_settled })
    }
}
