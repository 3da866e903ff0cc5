//! Draws impostors: trees and pieces of canopy that are drawn from pictures. See `shaders/surface/trees/impostor.wgsl`.

use super::raster::{FORM_FORMAT, Inputs, NORMAL_FORMAT};
use super::sway::Swaying;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Drawing, Recorder};
use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR, TREE_LEVELS};
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

/// Vertices of the two triangles of an impostor.
pub(super) const CORNERS: u32 = 6;

const STANDING: Draw = Draw {
    name: "surface/trees/impostor",
    definitions: &[],
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), replaced(NORMAL_FORMAT), replaced(FORM_FORMAT), None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// Draws the impostors.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let &Inputs { view, ref terrain, trees, species, swaying, .. } = inputs;
    let draw = &inputs.variant(STANDING);
    let mut drawings: Vec<(u32, Drawing)> = Vec::new();
    for (number, model) in trees.shared.species.iter().enumerate() {
        for (level, pictures) in [(IMPOSTOR, &model.alone), (CANOPY, &model.canopy)] {
            let bucket = number as u32 * TREE_LEVELS + level;
            let mut resources = vec![
                ("view", view.clone()),
                terrain.clone(),
                ("tree_instances", trees.instances.binding()),
                ("tree_order", trees.order_of(bucket).binding()),
                ("tree_species", species.clone()),
                ("tree_pictures", Resource::Texture("tree pictures", pictures.view.clone())),
                ("tree_outlines", Resource::Texture("tree outlines", pictures.outlines.clone())),
                ("tree_outline_sampler", Resource::Sampler(pictures.sampler.clone())),
            ];
            resources.extend(swaying.into_iter().flat_map(Swaying::resources));
            let colors = inputs.colored.map(|colored| colored.colors.species[number].of_pictures(level == CANOPY));
            resources.extend(colors.into_iter().flatten());
            drawings.push((bucket, recorder.drawing(draw, &resources)));
        }
    }
    inputs.draw(recorder, draw.name, &drawings);
}
