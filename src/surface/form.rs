//! The normal used for lighting: that of the land's form at the scale of the picture. See `shaders/surface/form.wgsl`.
//!
//! Why: `docs/decisions/form-light.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::form::FormRules;
use crate::scene::Light;
use crate::style::Style;

/// xyz: unit normal in world space; w: distance along the view axis. All 0 where there is no land. The size is
/// [`mark_normal_size`](super::mark_normal::mark_normal_size).
pub(crate) const FORM_NORMAL: TargetKind = TargetKind::storage(
    "form normal",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Normal of the smoothed land that is lit"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The style whose light settings apply.
    pub style: &'a Style,
    /// The direction of the sun.
    pub light: &'a Light,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub form_normal: &'a Target,
}

/// Computes the form normal of the visible land.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let shading = &inputs.style.light;
    let rules = FormRules {
        to_sun: inputs.light.to_sun.truncate().normalize_or_zero().as_vec2().to_array(),
        form_px: shading.form_px,
        turn_rad: shading.turn_deg.to_radians(),
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("form_rules", recorder.uniform("form rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("form_normal", inputs.form_normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/form", inputs.form_normal.size_px(), &resources);
}
