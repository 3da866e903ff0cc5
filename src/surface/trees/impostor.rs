//! Draws impostors: trees and pieces of canopy that are drawn from pictures. See `shaders/surface/trees/impostor.wgsl`.

use super::raster::Inputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::{Drawing, Recorder};
use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR, TREE_LEVELS};

/// Vertices of the two triangles of an impostor.
pub(super) const CORNERS: u32 = 6;

/// Draws the impostors.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let draw = &inputs.variant("surface/trees/impostor");
    let mut drawings: Vec<(u32, Drawing)> = Vec::new();
    for (number, model) in inputs.trees.shared.species.iter().enumerate() {
        for (level, pictures) in [(IMPOSTOR, &model.alone), (CANOPY, &model.canopy)] {
            let bucket = number as u32 * TREE_LEVELS + level;
            let mut resources = inputs.resources(bucket);
            resources.extend([
                ("tree_pictures", Resource::Texture("tree pictures", pictures.view.clone())),
                ("tree_outlines", Resource::Texture("tree outlines", pictures.outlines.clone())),
                ("tree_outline_sampler", Resource::Sampler(pictures.sampler.clone())),
            ]);
            let colors = inputs.colored.map(|colored| colored.colors.species[number].of_pictures(level == CANOPY));
            resources.extend(colors.into_iter().flatten());
            drawings.push((bucket, recorder.drawing(draw, &resources)));
        }
    }
    inputs.draw(recorder, draw.name, &drawings);
}
