//! View-dependent curvature: the curvature of the surface as it appears on the picture. See
//! `shaders/lines/apparent.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::surface::curvature::Shapes;

/// x: the largest turn of the normal, in 1/m across the line of sight, positive where the surface is convex; yz: the
/// direction of that turn on the picture; w: the part of it that is due to a step across. The size is that of
/// [`Shapes`].
pub(crate) const APPARENT: TargetKind = TargetKind::storage(
    "apparent",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Curvature as the eye sees it, from which apparent ridges are found"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    pub apparent: &'a Target,
}

/// Computes the view-dependent curvature for the eye of the view.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone()), ("apparent", inputs.apparent.into())];
    resources.extend(inputs.shapes.resources());
    recorder.pixels("lines/apparent", inputs.apparent.size_px(), &resources);
}
