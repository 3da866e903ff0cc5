//! Ink of each rank, in cells. See `shaders/lines/crowd/count.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;

/// Counts the ink of `line` into the cells.
pub fn run(cx: &mut Cx<'_>, view: &Resource, line: &Target, rank: &Target, cells: &Cells) {
    let resources = [
        ("view", view.clone()),
        ("crowd", cells.crowd.clone()),
        ("line", line.into()),
        ("rank", rank.into()),
        ("counts", cells.counts.binding()),
    ];
    cx.groups("lines/crowd/count", cells.bars.size_px(), &resources);
}
