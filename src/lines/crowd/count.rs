//! Counts the ink of each rank in cells. See `shaders/lines/crowd/count.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// Counts the ink of `line` in the cells.
pub(crate) fn run(recorder: &mut Recorder<'_>, view: &Resource, line: &Target, rank: &Target, cells: &Cells) {
    let resources = [
        ("view", view.clone()),
        ("crowd", cells.crowd.clone()),
        ("line", line.into()),
        ("rank", rank.into()),
        ("counts", cells.counts.binding()),
    ];
    recorder.groups("lines/crowd/count", cells.bars.size_px(), &resources);
}
