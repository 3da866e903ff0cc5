//! The rank that a line needs to be drawn (the bar). See `shaders/lines/crowd/bar.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;

/// Computes the bars of the cells from their counts.
pub(crate) fn run(recorder: &mut Recorder<'_>, view: &Resource, cells: &Cells) {
    let resources = [
        ("view", view.clone()),
        ("crowd", cells.crowd.clone()),
        ("counts", cells.counts.binding()),
        ("bars", (&cells.bars).into()),
    ];
    recorder.pixels("lines/crowd/bar", cells.bars.size_px(), &resources);
}
