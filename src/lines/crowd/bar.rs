//! How much a line must matter to be drawn. See `shaders/lines/crowd/bar.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;

/// From the cells' counts into their bars.
pub fn run(recorder: &mut Recorder<'_>, view: &Resource, cells: &Cells) {
    let resources = [
        ("view", view.clone()),
        ("crowd", cells.crowd.clone()),
        ("counts", cells.counts.binding()),
        ("bars", (&cells.bars).into()),
    ];
    recorder.pixels("lines/crowd/bar", cells.bars.size_px(), &resources);
}
