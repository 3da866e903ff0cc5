//! Lines from tone: the scene is shaded, the shading is blurred as wide as lines are, and its valleys, ridges and edges are
//! lines (Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading").
//!
//! Why: `docs/decisions/tone-lines.md`.

pub mod along;
pub mod blur;
pub mod ink;
pub mod search;
pub mod tone_image;

use std::convert::Infallible;

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::style::ToneLines;

/// What lines are found in.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Which lines.
    pub style: &'a ToneLines,
    /// For what is surface: of each pixel, in the last channel.
    pub position: &'a Target,
    /// [`TONE_IMAGE`](tone_image::TONE_IMAGE), of [`cells`].
    pub tone_image: &'a Target,
}

/// Lines and blurs that are at least so wide, in pixels, have cells of 2 x 2 pixels.
const WIDE_PX: f32 = 3.0;
const WIDE_BLUR_PX: f32 = 1.0;

/// Side of a cell of the grid on which lines of a style are found: what is smaller than their blur is not looked for.
pub fn cell_px(style: &ToneLines) -> u32 {
    let narrowest_px = style.narrowest_px();
    if !style.exact && narrowest_px >= WIDE_PX && style.blur * narrowest_px >= WIDE_BLUR_PX { 2 } else { 1 }
}

/// How many cells the grid of a picture has.
pub fn cells(style: &ToneLines, size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|side_px| (side_px / cell_px(style)).max(1))
}

/// Finds the lines of a tone image: ink of dark lines and of highlight lines.
pub fn trace(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let &Inputs { view, style, position, tone_image } = inputs;
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
        ink::Inputs { view, style, cell_px, position, blurred: &blurred, tone_lines: &tone_lines, tone_ink: &tone_ink };
    ink::run(recorder, &drawn);
    tone_ink
}

/// Reads pictures between pixels.
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

/// The sampler of the passes that read between pixels; made once.
fn bilinear(recorder: &mut Recorder<'_>) -> Resource {
    let Ok(sampler) = recorder.kept(|_: &Bilinear| true, |gpu| Ok::<_, Infallible>(Bilinear::new(gpu)));
    Resource::Sampler(sampler.0.clone())
}
