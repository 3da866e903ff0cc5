//! Lines from tone without crumbs. See `shaders/lines/tone/along.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::along::{Along, STEP_PX, STEPS};
use crate::style::ToneLines;

/// As [`TONE_INK`](super::search::TONE_INK), without short lines.
pub const LONG_INK: TargetKind = TargetKind::storage("long tone ink", wgpu::TextureFormat::Rgba16Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// How long lines are at least.
    pub style: &'a ToneLines,
    /// [`TONE_INK`](super::search::TONE_INK).
    pub tone_ink: &'a Target,
    /// Out.
    pub long_ink: &'a Target,
}

/// Leaves out what is short.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let shortest_px = inputs.style.shortest_px;
    let step_px = (shortest_px / STEPS as f32).max(STEP_PX);
    let along = Along { shortest_px, step_px, steps: (shortest_px / step_px).ceil() as i32, ..Along::default() };
    let resources = [
        ("view", inputs.view.clone()),
        ("along", cx.uniform("tone along", &along)),
        ("tone_sampler", super::bilinear(cx)),
        ("tone_ink", inputs.tone_ink.into()),
        ("long_ink", inputs.long_ink.into()),
    ];
    cx.pixels("lines/tone/along", inputs.long_ink.size_px(), &resources);
}
