//! The missing ink of each cell. See `shaders/tones/balance/ink_sums.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// Cells of a workgroup.
const CELLS: u32 = 8;

/// Computes `sums` from `cover`.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs, sums: &Target) {
    let [columns, rows] = sums.size_px();
    let resources = [
        ("view", inputs.view.clone()),
        ("balance", inputs.balance.clone()),
        ("cover", (&inputs.cover).into()),
        ("sums", sums.into()),
    ];
    recorder.groups("tones/balance/ink_sums", [columns.div_ceil(CELLS), rows], &resources);
}
