//! Counts the tones and the distances of the land in view. See `shaders/tones/fit/measure.wgsl`.

use crate::gpu::buffer::Buffer;
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::tones::fit::measure::STEP_PX;
use crate::tones::Inputs;

/// Adds the land in view to `counts`.
pub(super) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, water: Option<&Target>, counts: &Buffer) {
    let mut resources = inputs.lit_resources(recorder, water);
    resources.push(("tone_counts", counts.binding()));
    let definitions = defined(inputs.lit_definitions(water));
    let size_px = inputs.tone.size_px().map(|side| side.div_ceil(STEP_PX));
    recorder.pixels(Compute { name: "tones/fit/measure", definitions }, size_px, &resources);
}
