//! The normal that light falls on: the land's form at the scale of the picture. See `shaders/surface/form.wgsl`.
//!
//! Why: `docs/decisions/form-light.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::form::FormRules;
use crate::scene::Light;
use crate::style::Style;

/// xyz: unit normal in the world; w: distance along the view axis. All 0 is what is no land. Its size is
/// [`mark_normal_size`](super::mark_normal::mark_normal_size).
pub const FORM_NORMAL: TargetKind = TargetKind::storage("form normal", wgpu::TextureFormat::Rgba32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// Whose light it is.
    pub style: &'a Style,
    /// Where it comes from.
    pub light: &'a Light,
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Out.
    pub form_normal: &'a Target,
}

/// Finds the form of the land that the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
        ("position", inputs.position.into()),
        ("form_normal", inputs.form_normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/form", inputs.form_normal.size_px(), &resources);
}
