//! Draws the meshes in view: depth and surface id, over those of the land. See `shaders/surface/meshes/raster.wgsl`.

use super::DrawnMeshes;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::Target;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

const DRAW: Draw = Draw {
    name: "surface/meshes/raster",
    definitions: &[],
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// The meshes and their vertices.
    pub meshes: &'a DrawnMeshes,
    /// [`DEPTH`](crate::surface::DEPTH).
    pub depth: &'a Target,
    /// [`SURFACE_ID`](crate::surface::SURFACE_ID).
    pub surface_id: &'a Target,
}

/// Draws them.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone())];
    resources.extend(inputs.meshes.resources());
    let drawing = recorder.drawing(&DRAW, &resources);
    let on = Attachments { colors: &[inputs.surface_id], depth: Some(inputs.depth), clears: Clears::Nothing };
    recorder.render(DRAW.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&inputs.meshes.draws.raw, 0);
    });
}
