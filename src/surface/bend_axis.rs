//! Along which line the land bends most, for marks that follow it. See `shaders/surface/bend_axis.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::curvature::Shapes;
use super::mark_normal::BLOCK_PX;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::bend_axis::{BendAxisRules, REACH};

/// xy: cosine and sine of twice the line's angle on the map, counter-clockwise from east, times how decided it is, 0 to 1.
/// Its size is [`mark_normal_size`](super::mark_normal::mark_normal_size).
pub const BEND_AXIS: TargetKind = TargetKind::storage("bend axis", wgpu::TextureFormat::Rgba16Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// How the surface bends.
    pub shapes: &'a Shapes,
    /// Lines are the same over about so many pixels.
    pub smooth_px: f32,
    /// Out.
    pub bend_axis: &'a Target,
}

/// Finds the lines.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let step = (inputs.smooth_px / (BLOCK_PX * REACH as u32) as f32).round().max(1.0) as i32;
    let rules = BendAxisRules { step, ..BendAxisRules::default() };
    let Shapes { normal, bend, .. } = inputs.shapes;
    let resources = [
        ("bend_axis_rules", cx.uniform("bend axis rules", &rules)),
        ("shape_normal", normal.into()),
        ("shape_bend", bend.into()),
        ("bend_axis", inputs.bend_axis.into()),
    ];
    cx.pixels("surface/bend_axis", inputs.bend_axis.size_px(), &resources);
}
