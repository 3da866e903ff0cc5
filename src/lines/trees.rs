//! Selects the lines among trees that are drawn. See `shaders/lines/trees.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::lines::trees::TreeLines as TreeLinesUniform;

/// [`ERRORS`](super::detector::ERRORS) without the lines among trees that are not drawn.
pub(crate) const TREE_ERRORS: TargetKind = TargetKind::storage(
    "tree errors",
    wgpu::TextureFormat::Rgba16Float,
    Group::Trees.shows("Errors of the line detector without those among trees"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Mean height of a tree, in metres.
    pub height_m: f64,
    /// Whether all lines other than those of trees are removed.
    pub only_trees: bool,
    /// The error at which a line begins, and the error at which it is full.
    pub ramp: [f32; 2],
    pub surface_id: &'a Target,
    pub depth: &'a Target,
    pub tree_normal: &'a Target,
    /// The output of the style's detector.
    pub errors: &'a Target,
    pub tree_errors: &'a Target,
}

/// Removes the errors that do not become lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let uniform =
        TreeLinesUniform { height_m: inputs.height_m as f32, only_trees: inputs.only_trees.into(), ramp: inputs.ramp };
    let resources = [
        ("view", inputs.view.clone()),
        ("tree_lines", recorder.uniform("tree lines", &uniform)),
        ("surface_id", inputs.surface_id.into()),
        ("depth", inputs.depth.into()),
        ("errors", inputs.errors.into()),
        ("tree_normal", inputs.tree_normal.into()),
        ("tree_errors", inputs.tree_errors.into()),
    ];
    recorder.pixels("lines/trees", inputs.errors.size_px(), &resources);
}
