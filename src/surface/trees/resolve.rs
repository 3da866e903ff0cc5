//! Position and normal of trees, over those of the land. See `shaders/surface/trees/resolve.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Which pixels show a tree.
    pub surface_id: &'a Target,
    /// As it was rasterised.
    pub depth: &'a Target,
    /// [`TREE_NORMAL`](super::raster::TREE_NORMAL).
    pub tree_normal: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
}

/// Writes `position` and `normal` where a tree is seen.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("depth", inputs.depth.into()),
        ("tree_normal", inputs.tree_normal.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
    ];
    recorder.pixels("surface/trees/resolve", inputs.position.size_px(), &resources);
}
