//! Distance and normal of trees, written over those of the land. See `shaders/surface/trees/resolve.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Surface ids, which identify the pixels of trees.
    pub surface_id: &'a Target,
    /// Depth as rasterised.
    pub depth: &'a Target,
    pub tree_normal: &'a Target,
    pub distance: &'a Target,
    /// [`NORMAL_AND_LIGHTNESS`](crate::surface::NORMAL_AND_LIGHTNESS).
    pub normal: &'a Target,
}

/// Writes `distance` and `normal` where a tree is seen.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("depth", inputs.depth.into()),
        ("tree_normal", inputs.tree_normal.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
    ];
    recorder.pixels("surface/trees/resolve", inputs.distance.size_px(), &resources);
}
