//! Density control of strokes, by their samples; for lines of pixels see [`crowd`](crate::lines::crowd).
//!
//! Each sample has a rank and counts its ink (`crowd_count`), the [`bar`] of a window of cells separates the ranks that
//! are drawn from those that are too many, and the pen is pressed less where a sample is below the bar (`crowd_thin`).
//! Pressure is carried from frame to frame and written to vector files, so all of them leave out the same strokes.
//!
//! The second eye of a stereo pair has no bars of its own: it reads those of the leading eye at the positions of its
//! samples in that eye's picture, so that both leave out the same strokes. Surfaces near a stereo pair are not thinned.

use super::samples::SampleWork;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::lines::crowd::{Cap, Cells, bar};

/// Inputs of the density control of strokes.
pub(crate) struct Inputs<'a> {
    /// The view without jitter of its own; it states the jitter of `depth`.
    pub view: &'a Resource,
    /// Depth of the surface.
    pub depth: &'a Target,
    /// The samples of this frame.
    pub work: &'a SampleWork,
    pub cap: Cap,
    /// Distance to the other eye of a stereo pair, in metres; 0 if there is none.
    pub apart_m: f32,
    /// The leading eye's `View` and its cells, if this is the second eye of a pair.
    pub leader: Option<(&'a Resource, &'a Cells)>,
}

/// Thins the strokes of this frame, before they continue those of the previous frame. Returns the cells that were
/// counted.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Cells {
    let &Inputs { view, depth, work, cap, apart_m, leader } = inputs;
    let cells = Cells::new(recorder, targets, cap, apart_m);
    let crowd = || ("crowd", cells.crowd.clone());
    let counts = || ("counts", cells.counts.binding());
    recorder.pixels("lines/crowd/clear", cells.bars.size_px(), &[crowd(), counts()]);
    let resources =
        [("view", view.clone()), crowd(), ("depth", depth.into()), work.sample_counts(), work.samples(), counts()];
    let (arguments, offset) = work.per_fresh();
    recorder.indirect("lines/strokes/crowd_count", arguments, offset, &resources);
    // The second eye counts only to rank its samples.
    if leader.is_none() {
        bar::run(recorder, view, &cells);
    }
    let definitions: &[&str] = if leader.is_some() { &["FOLLOWER"] } else { &[] };
    let of = leader.map_or(&cells, |(_, cells)| cells);
    let (crowd, bars) = (("crowd", of.crowd.clone()), ("bars", (&of.bars).into()));
    let mut resources = vec![("view", view.clone()), crowd, bars, work.sample_counts(), work.samples()];
    resources.extend(leader.map(|(view, _)| ("other_view", view.clone())));
    recorder.indirect(Compute { name: "lines/strokes/crowd_thin", definitions }, arguments, offset, &resources);
    cells
}
