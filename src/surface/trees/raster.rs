//! Draws the trees in view: depth, surface id and normal. See `shaders/surface/trees/raster.wgsl`.

use super::DrawnTrees;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Cx};
use crate::gpu::target::{Target, TargetKind};
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

const NORMAL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Of trees, where the surface id says that there is one; elsewhere it means nothing.
pub const TREE_NORMAL: TargetKind = TargetKind::attachment("tree normal", NORMAL_FORMAT);

const DRAW: Draw = Draw {
    name: "surface/trees/raster",
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), replaced(NORMAL_FORMAT)],
    depth: Some(DEPTH_FORMAT),
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// For the curvature of the earth.
    pub terrain: Named,
    /// Those in view.
    pub trees: &'a DrawnTrees,
    /// [`DEPTH`](crate::surface::DEPTH).
    pub depth: &'a Target,
    /// [`SURFACE_ID`](crate::surface::SURFACE_ID).
    pub surface_id: &'a Target,
    /// [`TREE_NORMAL`].
    pub tree_normal: &'a Target,
}

/// Draws them.
pub fn run(cx: &mut Cx<'_>, inputs: Inputs<'_>) {
    let Inputs { view, terrain, trees, depth, surface_id, tree_normal } = inputs;
    let resources = [
        ("view", view.clone()),
        terrain,
        ("tree_instances", trees.instances.binding()),
        ("tree_vertices", trees.shared.vertices.binding()),
    ];
    let drawing = cx.drawing(&DRAW, &resources);
    let on = Attachments { colors: &[surface_id, tree_normal], depth: Some(depth), is_cleared: false };
    cx.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&trees.draw.raw, trees.draw.offset);
    });
}
