//! Draws strokes, solid or through a stroke texture. See `shaders/lines/strokes/stroke.wgsl`.

use super::Lists;
use super::samples::SampleWork;
use super::texture::StrokeTexture;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Target, TargetKind};

/// Ink: 0 none, 1 full. It is blended, which 32 bits are not everywhere.
const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// How much ink.
pub const INK: TargetKind = TargetKind::attachment("stroke ink", INK_FORMAT);
/// Whose: the number of the sample where the segment begins, plus 1. It lasts to the next frame.
pub const STROKE_IDS: TargetKind = TargetKind::attachment("stroke ids", wgpu::TextureFormat::R32Uint);

const DARKER: wgpu::BlendComponent = wgpu::BlendComponent {
    src_factor: wgpu::BlendFactor::One,
    dst_factor: wgpu::BlendFactor::One,
    operation: wgpu::BlendOperation::Max,
};
const SOLID: Draw = Draw {
    name: "lines/strokes/stroke",
    definitions: &[],
    fragment: "fragment",
    colors: [
        Some(wgpu::ColorTargetState {
            format: INK_FORMAT,
            blend: Some(wgpu::BlendState { color: DARKER, alpha: DARKER }),
            write_mask: wgpu::ColorWrites::ALL,
        }),
        replaced(wgpu::TextureFormat::R32Uint),
        None,
        None,
        None,
    ],
    depth: None,
    writes_depth: false,
    topology: wgpu::PrimitiveTopology::TriangleList,
};
const TEXTURED: Draw = Draw { fragment: "textured", ..SOLID };

/// Which strokes are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Of this frame's chains. The pictures are cleared first.
    Fresh,
    /// Those that are not seen any more.
    Fading,
}

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// `Focus`.
    pub focus: &'a Resource,
    /// For the style's numbers.
    pub lists: &'a Lists,
    /// What is drawn.
    pub work: &'a SampleWork,
    /// None draws solid strokes.
    pub texture: Option<&'a StrokeTexture>,
    /// [`INK`].
    pub ink: &'a Target,
    /// [`STROKE_IDS`].
    pub ids: &'a Target,
}

/// Draws strokes into the pictures: those of this frame's chains, on cleared pictures, or those that fade.
pub fn run(recorder: &mut Recorder<'_>, which: Which, inputs: &Inputs<'_>) {
    let stage = which as u32;
    let mut resources = vec![
        ("stage", recorder.uniform("stage", &stage)),
        ("view", inputs.view.clone()),
        ("focus", inputs.focus.clone()),
        inputs.lists.strokes(),
        inputs.work.list(),
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
