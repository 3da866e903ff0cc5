//! The ink of marks. See `shaders/tones/balance/balanced_ink.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Cx;

/// From `cover` and `more` into `marks`.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs) {
    let resources = [
        ("view", inputs.view.clone()),
        ("balance", inputs.balance.clone()),
        ("cover", (&inputs.cover).into()),
        ("more", (&inputs.more).into()),
        ("marks", (&inputs.marks).into()),
    ];
    cx.pixels("tones/balance/balanced_ink", inputs.marks.size_px(), &resources);
}
