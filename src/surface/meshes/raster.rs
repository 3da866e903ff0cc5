//! Draws depth and surface ids of the meshes in view, over those of the land. See `shaders/surface/meshes/raster.wgsl`.

use super::DrawnMeshes;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::Target;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

const DRAW: Draw = Draw {
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    ..Draw::triangles("surface/meshes/raster")
};

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub meshes: &'a DrawnMeshes,
    pub depth: &'a Target,
    pub surface_id: &'a Target,
}

/// Draws the meshes.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone())];
    resources.extend(inputs.meshes.resources());
    let drawing = recorder.drawing(&DRAW, &resources);
    let on = Attachments { colors: &[inputs.surface_id], depth: Some(inputs.depth), clears: Clears::Nothing };
    recorder.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&inputs.meshes.draws.raw, 0);
    });
}
