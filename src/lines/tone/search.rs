//! Valleys, ridges and edges of the tone image. See `shaders/lines/tone/search.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::search::Search;
use crate::style::ToneLines;

/// Ink of dark lines and of highlight lines, 0 to 1; and the direction of the line, a unit vector on the picture.
pub const TONE_INK: TargetKind = TargetKind::storage("tone ink", wgpu::TextureFormat::Rgba16Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Which lines.
    pub style: &'a ToneLines,
    /// For what is surface.
    pub tone_image: &'a Target,
    /// [`BLURRED`](super::blur::BLURRED).
    pub blurred: &'a Target,
    /// Out.
    pub tone_ink: &'a Target,
}

/// Finds the lines.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let search = Search {
        dark_ramp: style.dark_ramp,
        highlight_ramp: style.highlight_ramp,
        beta: style.step_part(),
        softness: style.softness,
        counterchange: style.counterchange,
        roundest: style.roundest,
        has_dark: style.dark.into(),
        has_highlights: style.highlights.into(),
        is_sky_toneless: u32::from(!style.skyline),
        ..Search::default()
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("search", cx.uniform("tone search", &search)),
        ("tone_image", inputs.tone_image.into()),
        ("blurred", inputs.blurred.into()),
        ("tone_sampler", super::bilinear(cx)),
        ("tone_ink", inputs.tone_ink.into()),
    ];
    let definitions: &[&str] = if style.specular > 0.0 { &["SPECULAR"] } else { &[] };
    cx.pixels(Compute { name: "lines/tone/search", definitions }, inputs.tone_ink.size_px(), &resources);
}
