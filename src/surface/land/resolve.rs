//! Depth of the mesh → position and normal of the surface. See `shaders/surface/land/resolve.wgsl`.
//!
//! Why: `docs/decisions/resolve-pass.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// As it was rasterised.
    pub depth: &'a Target,
    /// Out.
    pub position: &'a Target,
    /// Out.
    pub normal: &'a Target,
}

/// Finds position and normal of every pixel.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("depth", inputs.depth.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/land/resolve", inputs.position.size_px(), &resources);
}
