//! The surface's normal at the scale of marks. See `shaders/surface/mark_normal.wgsl`.
//!
//! This is the mark normal. Why: `docs/decisions/hatching.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::mark_normal::MarkRules;
use crate::style::hatching::Hatching;

/// xyz: unit normal in the world; w: distance along the view axis. All 0 is the sky. Its size is [`mark_normal_size`].
pub const MARK_NORMAL: TargetKind = TargetKind::storage("mark normal", wgpu::TextureFormat::Rgba32Float);

/// Side of the block of pixels that shares a texel.
pub(super) const BLOCK_PX: u32 = crate::gpu::wgsl::shared::mark_normal::BLOCK_PX as u32;

/// The size of the picture for targets of `size_px`: blocks are counted in the whole picture, so a part may see one
/// more at either end.
pub fn mark_normal_size(size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|side| side.div_ceil(BLOCK_PX) + 1)
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Whose marks they are.
    pub hatching: &'a Hatching,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// Where marks lie.
    pub position: &'a Target,
    /// What they shade: a mesh's own normal is its mark normal.
    pub normal: &'a Target,
    /// Out.
    pub mark_normal: &'a Target,
}

/// Finds the mark normal of what the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let hatching = inputs.hatching;
    let rules = MarkRules { form_px: hatching.form_px, calm: hatching.calm_deg.to_radians().tan() };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("mark_rules", recorder.uniform("mark rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("mark_normal", inputs.mark_normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/mark_normal", inputs.mark_normal.size_px(), &resources);
}
