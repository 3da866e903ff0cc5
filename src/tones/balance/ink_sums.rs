//! Ink that is wanting, in cells. See `shaders/tones/balance/ink_sums.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;

/// Of a workgroup.
const CELLS: u32 = 8;

/// From `cover` into `sums`.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs, sums: &Target) {
    let [columns, rows] = sums.size_px();
    let resources = [
        ("view", inputs.view.clone()),
        ("balance", inputs.balance.clone()),
        ("cover", (&inputs.cover).into()),
        ("sums", sums.into()),
    ];
    cx.groups("tones/balance/ink_sums", [columns.div_ceil(CELLS), rows], &resources);
}
