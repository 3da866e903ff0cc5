//! Depth of the mesh → distance and normal of the surface. See `shaders/surface/land/resolve.wgsl`.
//!
//! Why: `docs/decisions/resolve-pass.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::surface::seen;

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// Depth of the mesh as rasterised.
    pub depth: &'a Target,
    pub distance: &'a Target,
    /// A picture of [`NORMAL`](seen::NORMAL) or [`NORMAL_AND_LIGHTNESS`](seen::NORMAL_AND_LIGHTNESS).
    pub normal: &'a Target,
}

/// Computes distance and normal of every pixel.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("depth", inputs.depth.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    let pass = Compute { name: "surface/land/resolve", definitions: seen::definitions(inputs.normal) };
    recorder.pixels(pass, inputs.distance.size_px(), &resources);
}
