//! The importance (rank) of each pixel of a line, and the ink of each rank in cells. See `shaders/lines/crowd/rank.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// In 16 bits each: rank, from 0 (speckle, or no line) to 1 (a long skyline), and how far the cap applies, which is 0
/// near a pair of eyes.
pub(crate) const RANK: TargetKind = TargetKind::storage(
    "line rank",
    wgpu::TextureFormat::R32Uint,
    Group::Lines.shows("Importance of each line where lines are crowded, packed into a number"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The cells, in which the ink of each rank is counted.
    pub cells: &'a Cells,
    pub distance: &'a Target,
    /// Line strength: 0 no line, 1 full.
    pub line: &'a Target,
    pub rank: &'a Target,
}

/// Ranks the lines, and counts their ink in the cells.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("crowd", inputs.cells.crowd.clone()),
        ("distance_m", inputs.distance.into()),
        ("line", inputs.line.into()),
        ("rank", inputs.rank.into()),
        ("counts", inputs.cells.counts.binding()),
    ];
    recorder.clear(&inputs.cells.counts);
    recorder.pixels("lines/crowd/rank", inputs.rank.size_px(), &resources);
}
