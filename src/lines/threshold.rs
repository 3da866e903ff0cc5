//! Errors → lines: density filter and ramp. See `shaders/lines/threshold.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::threshold::Threshold as ThresholdUniform;
use crate::style::{Detector, Lines};

/// Lines: 0 none, 1 full.
pub const LINE: TargetKind = TargetKind::storage("line", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the style's detector.
    pub errors: &'a Target,
    /// Out.
    pub line: &'a Target,
}

/// Makes lines of errors.
pub fn run(cx: &mut Cx<'_>, lines: &Lines, inputs: &Inputs<'_>) {
    let scalar = u32::from(lines.detector != Detector::Lsa);
    let uniform = ThresholdUniform { ramp: lines.ramp, density: lines.density, scalar };
    let resources = [
        ("view", inputs.view.clone()),
        ("threshold", cx.uniform("threshold", &uniform)),
        ("errors", inputs.errors.into()),
        ("line", inputs.line.into()),
    ];
    cx.pixels("lines/threshold", inputs.line.size_px(), &resources);
}
