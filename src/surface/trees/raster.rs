//! Draws the trees in view that are meshes: depth, surface id and normal. See `shaders/surface/trees/raster.wgsl`.

use super::DrawnTrees;
use super::sway::{STEP_FORMAT, Swaying};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Cx, Drawing};
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::shared::trees::{MIDDLE, NEAR, TREE_LEVELS};
pub(super) use crate::gpu::wgsl::surface::trees::raster::TreeVertex;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

pub(super) const NORMAL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Of trees, where the surface id says that there is one; elsewhere it means nothing. Its last channel is lightness.
pub const TREE_NORMAL: TargetKind = TargetKind::attachment("tree normal", NORMAL_FORMAT);

const STANDING: Draw = Draw {
    name: "surface/trees/raster",
    definitions: &[],
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), replaced(NORMAL_FORMAT), None],
    depth: Some(DEPTH_FORMAT),
    topology: wgpu::PrimitiveTopology::TriangleList,
};
const SWAYING: Draw = Draw { definitions: SWAYING_DEFINITIONS, colors: SWAYING_COLORS, ..STANDING };

/// Of trees in wind.
pub(super) const SWAYING_DEFINITIONS: &[&str] = &["WIND"];
pub(super) const SWAYING_COLORS: [Option<wgpu::ColorTargetState>; 3] =
    [replaced(ID_FORMAT), replaced(NORMAL_FORMAT), replaced(STEP_FORMAT)];

/// What the passes that draw trees read and where they write.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// For the curvature of the earth.
    pub terrain: Named,
    /// Those in view.
    pub trees: &'a DrawnTrees,
    /// How they sway, if wind blows.
    pub swaying: Option<&'a Swaying>,
    /// As [`super::place`] reads them.
    pub species: &'a Resource,
    /// [`DEPTH`](crate::surface::DEPTH).
    pub depth: &'a Target,
    /// [`SURFACE_ID`](crate::surface::SURFACE_ID).
    pub surface_id: &'a Target,
    /// [`TREE_NORMAL`].
    pub tree_normal: &'a Target,
}

impl Inputs<'_> {
    /// Draws lists of trees, each by its species and level, over what is there.
    pub(super) fn draw(&self, cx: &mut Cx<'_>, name: &'static str, drawings: &[(u32, Drawing)]) {
        let all: Vec<&Drawing> = drawings.iter().map(|drawing| &drawing.1).collect();
        let mut colors = vec![self.surface_id, self.tree_normal];
        colors.extend(self.swaying.map(|swaying| &swaying.step));
        let colors = &colors;
        let on = Attachments { colors, depth: Some(self.depth), is_cleared: false };
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
    let &Inputs { view, ref terrain, trees, swaying, .. } = inputs;
    let draw = if swaying.is_some() { &SWAYING } else { &STANDING };
    let mut drawings: Vec<(u32, Drawing)> = Vec::new();
    for (species, model) in trees.shared.species.iter().enumerate() {
        for (level, mesh) in [(NEAR, &model.near), (MIDDLE, &model.middle)] {
            let bucket = species as u32 * TREE_LEVELS + level;
            let mut resources = vec![
                ("view", view.clone()),
                terrain.clone(),
                ("tree_instances", trees.instances.binding()),
                ("tree_order", trees.order_of(bucket).binding()),
                ("tree_vertices", mesh.vertices.binding()),
            ];
            resources.extend(swaying.into_iter().flat_map(Swaying::resources));
            drawings.push((bucket, cx.drawing(draw, &resources)));
        }
    }
    inputs.draw(cx, draw.name, &drawings);
}
