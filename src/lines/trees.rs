//! Which of the lines among trees are drawn. See `shaders/lines/trees.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::lines::trees::TreeLines as TreeLinesUniform;

/// As [`ERRORS`](super::detector::ERRORS), without those among trees that are not drawn.
pub const TREE_ERRORS: TargetKind = TargetKind::storage("tree errors", wgpu::TextureFormat::Rgba16Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of a tree in the mean.
    pub height_m: f64,
    /// Whether all other lines go.
    pub only_trees: bool,
    /// Of errors: where a line begins, and where it is full.
    pub ramp: [f32; 2],
    /// What is seen.
    pub surface_id: &'a Target,
    /// How near it is.
    pub depth: &'a Target,
    /// [`TREE_NORMAL`](crate::surface::trees::raster::TREE_NORMAL).
    pub tree_normal: &'a Target,
    /// Of the style's detector.
    pub errors: &'a Target,
    /// Out.
    pub tree_errors: &'a Target,
}

/// Chooses.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
