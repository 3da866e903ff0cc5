//! How the depth of the picture rises. See `shaders/tones/relief/gradient.wgsl`.

use super::{Inputs, Shared};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// xy: the gradient of inverse depth, in 1/m; z: inverse depth, in 1/m; w: how far it is to be blurred, and whether all
/// around is one surface, as `packed` in `shaders/shared/relief.wgsl` has them. All 0 is what has no relief.
pub const DEPTH_GRADIENT: TargetKind = TargetKind::storage("depth gradient", wgpu::TextureFormat::Rgba32Float);
/// The same between steps of the blur.
pub const BLURRED_GRADIENT: TargetKind = TargetKind::storage("blurred gradient", wgpu::TextureFormat::Rgba32Float);

/// Finds the gradient of what the inputs show.
pub(super) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, shared: &Shared, depth_gradient: &Target) {
    let resources = [
        ("view", inputs.view.clone()),
        ("light", shared.light.clone()),
        ("relief_rules", shared.rules.clone()),
        ("focus", shared.focus.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("form_normal", inputs.form_normal.into()),
        ("depth_gradient", depth_gradient.into()),
    ];
    recorder.pixels("tones/relief/gradient", depth_gradient.size_px(), &resources);
}
