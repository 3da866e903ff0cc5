//! Exact screen motion of every pixel. See `shaders/surface/motion.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};

/// Pixels from the previous frame to this one: x right, y down.
pub const MOTION: TargetKind = TargetKind::storage("motion", wgpu::TextureFormat::Rg32Float);

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub position: &'a Target,
    /// Out.
    pub motion: &'a Target,
}

/// Finds the motion of every pixel, of the sky as well.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let resources =
        [("view", inputs.view.clone()), ("position", inputs.position.into()), ("motion", inputs.motion.into())];
    cx.pixels("surface/motion", inputs.motion.size_px(), &resources);
}
