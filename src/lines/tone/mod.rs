//! Lines from tone: the scene is shaded, the shading is blurred as wide as lines are, and its valleys, ridges and edges are
//! lines (Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading").
//!
//! Why: `docs/decisions/tone-lines.md`.

pub mod blur;
pub mod search;
pub mod tone_image;

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, Targets};
use crate::style::ToneLines;

/// What lines are found in.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Which lines.
    pub style: &'a ToneLines,
    /// [`TONE_IMAGE`](tone_image::TONE_IMAGE).
    pub tone_image: &'a Target,
}

/// Finds the lines of a tone image; returns [`TONE_INK`](search::TONE_INK).
pub fn trace(cx: &mut Cx<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let &Inputs { view, style, tone_image } = inputs;
    let [across, blurred, tone_ink] =
        [&blur::ACROSS, &blur::BLURRED, &search::TONE_INK].map(|kind| targets.whole(cx.gpu(), kind));
    blur::run(cx, &blur::Inputs { view, style, tone_image, across: &across, blurred: &blurred });
    search::run(cx, &search::Inputs { view, style, tone_image, blurred: &blurred, tone_ink: &tone_ink });
    tone_ink
}
