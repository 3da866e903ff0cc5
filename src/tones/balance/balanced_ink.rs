//! The ink of marks. See `shaders/tones/balance/balanced_ink.wgsl`.

use super::{Inputs, Partner};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;

/// Computes `marks` from `cover` and `more`; with a partner, from the corrections of both eyes.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs, partner: Option<&Partner<'_>>) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("balance", inputs.balance.clone()),
        ("cover", (&inputs.cover).into()),
        ("more", (&inputs.more).into()),
        ("marks", (&inputs.marks).into()),
    ];
    if let Some(Partner { view, distance, more }) = partner {
        resources.extend([
            ("other_view", (*view).clone()),
            ("distance_m", (*distance).into()),
            ("other_more", (*more).into()),
        ]);
    }
    let definitions: &[&str] = if partner.is_some() { &["PAIR"] } else { &[] };
    let shader = Compute { name: "tones/balance/balanced_ink", definitions };
    recorder.pixels(shader, inputs.marks.size_px(), &resources);
}
