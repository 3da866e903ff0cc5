//! The ID reference image: edges as lines one pixel wide. See `shaders/lines/strokes/id_image.wgsl`.
//!
//! Why: `docs/decisions/edge-visibility.md`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};
use crate::surface::edges::EdgeList;

const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The number of an edge plus 1; 0 where there is no edge. The size is [`image_px`](super::image_px).
pub(crate) const EDGE_IDS: TargetKind = TargetKind::attachment(
    "edge ids",
    ID_FORMAT,
    Group::Strokes.shows("Edges of the surface from which strokes are chained, each in a colour of its own"),
);
/// Depth among the edges themselves.
pub(crate) const EDGE_DEPTH: TargetKind =
    TargetKind::attachment("edge depth", DEPTH_FORMAT, Group::Strokes.shows("Depth of the edges of the surface"));

const DRAW: Draw = Draw {
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    topology: wgpu::PrimitiveTopology::LineList,
    ..Draw::triangles("lines/strokes/id_image")
};

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Depth of the surface.
    pub depth: &'a Target,
    pub ids: &'a Target,
    pub edge_depth: &'a Target,
}

/// Draws the edges, with an indirect draw of as many as were counted.
pub(crate) fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let resources = [("view", inputs.view.clone()), edges.edges(), ("depth", inputs.depth.into())];
    let drawing = recorder.drawing(&DRAW, &resources);
    let on = Attachments { colors: &[inputs.ids], depth: Some(inputs.edge_depth), clears: Clears::All };
    recorder.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&edges.draw.raw, 0);
    });
}
