//! How the surface bends toward the eye. See `shaders/lines/radial.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::surface::curvature::Shapes;

/// Curvature toward the eye, in turns of the normal over a pixel; its rise toward the eye, in turns over a feature and by
/// a feature; the cosine between the normal and the direction to the eye; distance along the view axis, 0 for what is
/// not there. Its size is that of [`Shapes`].
pub const RADIAL: TargetKind = TargetKind::storage("radial", wgpu::TextureFormat::Rgba32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// How the surface bends.
    pub shapes: &'a Shapes,
    /// Out.
    pub radial: &'a Target,
}

/// Finds it for the eye of the view.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone()), ("radial", inputs.radial.into())];
    resources.extend(inputs.shapes.resources());
    recorder.pixels("lines/radial", inputs.radial.size_px(), &resources);
}
