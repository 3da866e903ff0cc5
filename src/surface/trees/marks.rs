//! The distance and normal that hatching marks use where a tree is seen. See `shaders/surface/trees/marks.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// [`DISTANCE`](crate::surface::DISTANCE) for hatching marks: those of a tree are placed on a plane that faces the eye.
pub(crate) const MARK_DISTANCE: TargetKind = TargetKind::storage(
    "mark distance",
    wgpu::TextureFormat::R32Float,
    Group::Trees.shows("Distance for hatching marks, for which trees are flat, in metres"),
);
/// [`NORMAL_AND_LIGHTNESS`](crate::surface::NORMAL_AND_LIGHTNESS) for hatching marks: a tree has the normal of its rounded body, and a lightness of
/// −1.
pub(crate) const MARK_SURFACE: TargetKind = TargetKind::storage(
    "mark surface",
    wgpu::TextureFormat::Rg32Uint,
    Group::Trees.shows("Normal for hatching marks, for which crowns are rounded").with_float_words(0b10),
);

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Surface ids, which identify the pixels of trees.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    pub tree_form: &'a Target,
    pub mark_distance: &'a Target,
    pub mark_surface: &'a Target,
}

/// Writes `mark_distance` and `mark_surface`.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("tree_form", inputs.tree_form.into()),
        ("mark_distance_m", inputs.mark_distance.into()),
        ("mark_surface", inputs.mark_surface.into()),
    ];
    recorder.pixels("surface/trees/marks", inputs.mark_distance.size_px(), &resources);
}
