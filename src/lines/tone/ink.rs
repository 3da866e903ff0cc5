//! Draws lines from shading as ink. See `shaders/lines/tone/ink.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::ink::Ink;
use crate::style::ToneLines;

/// Ink of dark lines and of highlight lines, 0 to 1.
pub(crate) const TONE_INK: TargetKind = TargetKind::storage(
    "tone ink",
    wgpu::TextureFormat::Rgba16Float,
    Group::Ink.shows("Ink of dark lines and of highlight lines from shading"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub style: &'a ToneLines,
    /// Side of a cell of the grid, in pixels.
    pub cell_px: u32,
    /// Position; its last channel is 0 where there is no surface.
    pub distance: &'a Target,
    /// [`BLURRED`](super::blur::BLURRED), for the width of the lines.
    pub blurred: &'a Target,
    /// [`TONE_LINES`](super::search::TONE_LINES), or [`LONG_LINES`](super::along::LONG_LINES).
    pub tone_lines: &'a Target,
    pub tone_ink: &'a Target,
}

/// Draws the lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let ink = Ink { softness: inputs.style.softness, cell_px: inputs.cell_px as i32, ..Ink::default() };
    let resources = [
        ("view", inputs.view.clone()),
        ("ink", recorder.uniform("tone lines ink", &ink)),
        ("distance_m", inputs.distance.into()),
        ("blurred", inputs.blurred.into()),
        ("tone_lines", inputs.tone_lines.into()),
        ("tone_ink", inputs.tone_ink.into()),
    ];
    recorder.pixels("lines/tone/ink", inputs.tone_ink.size_px(), &resources);
}
