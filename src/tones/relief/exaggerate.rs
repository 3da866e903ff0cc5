//! Exaggerated shading: relief at several scales at once. See `shaders/tones/relief/exaggerate.wgsl`.

use super::{Inputs, Shared};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::tones::relief::exaggerate::ExaggerateRules;

const RULES: BufferKind = BufferKind::storage("exaggerate rules");

/// Lights the visible surface.
pub(super) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, shared: &Shared, relief_light: &Target) {
    let relief = inputs.relief;
    let rules = ExaggerateRules {
        scales: relief.scales,
        finest_px: relief.finest_px,
        exaggeration: relief.exaggeration,
        coarser: relief.coarser,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("light", shared.light.clone()),
        ("exaggerate_rules", recorder.upload(&RULES, &[rules]).binding()),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("relief_light", relief_light.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("tones/relief/exaggerate", relief_light.size_px(), &resources);
}
