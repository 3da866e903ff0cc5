//! The ID reference image: edges as lines one pixel wide. See `shaders/lines/strokes/id_image.wgsl`.
//!
//! Why: `docs/decisions/edge-visibility.md`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Target, TargetKind};
use crate::surface::edges::EdgeList;

const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// An edge's number plus 1; 0 is none. Its size is [`image_px`](super::image_px).
pub const EDGE_IDS: TargetKind = TargetKind::attachment("edge ids", ID_FORMAT);
/// Of the edges, among themselves.
pub const EDGE_DEPTH: TargetKind = TargetKind::attachment("edge depth", DEPTH_FORMAT);

const DRAW: Draw = Draw {
    name: "lines/strokes/id_image",
    definitions: &[],
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    topology: wgpu::PrimitiveTopology::LineList,
};

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub depth: &'a Target,
    /// [`EDGE_IDS`].
    pub ids: &'a Target,
    /// [`EDGE_DEPTH`].
    pub edge_depth: &'a Target,
}

/// Draws as many edges as were counted.
pub fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let resources = [("view", inputs.view.clone()), edges.edges(), ("depth", inputs.depth.into())];
    let drawing = recorder.drawing(&DRAW, &resources);
    let on = Attachments { colors: &[inputs.ids], depth: Some(inputs.edge_depth), clears: Clears::All };
    recorder.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&edges.draw.raw, 0);
    });
}
