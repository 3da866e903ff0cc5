//! Contour lines of height on the visible land. See `shaders/surface/height_lines.wgsl`.
//!
//! Why: `docs/decisions/maps.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::height_lines::HeightLineRules;
use crate::style::HeightLines;

/// Ink of the contour lines, 0 to 1.
pub const HEIGHT_INK: TargetKind = TargetKind::storage("height ink", wgpu::TextureFormat::R32Float);

/// Every fifth contour line is an index line, which is heavier.
const INDEX: f64 = 5.0;

/// Inputs and output of the pass.
pub struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The style of the contour lines; `interval_m` must be above 0.
    pub style: &'a HeightLines,
    /// Height of the rig's origin, to which heights on the GPU are relative.
    pub origin_z_m: f64,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub position: &'a Target,
    /// [`WATER`](super::water::WATER), or a 1 × 1 picture that holds zero.
    pub water: &'a Target,
    /// [`HEIGHT_INK`].
    pub height_ink: &'a Target,
}

/// Draws the contour lines.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let index_m = INDEX * f64::from(style.interval_m);
    let rules = HeightLineRules {
        interval_m: style.interval_m,
        phase_m: inputs.origin_z_m.rem_euclid(index_m) as f32,
        line_px: style.line_px,
        index_px: style.index_px,
        form_px: style.form_px,
        index: INDEX as f32,
        steepest: if style.steepest_deg < 90.0 { style.steepest_deg.to_radians().tan() } else { 1e9 },
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("height_line_rules", recorder.uniform("height line rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("water", inputs.water.into()),
        ("height_ink", inputs.height_ink.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/height_lines", inputs.height_ink.size_px(), &resources);
}
