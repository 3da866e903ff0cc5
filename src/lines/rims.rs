//! Removes the lines that detectors find along the rims of holes. See `shaders/lines/rims.wgsl`.
//!
//! Why: `docs/decisions/voids.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// [`LINE`](super::threshold::LINE) without the lines along rims.
pub(crate) const RIMLESS: TargetKind = TargetKind::storage(
    "rimless line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Detected lines without those along areas without data"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The lines of the threshold pass.
    pub line: &'a Target,
    /// The rims: [`RIM`](crate::surface::rims::RIM).
    pub rim: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    pub rimless: &'a Target,
}

/// Removes the lines along rims.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("line", inputs.line.into()),
        ("rim", inputs.rim.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("rimless", inputs.rimless.into()),
    ];
    recorder.pixels("lines/rims", inputs.rimless.size_px(), &resources);
}
