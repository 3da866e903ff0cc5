//! Draws strokes, solid or through a stroke texture. See `shaders/lines/strokes/stroke.wgsl`.

use super::Lists;
use super::samples::SampleWork;
use super::texture::StrokeTexture;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, greatest, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};

/// The format of [`INK`], with 16 bits because it is blended, which not every GPU supports for 32-bit floats.
const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// Amount of ink: 0 none, 1 full.
pub(crate) const INK: TargetKind = TargetKind::attachment("stroke ink", INK_FORMAT, Group::Ink.shows("Ink of strokes"));
/// The stroke that inks each pixel: the number of the sample at which the segment begins, plus 1. It is kept until the
/// next frame.
pub(crate) const STROKE_IDS: TargetKind = TargetKind::attachment(
    "stroke ids",
    wgpu::TextureFormat::R32Uint,
    Group::Strokes.shows("Strokes as they are drawn, each sample in a colour of its own"),
);

const SOLID: Draw = Draw {
    colors: [greatest(INK_FORMAT), replaced(wgpu::TextureFormat::R32Uint), None, None, None],
    ..Draw::triangles("lines/strokes/stroke")
};
const TEXTURED: Draw = Draw { fragment: "textured", ..SOLID };

/// The strokes that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Which {
    /// The strokes of this frame's chains. The targets are cleared first.
    Fresh,
    /// Strokes that are no longer visible and fade out.
    Fading,
}

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub focus: &'a Resource,
    /// The lists, for the style's uniform.
    pub lists: &'a Lists,
    /// The samples to draw.
    pub work: &'a SampleWork,
    /// The stroke texture; `None` draws solid strokes.
    pub texture: Option<&'a StrokeTexture>,
    pub ink: &'a Target,
    /// The output: [`STROKE_IDS`].
    pub ids: &'a Target,
}

/// Draws strokes into the targets: those of this frame's chains, on cleared targets, or those that fade.
pub(crate) fn run(recorder: &mut Recorder<'_>, which: Which, inputs: &Inputs<'_>) {
    let stage = which as u32;
    let mut resources = vec![
        ("stage", recorder.uniform("stage", &stage)),
        ("view", inputs.view.clone()),
        ("focus", inputs.focus.clone()),
        inputs.lists.strokes(),
        inputs.work.sample_counts(),
        inputs.work.samples(),
    ];
    let mut kind = &SOLID;
    if let Some(texture) = inputs.texture {
        kind = &TEXTURED;
        resources.extend(texture.resources());
    }
    let drawing = recorder.drawing(kind, &resources);
    let on = Attachments {
        colors: &[inputs.ink, inputs.ids],
        depth: None,
        clears: if which == Which::Fresh { Clears::All } else { Clears::Nothing },
    };
    recorder.render(kind.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&inputs.work.now.draws.raw, 16 * u64::from(stage));
    });
}
