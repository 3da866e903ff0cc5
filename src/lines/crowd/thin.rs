//! Removes lines below the bar. See `shaders/lines/crowd/thin.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// Line strength after the least important lines were removed where lines are crowded.
pub(crate) const UNCROWDED: TargetKind = TargetKind::storage(
    "uncrowded line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Detected lines without the least important ones of crowds"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Line strength: 0 no line, 1 full.
    pub line: &'a Target,
    pub rank: &'a Target,
    /// The cells with their bars.
    pub cells: &'a Cells,
    /// The output: [`UNCROWDED`].
    pub thinned: &'a Target,
}

/// Thins the lines of an eye.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("crowd", inputs.cells.crowd.clone()),
        ("line", inputs.line.into()),
        ("rank", inputs.rank.into()),
        ("bars", (&inputs.cells.bars).into()),
        ("thinned", inputs.thinned.into()),
    ];
    recorder.pixels("lines/crowd/thin", inputs.thinned.size_px(), &resources);
}
