//! Anti-aliasing of lines. See `shaders/lines/smooth.wgsl`.
//!
//! Why: `docs/decisions/line-smoothing.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// [`LINE`](super::threshold::LINE) without stairs.
pub(crate) const SMOOTHED: TargetKind = TargetKind::storage(
    "smoothed line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Detected lines without staircase edges"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The lines before smoothing.
    pub line: &'a Target,
    pub smoothed: &'a Target,
}

/// Averages each line along its own direction.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [("view", inputs.view.clone()), ("line", inputs.line.into()), ("smoothed", inputs.smoothed.into())];
    recorder.pixels("lines/smooth", inputs.smoothed.size_px(), &resources);
}
