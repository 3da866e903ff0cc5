//! Draws impostors: trees and pieces of canopy that are drawn from pictures. See `shaders/surface/trees/impostor.wgsl`.

use super::list_of;
use super::raster::Inputs;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::Buffer;
use crate::gpu::pipelines::Draw;
use crate::gpu::recorder::{Drawing, Recorder};
use crate::gpu::target::{Group, TextureName};
use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR};
pub(super) use crate::gpu::wgsl::surface::trees::impostor::SIDES;

/// The pictures of trees.
pub(super) const PICTURES: TextureName = TextureName {
    name: "tree pictures",
    content: Group::Trees.shows("Pictures of trees from all sides: normal, depth and lightness"),
};
/// The outlines in the pictures of trees.
const OUTLINES: TextureName = TextureName {
    name: "tree outlines",
    content: Group::Trees.shows("Pictures of trees from all sides: depth and covered area"),
};

/// Draws the impostors.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let draw = &Draw {
        topology: wgpu::PrimitiveTopology::TriangleStrip,
        writes_farther: true,
        ..inputs.variant("surface/trees/impostor")
    };
    let mut drawings: Vec<(u32, Option<&Buffer>, Drawing)> = Vec::new();
    let shared = &inputs.trees.shared;
    // Single trees are nearer than pieces of canopy.
    for (level, pictures) in [(IMPOSTOR, &shared.alone), (CANOPY, &shared.canopy)] {
        let list = list_of(inputs.trees.species(), 0, level);
        let mut resources = inputs.resources(list);
        resources.extend([
            ("tree_pictures", Resource::Texture(PICTURES, pictures.texels.clone())),
            ("tree_outlines", Resource::Texture(OUTLINES, pictures.outlines.clone())),
            ("tree_outline_sampler", Resource::Sampler(pictures.sampler.clone())),
            ("tree_hulls", pictures.hulls.binding()),
        ]);
        let colors = inputs.colored.map(|colored| colored.colors.of_pictures(level == CANOPY));
        resources.extend(colors.into_iter().flatten());
        drawings.push((list, None, recorder.drawing(draw, &resources)));
    }
    inputs.draw(recorder, draw.name, &drawings);
}
