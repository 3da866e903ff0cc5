//! Depth of the mesh → position and normal of the surface. See `shaders/surface/land/resolve.wgsl`.
//!
//! Why: `docs/decisions/resolve-pass.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// Depth of the mesh as rasterised.
    pub depth: &'a Target,
    pub position: &'a Target,
    pub normal: &'a Target,
}

/// Computes position and normal of every pixel.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("depth", inputs.depth.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/land/resolve", inputs.position.size_px(), &resources);
}
