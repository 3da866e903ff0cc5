//! Exact screen-space motion of every pixel. See `shaders/surface/motion.wgsl`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// Motion from the previous frame to this one, in pixels: x right, y down.
pub(crate) const MOTION: TargetKind = TargetKind::storage(
    "motion",
    wgpu::TextureFormat::Rg32Float,
    Group::Surface.shows("Motion of each pixel since the frame before, in pixels"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub distance: &'a Target,
    /// Surface ids: the pixels of trees use `tree_step`.
    pub surface_id: &'a Target,
    /// [`TREE_STEP`](super::trees::sway::TREE_STEP), if wind moves trees.
    pub tree_step: Option<&'a Target>,
    pub motion: &'a Target,
}

/// Computes the motion of every pixel, including the sky.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources: Vec<Named> =
        vec![("view", inputs.view.clone()), ("distance_m", inputs.distance.into()), ("motion", inputs.motion.into())];
    let of_trees = |step: &Target| [("surface_id", inputs.surface_id.into()), ("tree_step", step.into())];
    resources.extend(inputs.tree_step.into_iter().flat_map(of_trees));
    let definitions: &[&str] = if inputs.tree_step.is_some() { &["WIND"] } else { &[] };
    recorder.pixels(Compute { name: "surface/motion", definitions }, inputs.motion.size_px(), &resources);
}
