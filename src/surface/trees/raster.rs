//! Draws the trees in view that are meshes: depth, surface id and normal. See `shaders/surface/trees/raster.wgsl`.

use super::DrawnTrees;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Cx, Drawing};
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::shared::trees::{MIDDLE, NEAR, TREE_LEVELS};
pub(super) use crate::gpu::wgsl::surface::trees::raster::TreeVertex;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

pub(super) const NORMAL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Of trees, where the surface id says that there is one; elsewhere it means nothing. Its last channel is lightness.
pub const TREE_NORMAL: TargetKind = TargetKind::attachment("tree normal", NORMAL_FORMAT);

pub(super) const FORM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Where a tree is seen, the normal of the round body that its crown fills; and how far behind the place that is seen the
/// plane lies that stands through the crown's middle and faces the eye, in metres along the view axis.
pub const TREE_FORM: TargetKind = TargetKind::attachment("tree form", FORM_FORMAT);

const DRAW: Draw = Draw {
    name: "surface/trees/raster",
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), replaced(NORMAL_FORMAT), replaced(FORM_FORMAT)],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// What the passes that draw trees read and where they write.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// For the curvature of the earth.
    pub terrain: Named,
    /// Those in view.
    pub trees: &'a DrawnTrees,
    /// As [`super::place`] reads them.
    pub species: &'a Resource,
    /// [`DEPTH`](crate::surface::DEPTH).
    pub depth: &'a Target,
    /// [`SURFACE_ID`](crate::surface::SURFACE_ID).
    pub surface_id: &'a Target,
    /// [`TREE_NORMAL`].
    pub tree_normal: &'a Target,
    /// [`TREE_FORM`].
    pub tree_form: &'a Target,
}

impl Inputs<'_> {
    /// Draws lists of trees, each by its species and level, over what is there.
    pub(super) fn draw(&self, cx: &mut Cx<'_>, name: &'static str, drawings: &[(u32, Drawing)]) {
        let all: Vec<&Drawing> = drawings.iter().map(|drawing| &drawing.1).collect();
        let colors = &[self.surface_id, self.tree_normal, self.tree_form];
        let on = Attachments { colors, depth: Some(self.depth), clears: Clears::Nothing };
        cx.render(name, &all, on, |pass| {
            for (bucket, drawing) in drawings {
                drawing.set(pass);
                self.trees.draw(pass, *bucket);
            }
        });
    }
}

/// Draws them.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let &Inputs { view, ref terrain, trees, species, .. } = inputs;
    let mut drawings: Vec<(u32, Drawing)> = Vec::new();
    for (number, model) in trees.shared.species.iter().enumerate() {
        for (level, mesh) in [(NEAR, &model.near), (MIDDLE, &model.middle)] {
            let bucket = number as u32 * TREE_LEVELS + level;
            let resources = [
                ("view", view.clone()),
                terrain.clone(),
                ("tree_instances", trees.instances.binding()),
                ("tree_order", trees.order_of(bucket).binding()),
                ("tree_species", species.clone()),
                ("tree_vertices", mesh.vertices.binding()),
            ];
            drawings.push((bucket, cx.drawing(&DRAW, &resources)));
        }
    }
    inputs.draw(cx, DRAW.name, &drawings);
}
