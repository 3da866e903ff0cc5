//! How the surface bends as the picture shows it. See `shaders/lines/apparent.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::surface::curvature::Shapes;

/// Largest turn of the normal, in 1/m across the line of sight, positive where the surface is convex; its direction on the
/// picture, x and y; which part of that turn it makes by a step across. Its size is that of [`Shapes`].
pub const APPARENT: TargetKind = TargetKind::storage("apparent", wgpu::TextureFormat::Rgba32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// How the surface bends.
    pub shapes: &'a Shapes,
    /// Out.
    pub apparent: &'a Target,
}

/// Finds it for the eye of the view.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone()), ("apparent", inputs.apparent.into())];
    resources.extend(inputs.shapes.resources());
    recorder.pixels("lines/apparent", inputs.apparent.size_px(), &resources);
}
