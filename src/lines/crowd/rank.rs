//! How much each pixel of a line matters. See `shaders/lines/crowd/rank.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// 0 a crumb, 1 a long skyline; 0 where there is no line. And how far the cap holds: 0 is near a pair of eyes.
pub const RANK: TargetKind = TargetKind::storage("line rank", wgpu::TextureFormat::Rg32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// For the size of the window.
    pub cells: &'a Cells,
    /// Of the surface.
    pub position: &'a Target,
    /// Lines: 0 none, 1 full.
    pub line: &'a Target,
    /// Out: [`RANK`].
    pub rank: &'a Target,
}

/// Ranks lines.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("crowd", inputs.cells.crowd.clone()),
        ("position", inputs.position.into()),
        ("line", inputs.line.into()),
        ("rank", inputs.rank.into()),
    ];
    recorder.pixels("lines/crowd/rank", inputs.rank.size_px(), &resources);
}
