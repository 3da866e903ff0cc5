//! Merges edges that run side by side in the ID reference image into one line. See `shaders/lines/strokes/thin.wgsl`.
//!
//! Why: `docs/decisions/edge-visibility.md`.

use super::Lists;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::surface::edges::EdgeList;

/// The number of an edge plus 1, and bits that say what has been decided about the pixel; 0 where there is no edge. The
/// size is [`image_px`](super::image_px). The rounds alternate between the two targets.
pub(crate) const THINNED: [TargetKind; 2] = [
    TargetKind::storage(
        "thinned edge ids",
        wgpu::TextureFormat::R32Uint,
        Group::Strokes.shows("The edges of strokes, thinned to a width of one pixel"),
    ),
    TargetKind::storage(
        "edge ids in between",
        wgpu::TextureFormat::R32Uint,
        Group::Strokes.shows("The edges of strokes during a round of their thinning"),
    ),
];

/// Rounds of selection, enough for this many lines side by side; pixels undecided after the last round stay.
const ROUNDS: usize = 4;

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    /// The view uniform with which the edges were drawn.
    pub view: &'a Resource,
    /// Depth of the surface.
    pub depth: &'a Target,
    pub ids: &'a Target,
    /// The two targets; the first one holds the result.
    pub thinned: [&'a Target; 2],
}

/// Thins the reference image by the style's `merge_px`.
pub(crate) fn run(recorder: &mut Recorder<'_>, lists: &Lists, edges: &EdgeList, inputs: &Inputs<'_>) {
    for round in 0..ROUNDS {
        let to = inputs.thinned[(ROUNDS - 1 - round) % 2];
        let ids = if round == 0 { inputs.ids } else { inputs.thinned[(ROUNDS - round) % 2] };
        let resources = [
            ("view", inputs.view.clone()),
            lists.strokes(),
            edges.edges(),
            ("ids", ids.into()),
            ("depth", inputs.depth.into()),
            ("thinned", to.into()),
            ("is_last", recorder.uniform("is last", &u32::from(round + 1 == ROUNDS))),
        ];
        recorder.pixels("lines/strokes/thin", to.size_px(), &resources);
    }
}
