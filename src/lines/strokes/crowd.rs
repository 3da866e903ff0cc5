//! Crowded strokes are thinned out, as lines of pixels are ([`crowd`](crate::lines::crowd)): by their samples.
//!
//! Each sample has a rank and counts its ink (`crowd_count`), a window of cells says which ranks are too many
//! ([`bar`]), and the pen is pressed less where a sample is below that (`crowd_thin`). Pressure is carried from frame to
//! frame and known to files of lines, so all of them leave the same strokes out. A pair of eyes leaves none out.

use super::samples::{GROUPS, SampleWork};
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, Targets};
use crate::lines::crowd::{Cap, Cells, bar};

/// Thins the strokes of this frame, before they take over from the frame before. `view` has no jitter of its own but
/// tells that of `depth`.
pub fn run(cx: &mut Cx<'_>, view: &Resource, depth: &Target, work: &SampleWork, cap: Cap, targets: &mut Targets) {
    let cells = Cells::new(cx, targets, cap);
    let crowd = || ("crowd", cells.crowd.clone());
    let counts = || ("counts", cells.counts.binding());
    cx.pixels("lines/crowd/clear", cells.bars.size_px(), &[crowd(), counts()]);
    let resources = [("view", view.clone()), crowd(), ("depth", depth.into()), work.list(), work.samples(), counts()];
    cx.groups("lines/strokes/crowd_count", GROUPS, &resources);
    bar::run(cx, view, &cells);
    let resources = [("view", view.clone()), crowd(), ("bars", (&cells.bars).into()), work.list(), work.samples()];
    cx.groups("lines/strokes/crowd_thin", GROUPS, &resources);
}
