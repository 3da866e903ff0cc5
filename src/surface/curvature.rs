//! How the land's form bends at the scale of the picture: its second fundamental form, and the derivative of that. See
//! `shaders/surface/curvature.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::mark_normal::mark_normal_size;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind, Targets};
use crate::gpu::wgsl::surface::curvature::CurvatureRules;

/// xyz: the form's unit normal in the world; w: distance along the view axis. All 0 is what is no land, or is water. Its size is
/// [`mark_normal_size`], and so is that of the others.
pub const SHAPE_NORMAL: TargetKind = TargetKind::storage("shape normal", wgpu::TextureFormat::Rgba32Float);
/// xyz: the second fundamental form in the frame of that normal, uu, uv, vv, in 1/m; w: size of a sample of the form, in
/// metres.
pub const SHAPE_BEND: TargetKind = TargetKind::storage("shape bend", wgpu::TextureFormat::Rgba32Float);
/// Its derivative: uuu, uuv, uvv, vvv, in 1/m².
pub const SHAPE_CHANGE: TargetKind = TargetKind::storage("shape change", wgpu::TextureFormat::Rgba32Float);

/// What the pass writes.
pub struct Shapes {
    /// [`SHAPE_NORMAL`].
    pub normal: Target,
    /// [`SHAPE_BEND`].
    pub bend: Target,
    /// [`SHAPE_CHANGE`].
    pub change: Target,
}

impl Shapes {
    /// Those of an eye.
    pub fn of(gpu: &crate::gpu::Gpu, targets: &mut Targets) -> Self {
        let size_px = mark_normal_size(targets.size_px());
        let [normal, bend, change] =
            [&SHAPE_NORMAL, &SHAPE_BEND, &SHAPE_CHANGE].map(|kind| targets.sized(gpu, kind, size_px));
        Self { normal, bend, change }
    }

    /// `Shape` in `shaders/shared/curvature.wgsl`, for those who read it or write it.
    pub fn resources(&self) -> [Named; 3] {
        [
            ("shape_normal", (&self.normal).into()),
            ("shape_bend", (&self.bend).into()),
            ("shape_change", (&self.change).into()),
        ]
    }
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// Size of what is no more than a detail, in pixels.
    pub feature_px: f32,
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// [`WATER`](super::water::WATER), or nothing.
    pub water: &'a Target,
    /// Out.
    pub shapes: &'a Shapes,
}

/// Finds the shape of the land that the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = CurvatureRules { feature_px: inputs.feature_px };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("curvature_rules", recorder.uniform("curvature rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("water", inputs.water.into()),
    ];
    resources.extend(inputs.shapes.resources());
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/curvature", inputs.shapes.normal.size_px(), &resources);
}
