//! What the bar leaves of lines. See `shaders/lines/crowd/thin.wgsl`.

use super::Cells;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};

/// Lines of which the least ones are left out where they are crowded.
pub const UNCROWDED: TargetKind = TargetKind::storage("uncrowded line", wgpu::TextureFormat::R32Float);

/// What the pass reads of an eye.
#[derive(Clone)]
pub struct Ranked {
    /// `View`.
    pub view: Resource,
    /// Of the surface.
    pub position: Target,
    /// Lines: 0 none, 1 full.
    pub line: Target,
    /// [`RANK`](super::rank::RANK).
    pub rank: Target,
    /// With their bars.
    pub cells: Cells,
}

/// Thins the lines of an eye, as the bars of it and of the other one of a pair say.
pub fn run(cx: &mut Cx<'_>, own: &Ranked, other: Option<&Ranked>, thinned: &Target) {
    let mut resources = vec![
        ("view", own.view.clone()),
        ("crowd", own.cells.crowd.clone()),
        ("line", (&own.line).into()),
        ("rank", (&own.rank).into()),
        ("bars", (&own.cells.bars).into()),
        ("thinned", thinned.into()),
    ];
    if let Some(other) = other {
        resources.extend([
            ("other_view", other.view.clone()),
            ("position", (&own.position).into()),
            ("other_bars", (&other.cells.bars).into()),
        ]);
    }
    let definitions: &[&str] = if other.is_some() { &["PAIR"] } else { &[] };
    cx.pixels(Compute { name: "lines/crowd/thin", definitions }, thinned.size_px(), &resources);
}
