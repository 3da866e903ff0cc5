//! The curvature of the land's form at the scale of the picture: the second fundamental form and its derivative. See
//! `shaders/surface/curvature.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::mark_normal::mark_normal_size;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind, Targets};
use crate::gpu::wgsl::surface::curvature::CurvatureRules;

/// xyz: unit normal of the form, in world space; w: distance along the view axis. All 0 where there is no land, or
/// water. The size of all three targets is [`mark_normal_size`].
pub(crate) const SHAPE_NORMAL: TargetKind = TargetKind::storage(
    "shape normal",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Normal of the smoothed land whose curvature is measured"),
);
/// xyz: the second fundamental form in the tangent frame of [`SHAPE_NORMAL`] (uu, uv, vv), in 1/m; w: size of a sample
/// of the form, in metres.
pub(crate) const SHAPE_BEND: TargetKind = TargetKind::storage(
    "shape bend",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Curvature of the smoothed land in three components, per metre"),
);
/// The derivative of the second fundamental form (uuu, uuv, uvv, vvv), in 1/m².
pub(crate) const SHAPE_CHANGE: TargetKind = TargetKind::storage(
    "shape change",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Change of the curvature along the land, per square metre"),
);

/// The targets that the pass writes.
pub(crate) struct Shapes {
    pub normal: Target,
    pub bend: Target,
    pub change: Target,
}

impl Shapes {
    /// Allocates the targets of an eye.
    pub(crate) fn of(gpu: &crate::gpu::Gpu, targets: &mut Targets) -> Self {
        let size_px = mark_normal_size(targets.size_px());
        let [normal, bend, change] =
            [&SHAPE_NORMAL, &SHAPE_BEND, &SHAPE_CHANGE].map(|kind| targets.sized(gpu, kind, size_px));
        Self { normal, bend, change }
    }

    /// Returns the bindings of `Shape` in `shaders/shared/curvature.wgsl`, for passes that read or write it.
    pub(crate) fn resources(&self) -> [Named; 3] {
        [
            ("shape_normal", (&self.normal).into()),
            ("shape_bend", (&self.bend).into()),
            ("shape_change", (&self.change).into()),
        ]
    }
}

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// Size of the smallest feature that is not a mere detail, in pixels.
    pub feature_px: f32,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    /// [`WATER`](super::water::WATER), or a 1 × 1 picture that holds zero.
    pub water: &'a Target,
    pub shapes: &'a Shapes,
}

/// Computes the curvature of the visible land.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = CurvatureRules { feature_px: inputs.feature_px };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("curvature_rules", recorder.uniform("curvature rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("water", inputs.water.into()),
    ];
    resources.extend(inputs.shapes.resources());
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/curvature", inputs.shapes.normal.size_px(), &resources);
}
