//! Dashed lines around holes in the visible land. See `shaders/surface/rims.wgsl`.
//!
//! Why: `docs/decisions/voids.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::rims::RimRules;
use crate::style::Rims;

/// x: ink of the lines, 0 to 1; y: 1 on land next to a hole, else 0.
pub(crate) const RIM: TargetKind = TargetKind::storage(
    "rim",
    wgpu::TextureFormat::Rg32Float,
    Group::Surface.shows("Dashed lines along areas without data, and the land next to them"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// Widths and dashes.
    pub style: &'a Rims,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// [`RIM`].
    pub rim: &'a Target,
}

/// Draws the lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let period_px = style.dash_px + style.gap_px;
    let rules = RimRules { width_px: style.width_px, period_px, dash: style.dash_px / period_px };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("rim_rules", recorder.uniform("rim rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("rim", inputs.rim.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/rims", inputs.rim.size_px(), &resources);
}
