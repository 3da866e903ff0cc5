//! Finds valleys, ridges and edges of the tone image. See `shaders/lines/tone/search.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::search::Search;
use crate::style::ToneLines;

/// The line nearest to each cell of the grid: curvature of the tone relative to the threshold (negative for a highlight
/// line), opacity, signed distance in pixels, and direction as a number from -1 to 1. See `Line` and `texel_of_line` in
/// `shaders/shared/tone_grid.wgsl`.
pub(crate) const TONE_LINES: TargetKind = TargetKind::storage(
    "tone lines",
    wgpu::TextureFormat::Rgba16Float,
    Group::Lines.shows("Nearest line from shading at each pixel: curvature, opacity, distance and direction"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub style: &'a ToneLines,
    /// Side of a cell of the grid, in pixels.
    pub cell_px: u32,
    pub blurred: &'a Target,
    pub tone_lines: &'a Target,
}

/// Finds the lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let search = Search {
        dark_ramp: style.dark_ramp,
        highlight_ramp: style.highlight_ramp,
        beta: style.step_part(),
        counterchange: style.counterchange,
        roundest: style.roundest,
        has_dark: style.dark.into(),
        has_highlights: style.highlights.into(),
        is_sky_toneless: u32::from(!style.skyline),
        cell_px: inputs.cell_px as i32,
        ..Search::default()
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("search", recorder.uniform("tone search", &search)),
        ("blurred", inputs.blurred.into()),
        ("tone_sampler", super::bilinear(recorder)),
        ("tone_lines", inputs.tone_lines.into()),
    ];
    let definitions: &[&str] = if style.specular > 0.0 { &["SPECULAR"] } else { &[] };
    recorder.pixels(Compute { name: "lines/tone/search", definitions }, inputs.tone_lines.size_px(), &resources);
}
