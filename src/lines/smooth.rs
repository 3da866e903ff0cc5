//! Anti-aliasing of lines. See `shaders/lines/smooth.wgsl`.
//!
//! Why: `docs/decisions/line-smoothing.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// As [`LINE`](super::threshold::LINE), without stairs.
pub const SMOOTHED: TargetKind = TargetKind::storage("smoothed line", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// With stairs.
    pub line: &'a Target,
    /// Out.
    pub smoothed: &'a Target,
}

/// Smooths lines along themselves.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [("view", inputs.view.clone()), ("line", inputs.line.into()), ("smoothed", inputs.smoothed.into())];
    recorder.pixels("lines/smooth", inputs.smoothed.size_px(), &resources);
}
