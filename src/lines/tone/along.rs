//! Removes short fragments of lines from shading. See `shaders/lines/tone/along.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::along::{Along, STEP_PX, STEPS};
use crate::style::ToneLines;

/// [`TONE_LINES`](super::search::TONE_LINES) without short lines.
pub(crate) const LONG_LINES: TargetKind = TargetKind::storage(
    "long tone lines",
    wgpu::TextureFormat::Rgba16Float,
    Group::Lines.shows("Nearest line from shading at each pixel, without short lines"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style, which sets the least length of a line.
    pub style: &'a ToneLines,
    /// Side of a cell of the grid, in pixels.
    pub cell_px: u32,
    pub tone_lines: &'a Target,
    pub long_lines: &'a Target,
}

/// Removes lines shorter than `shortest_px`.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let shortest_px = inputs.style.shortest_px;
    let step_px = (shortest_px / STEPS as f32).max(STEP_PX);
    let along = Along {
        shortest_px,
        step_px,
        steps: (shortest_px / step_px).ceil() as i32,
        cell_px: inputs.cell_px as i32,
        // Pixels read the cells around them.
        farthest_px: 0.5 * inputs.style.widest_px() + 0.5 + std::f32::consts::SQRT_2 * inputs.cell_px as f32,
        ..Along::default()
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("along", recorder.uniform("tone along", &along)),
        ("tone_lines", inputs.tone_lines.into()),
        ("long_lines", inputs.long_lines.into()),
    ];
    recorder.pixels("lines/tone/along", inputs.long_lines.size_px(), &resources);
}
