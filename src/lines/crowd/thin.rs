//! What the bar leaves of lines. See `shaders/lines/crowd/thin.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// Lines of which the least ones are left out where they are crowded.
pub const UNCROWDED: TargetKind = TargetKind::storage("uncrowded line", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Lines: 0 none, 1 full.
    pub line: &'a Target,
    /// [`RANK`](super::rank::RANK).
    pub rank: &'a Target,
    /// With their bars.
    pub cells: &'a Cells,
    /// Out: [`UNCROWDED`].
    pub thinned: &'a Target,
}

/// Thins the lines of an eye.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
