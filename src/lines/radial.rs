//! Radial curvature: the curvature of the surface toward the eye. See `shaders/lines/radial.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::surface::curvature::Shapes;

/// x: radial curvature, in radians per pixel; y: its derivative toward the eye times the square of the feature size, in
/// radians; z: cosine between the normal and the direction to the eye; w: distance along the view axis, 0 where there
/// is no surface. The size is that of [`Shapes`].
pub(crate) const RADIAL: TargetKind = TargetKind::storage(
    "radial",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Curvature toward the eye, from which suggestive contours are found"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    /// The output, of kind [`RADIAL`].
    pub radial: &'a Target,
}

/// Computes the radial curvature for the eye of the view.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone()), ("radial", inputs.radial.into())];
    resources.extend(inputs.shapes.resources());
    recorder.pixels("lines/radial", inputs.radial.size_px(), &resources);
}
