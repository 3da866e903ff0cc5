//! The importance (rank) of each pixel of a line. See `shaders/lines/crowd/rank.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// x: rank, from 0 (speckle, or no line) to 1 (a long skyline); y: how far the cap applies, which is 0 near a pair of
/// eyes.
pub(crate) const RANK: TargetKind = TargetKind::storage("line rank", wgpu::TextureFormat::Rg32Float);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The cells, for the size of the window.
    pub cells: &'a Cells,
    pub distance: &'a Target,
    /// Line strength: 0 no line, 1 full.
    pub line: &'a Target,
    pub rank: &'a Target,
}

/// Ranks the lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("crowd", inputs.cells.crowd.clone()),
        ("distance_m", inputs.distance.into()),
        ("line", inputs.line.into()),
        ("rank", inputs.rank.into()),
    ];
    recorder.pixels("lines/crowd/rank", inputs.rank.size_px(), &resources);
}
