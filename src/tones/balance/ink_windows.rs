//! The factor by which marks must be drawn darker around each cell. See `shaders/tones/balance/ink_windows.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// Computes `more` from `sums`.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs, sums: &Target) {
    let resources = [("balance", inputs.balance.clone()), ("sums", sums.into()), ("more", (&inputs.more).into())];
    recorder.pixels("tones/balance/ink_windows", sums.size_px(), &resources);
}
