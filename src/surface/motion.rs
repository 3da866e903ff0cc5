//! Exact screen motion of every pixel. See `shaders/surface/motion.wgsl`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// Pixels from the previous frame to this one: x right, y down.
pub const MOTION: TargetKind = TargetKind::storage("motion", wgpu::TextureFormat::Rg32Float);

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub position: &'a Target,
    /// Which pixels show a tree.
    pub surface_id: &'a Target,
    /// [`TREE_STEP`](super::trees::sway::TREE_STEP), where wind moves trees.
    pub tree_step: Option<&'a Target>,
    /// Out.
    pub motion: &'a Target,
}

/// Finds the motion of every pixel, of the sky as well.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources: Vec<Named> =
        vec![("view", inputs.view.clone()), ("position", inputs.position.into()), ("motion", inputs.motion.into())];
    let of_trees = |step: &Target| [("surface_id", inputs.surface_id.into()), ("tree_step", step.into())];
    resources.extend(inputs.tree_step.into_iter().flat_map(of_trees));
    let definitions: &[&str] = if inputs.tree_step.is_some() { &["WIND"] } else { &[] };
    recorder.pixels(Compute { name: "surface/motion", definitions }, inputs.motion.size_px(), &resources);
}
