//! The shadows that trees throw. See `shaders/surface/trees/shadow.wgsl`.

use super::DrawnTrees;
use super::place::Asked;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Draw;
use crate::gpu::recorder::{Attachments, Clears, Cx, Drawing};
use crate::gpu::target::{Target, TargetKind};
pub(super) use crate::gpu::wgsl::surface::trees::shadow::CORNERS;
use crate::surface::DEPTH_FORMAT;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// How much of the sun trees take of what is seen: 0 to 1.
pub const TREE_SHADOW: TargetKind = TargetKind::attachment("tree shadow", FORMAT);

/// What is darker stays.
const DARKEST: wgpu::BlendComponent = wgpu::BlendComponent {
    src_factor: wgpu::BlendFactor::One,
    dst_factor: wgpu::BlendFactor::One,
    operation: wgpu::BlendOperation::Max,
};

const DRAW: Draw = Draw {
    name: "surface/trees/shadow",
    fragment: "fragment",
    colors: [
        Some(wgpu::ColorTargetState {
            format: FORMAT,
            blend: Some(wgpu::BlendState { color: DARKEST, alpha: DARKEST }),
            write_mask: wgpu::ColorWrites::ALL,
        }),
        None,
        None,
    ],
    depth: Some(DEPTH_FORMAT),
    writes_depth: false,
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// For the curvature of the earth.
    pub terrain: Named,
    /// Those in view, and those whose shadows are.
    pub trees: &'a DrawnTrees,
    /// As [`super::place`] reads it.
    pub asked: &'a Asked,
    /// With all that is seen.
    pub depth: &'a Target,
    /// The same.
    pub surface_id: &'a Target,
    /// Of what is seen.
    pub position: &'a Target,
    /// [`TREE_SHADOW`].
    pub tree_shadow: &'a Target,
}

/// Draws them.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let &Inputs { view, ref terrain, trees, asked, depth, surface_id, position, tree_shadow } = inputs;
    let mut drawings: Vec<Drawing> = Vec::new();
    for (species, model) in trees.shared.species.iter().enumerate() {
        let resources = [
            ("view", view.clone()),
            terrain.clone(),
            ("tree_instances", trees.instances.binding()),
            ("tree_order", trees.order_of(trees.list_of_shadows(species)).binding()),
            ("tree_species", asked.species.clone()),
            ("tree_pictures", Resource::Texture("tree pictures", model.alone.view.clone())),
            ("forest", asked.forest.clone()),
            ("surface_id", surface_id.into()),
            ("position", position.into()),
        ];
        drawings.push(cx.drawing(&DRAW, &resources));
    }
    let all: Vec<&Drawing> = drawings.iter().collect();
    let on = Attachments { colors: &[tree_shadow], depth: Some(depth), clears: Clears::Colors };
    cx.render(DRAW.name, &all, on, |pass| {
        for (species, drawing) in drawings.iter().enumerate() {
            drawing.set(pass);
            trees.draw(pass, trees.list_of_shadows(species));
        }
    });
}
