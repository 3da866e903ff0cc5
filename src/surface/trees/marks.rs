//! Where marks lie on trees, and what they shade. See `shaders/surface/trees/marks.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// As [`POSITION`](crate::surface::POSITION), for marks: those of a tree lie on a plane that faces the eye.
pub const MARK_PLACE: TargetKind = TargetKind::storage("mark place", wgpu::TextureFormat::Rgba32Float);
/// As [`NORMAL`](crate::surface::NORMAL), for marks: a tree has that of its round body, and −1 for lightness.
pub const MARK_SURFACE: TargetKind = TargetKind::storage("mark surface", wgpu::TextureFormat::Rgba32Float);

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Which pixels show a tree.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// [`TREE_FORM`](super::raster::TREE_FORM).
    pub tree_form: &'a Target,
    /// [`MARK_PLACE`].
    pub mark_place: &'a Target,
    /// [`MARK_SURFACE`].
    pub mark_surface: &'a Target,
}

/// Writes `mark_place` and `mark_surface`.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("tree_form", inputs.tree_form.into()),
        ("mark_place", inputs.mark_place.into()),
        ("mark_surface", inputs.mark_surface.into()),
    ];
    recorder.pixels("surface/trees/marks", inputs.mark_place.size_px(), &resources);
}
