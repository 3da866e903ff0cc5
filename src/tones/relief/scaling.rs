//! Light scaled by curvature. See `shaders/tones/relief/scaling.wgsl`.

use super::{Inputs, Shared, lit_surface, shadows};
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::tones::relief::scaling::ScalingRules;

const RULES: BufferKind = BufferKind::storage("scaling rules");

/// Lights the visible surface. `slopes` is the blurred gradient of depth; without it curvature is zero.
pub(super) fn run(
    recorder: &mut Recorder<'_>,
    inputs: &Inputs<'_>,
    shared: &Shared,
    slopes: Option<&Target>,
    relief_light: &Target,
) {
    let rules = ScalingRules { strength: inputs.relief.scaling, invariant: inputs.relief.invariant };
    let mut resources = lit_surface(inputs, shared);
    resources.extend([
        ("relief_rules", shared.rules.clone()),
        ("scaling_rules", recorder.upload(&RULES, &[rules]).binding()),
        ("depth_gradient", slopes.unwrap_or(inputs.form_normal).into()),
        ("relief_light", relief_light.into()),
    ]);
    let definitions = defined(shadows(inputs));
    recorder.pixels(Compute { name: "tones/relief/scaling", definitions }, relief_light.size_px(), &resources);
}
