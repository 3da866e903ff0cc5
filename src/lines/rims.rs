//! Takes away the lines that detectors find along the rims of holes. See `shaders/lines/rims.wgsl`.
//!
//! Why: `docs/decisions/voids.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// As [`LINE`](super::threshold::LINE), without those along rims.
pub const RIMLESS: TargetKind = TargetKind::storage("rimless line", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// As the threshold left them.
    pub line: &'a Target,
    /// [`RIM`](crate::surface::rims::RIM): where there are rims.
    pub rim: &'a Target,
    /// Places from the eye, and depths.
    pub position: &'a Target,
    /// Unit normals of what is seen.
    pub normal: &'a Target,
    /// Out.
    pub rimless: &'a Target,
}

/// Takes them away.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("line", inputs.line.into()),
        ("rim", inputs.rim.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("rimless", inputs.rimless.into()),
    ];
    recorder.pixels("lines/rims", inputs.rimless.size_px(), &resources);
}
