//! The gradient of the picture's depth. See `shaders/tones/relief/gradient.wgsl`.

use super::{Inputs, Shared};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// xy: the gradient of inverse depth, in 1/m; z: inverse depth, in 1/m; w: the standard deviation of the blur, and
/// whether the neighbourhood is one surface, packed as by `packed` in `shaders/shared/relief.wgsl`. All 0 where there
/// is no relief.
pub(crate) const DEPTH_GRADIENT: TargetKind = TargetKind::storage(
    "depth gradient",
    wgpu::TextureFormat::Rgba32Float,
    Group::Tones.shows("Gradient of depth, whose curvature emphasises relief"),
);
/// [`DEPTH_GRADIENT`] between steps of the blur.
pub(crate) const BLURRED_GRADIENT: TargetKind = TargetKind::storage(
    "blurred gradient",
    wgpu::TextureFormat::Rgba32Float,
    Group::Tones.shows("Gradient of depth during its blur"),
);

/// Computes the gradient at the visible surface.
pub(super) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, shared: &Shared, depth_gradient: &Target) {
    let resources = [
        ("view", inputs.view.clone()),
        ("light", shared.light.clone()),
        ("relief_rules", shared.rules.clone()),
        ("focus", shared.focus.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("form_normal", inputs.form_normal.into()),
        ("depth_gradient", depth_gradient.into()),
    ];
    recorder.pixels("tones/relief/gradient", depth_gradient.size_px(), &resources);
}
