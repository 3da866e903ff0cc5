//! The mark normal: the surface normal at the scale of hatching marks. See `shaders/surface/mark_normal.wgsl`.
//!
//! Why: `docs/decisions/hatching.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::mark_normal::MarkRules;
use crate::style::hatching::Hatching;

/// xyz: unit normal in world space; w: distance along the view axis. All 0 in the sky. The size is
/// [`mark_normal_size`].
pub(crate) const MARK_NORMAL: TargetKind = TargetKind::storage(
    "mark normal",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Normal of the smoothed land that hatching marks follow"),
);

/// Side of the block of pixels that shares one texel.
pub(super) const BLOCK_PX: u32 = crate::gpu::wgsl::shared::mark_normal::BLOCK_PX as u32;

/// Returns the size of the target for pictures of `size_px`. Blocks are aligned to the whole picture, so a part of it
/// may overlap one more block at either end.
pub(crate) fn mark_normal_size(size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|side| side.div_ceil(BLOCK_PX) + 1)
}

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The hatching whose marks use the normals.
    pub hatching: &'a Hatching,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    /// Position of the marks.
    pub distance: &'a Target,
    /// Normal of the surface; the mark normal of a mesh is its own normal.
    pub normal: &'a Target,
    pub mark_normal: &'a Target,
}

/// Computes the mark normals of the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let hatching = inputs.hatching;
    let rules = MarkRules { form_px: hatching.form_px, calm: hatching.calm_deg.to_radians().tan() };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("mark_rules", recorder.uniform("mark rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("mark_normal", inputs.mark_normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/mark_normal", inputs.mark_normal.size_px(), &resources);
}
