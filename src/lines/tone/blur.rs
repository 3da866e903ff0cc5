//! The tone image, blurred as wide as lines are: two passes. See `shaders/lines/tone/blur.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::blur::Blur;
use crate::style::ToneLines;

/// After the first pass: what [`TONE_IMAGE`](super::tone_image::TONE_IMAGE) holds, times how much is surface.
pub const ACROSS: TargetKind = TargetKind::storage("tone image across", wgpu::TextureFormat::Rgba16Float);
/// As [`TONE_IMAGE`](super::tone_image::TONE_IMAGE), with how much is surface in the last channel.
pub const BLURRED: TargetKind = TargetKind::storage("blurred tone image", wgpu::TextureFormat::Rgba16Float);

/// What the passes read and write.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Whose lines.
    pub style: &'a ToneLines,
    /// Side of a cell of the grid.
    pub cell_px: u32,
    /// [`TONE_IMAGE`](super::tone_image::TONE_IMAGE).
    pub tone_image: &'a Target,
    /// In between: [`ACROSS`].
    pub across: &'a Target,
    /// Out: [`BLURRED`].
    pub blurred: &'a Target,
}

/// Blurs it.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
