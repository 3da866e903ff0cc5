//! Blurs the tone image with a kernel as wide as the lines, in two passes. See `shaders/lines/tone/blur.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::blur::Blur;
use crate::style::ToneLines;

/// Result of the first pass: [`TONE_IMAGE`](super::tone_image::TONE_IMAGE), multiplied by the fraction that is surface.
pub(crate) const ACROSS: TargetKind = TargetKind::storage(
    "tone image across",
    wgpu::TextureFormat::Rgba16Float,
    Group::Lines.shows("Shaded image after the horizontal half of its blur"),
);
/// [`TONE_IMAGE`](super::tone_image::TONE_IMAGE) after the blur; the last channel is the fraction that is surface.
pub(crate) const BLURRED: TargetKind = TargetKind::storage(
    "blurred tone image",
    wgpu::TextureFormat::Rgba16Float,
    Group::Lines.shows("Shaded image after its blur"),
);

/// Inputs and outputs of the passes.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub style: &'a ToneLines,
    /// Side of a cell of the grid, in pixels.
    pub cell_px: u32,
    pub tone_image: &'a Target,
    /// The intermediate target: [`ACROSS`].
    pub across: &'a Target,
    pub blurred: &'a Target,
}

/// Blurs the tone image.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let ways = [([1, 0], inputs.tone_image, inputs.across), ([0, 1], inputs.across, inputs.blurred)];
    for (turn, (step, from, to)) in (0..).zip(ways) {
        let blur = Blur {
            step,
            is_last: turn,
            is_sky_white: style.skyline.into(),
            deviation: style.blur,
            widest_px: style.widest_px(),
            cell_px: inputs.cell_px as i32,
            ..Blur::default()
        };
        let resources = [
            ("view", inputs.view.clone()),
            ("blur", recorder.uniform("tone blur", &blur)),
            ("tone_image", from.into()),
            ("blurred", to.into()),
        ];
        recorder.pixels("lines/tone/blur", to.size_px(), &resources);
    }
}
