//! Dashed lines around holes in the land that is seen. See `shaders/surface/rims.wgsl`.
//!
//! Why: `docs/decisions/voids.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::rims::RimRules;
use crate::style::Rims;

/// Ink of the lines, 0 to 1; and 1 on land beside a hole.
pub const RIM: TargetKind = TargetKind::storage("rim", wgpu::TextureFormat::Rg32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// Widths and dashes.
    pub style: &'a Rims,
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out: [`RIM`].
    pub rim: &'a Target,
}

/// Draws the lines.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let period_px = style.dash_px + style.gap_px;
    let rules = RimRules { width_px: style.width_px, period_px, dash: style.dash_px / period_px };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("rim_rules", recorder.uniform("rim rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("rim", inputs.rim.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/rims", inputs.rim.size_px(), &resources);
}
