//! Edges that run side by side in the ID reference image become one line. See `shaders/lines/strokes/thin.wgsl`.
//!
//! Why: `docs/decisions/edge-visibility.md`.

use super::Lists;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::surface::edges::EdgeList;

/// An edge's number plus 1, and beside it what is decided of the pixel; 0 is none. Its size is
/// [`image_px`](super::image_px). Rounds take turns.
pub const THINNED: [TargetKind; 2] = [
    TargetKind::storage("thinned edge ids", wgpu::TextureFormat::R32Uint),
    TargetKind::storage("edge ids in between", wgpu::TextureFormat::R32Uint),
];

/// Of lines side by side so many are told from each other.
const ROUNDS: usize = 4;

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`, as edges were drawn with.
    pub view: &'a Resource,
    /// Of the surface.
    pub depth: &'a Target,
    /// [`EDGE_IDS`](super::id_image::EDGE_IDS).
    pub ids: &'a Target,
    /// [`THINNED`]; the first holds the result.
    pub thinned: [&'a Target; 2],
}

/// Thins the reference image by the style's `merge_px`.
pub fn run(recorder: &mut Recorder<'_>, lists: &Lists, edges: &EdgeList, inputs: &Inputs<'_>) {
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
