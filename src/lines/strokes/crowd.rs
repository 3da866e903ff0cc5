//! Crowded strokes are thinned out, as lines of pixels are ([`crowd`](crate::lines::crowd)): by their samples.
//!
//! Each sample has a rank and counts its ink (`crowd_count`), a window of cells says which ranks are too many
//! ([`bar`]), and the pen is pressed less where a sample is below that (`crowd_thin`). Pressure is carried from frame to
//! frame and known to files of lines, so all of them leave the same strokes out.
//!
//! The second eye of a pair has no bars of its own: it reads those of the leading one where its samples lie in that
//! picture, so that both leave out the same strokes. What is near a pair of eyes is left as it is.

use super::samples::{GROUPS, SampleWork};
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::lines::crowd::{Cap, Cells, bar};

/// Whose strokes are thinned.
pub struct Inputs<'a> {
    /// `View`: it has no jitter of its own but tells that of `depth`.
    pub view: &'a Resource,
    /// Of the surface.
    pub depth: &'a Target,
    /// Of this frame.
    pub work: &'a SampleWork,
    /// What is left of them.
    pub cap: Cap,
    /// To the other eye of a pair; 0 is none.
    pub apart_m: f32,
    /// The leading eye's `View` and its cells, if this is the second one of a pair.
    pub leader: Option<(&'a Resource, &'a Cells)>,
}

/// Thins the strokes of this frame, before they take over from the frame before. Returns the cells whose bars it took.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Cells {
    let &Inputs { view, depth, work, cap, apart_m, leader } = inputs;
    let cells = Cells::new(recorder, targets, cap, apart_m);
    let crowd = || ("crowd", cells.crowd.clone());
    let counts = || ("counts", cells.counts.binding());
    recorder.pixels("lines/crowd/clear", cells.bars.size_px(), &[crowd(), counts()]);
    let resources = [("view", view.clone()), crowd(), ("depth", depth.into()), work.list(), work.samples(), counts()];
    recorder.groups("lines/strokes/crowd_count", GROUPS, &resources);
    // The second eye counts for the ranks alone.
    if leader.is_none() {
        bar::run(recorder, view, &cells);
    }
    let definitions: &[&str] = if leader.is_some() { &["FOLLOWER"] } else { &[] };
    let of = leader.map_or(&cells, |(_, cells)| cells);
    let (crowd, bars) = (("crowd", of.crowd.clone()), ("bars", (&of.bars).into()));
    let mut resources = vec![("view", view.clone()), crowd, bars, work.list(), work.samples()];
    resources.extend(leader.map(|(view, _)| ("other_view", view.clone())));
    recorder.groups(Compute { name: "lines/strokes/crowd_thin", definitions }, GROUPS, &resources);
    cells
}
