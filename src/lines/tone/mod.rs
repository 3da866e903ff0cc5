//! Lines from shading: the scene is shaded, the shading is blurred with a kernel as wide as the lines, and its valleys,
//! ridges and edges become lines (Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading").
//!
//! Why: `docs/decisions/tone-lines.md`.

pub(crate) mod along;
pub(crate) mod blur;
pub(crate) mod ink;
pub(crate) mod search;
pub(crate) mod tone_image;

use std::convert::Infallible;

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::style::ToneLines;

/// Inputs of the passes.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub style: &'a ToneLines,
    /// Position; its last channel is 0 where there is no surface.
    pub distance: &'a Target,
    /// [`TONE_IMAGE`](tone_image::TONE_IMAGE), whose size is given by [`cells`].
    pub tone_image: &'a Target,
}

/// Lines and blurs at least this wide, in pixels, are found on a grid of 2 × 2 pixels per cell.
const WIDE_PX: f32 = 3.0;
const WIDE_BLUR_PX: f32 = 1.0;

/// Returns the side of a cell, in pixels, of the grid on which a style's lines are found. Details smaller than the blur
/// need not be resolved.
pub(crate) fn cell_px(style: &ToneLines) -> u32 {
    let narrowest_px = style.narrowest_px();
    if !style.exact && narrowest_px >= WIDE_PX && style.blur * narrowest_px >= WIDE_BLUR_PX { 2 } else { 1 }
}

/// Returns the number of cells of a picture's grid, across and down.
pub(crate) fn cells(style: &ToneLines, size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|side_px| (side_px / cell_px(style)).max(1))
}

/// Finds the lines of a tone image; returns the ink of dark lines and of highlight lines.
pub(crate) fn trace(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let &Inputs { view, style, distance, tone_image } = inputs;
    let cell_px = cell_px(style);
    let mut of_cells = |kind| targets.sized(recorder.gpu(), kind, tone_image.size_px());
    let [across, blurred, found] = [&blur::ACROSS, &blur::BLURRED, &search::TONE_LINES].map(&mut of_cells);
    blur::run(recorder, &blur::Inputs { view, style, cell_px, tone_image, across: &across, blurred: &blurred });
    search::run(recorder, &search::Inputs { view, style, cell_px, blurred: &blurred, tone_lines: &found });
    let tone_lines = if style.shortest_px > 0.0 {
        let long_lines = targets.sized(recorder.gpu(), &along::LONG_LINES, tone_image.size_px());
        along::run(recorder, &along::Inputs { view, style, cell_px, tone_lines: &found, long_lines: &long_lines });
        long_lines
    } else {
        found
    };
    let tone_ink = targets.whole(recorder.gpu(), &ink::TONE_INK);
    let drawn =
        ink::Inputs { view, style, cell_px, distance, blurred: &blurred, tone_lines: &tone_lines, tone_ink: &tone_ink };
    ink::run(recorder, &drawn);
    tone_ink
}

/// A bilinear sampler.
struct Bilinear(wgpu::Sampler);

impl Bilinear {
    fn new(gpu: &Gpu) -> Self {
        Self(gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("tone image"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        }))
    }
}

/// Returns the sampler of the passes that read between pixels; it is created once.
fn bilinear(recorder: &mut Recorder<'_>) -> Resource {
    let Ok(sampler) = recorder.cached(|_: &Bilinear| true, |gpu| Ok::<_, Infallible>(Bilinear::new(gpu)));
    Resource::Sampler(sampler.0.clone())
}
