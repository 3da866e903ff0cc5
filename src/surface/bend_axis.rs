//! Along which line the land bends most, for marks that follow it. See `shaders/surface/bend_axis.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::curvature::Shapes;
use super::mark_normal::BLOCK_PX;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::bend_axis::{BendAxisRules, REACH};
use crate::style::hatching::Hatching;

/// xy: cosine and sine of twice the line's angle on the map, counter-clockwise from east, times how decided it is, 0 to 1.
/// Its size is [`mark_normal_size`](super::mark_normal::mark_normal_size).
pub const BEND_AXIS: TargetKind = TargetKind::storage("bend axis", wgpu::TextureFormat::Rgba16Float);

/// Blocks between one that is asked and the next: lines are averaged over about two samples of the form to each side.
fn step(hatching: &Hatching) -> i32 {
    (2.0 * hatching.form_px / (BLOCK_PX * REACH as u32) as f32).round().max(1.0) as i32
}

/// How far a line looks to each side, in pixels; 0 for marks that follow none.
pub fn reach_px(hatching: &Hatching) -> u32 {
    // And a block beside, between which and its own a pixel lies.
    if hatching.follows_curvature() { (step(hatching) * REACH + 1) as u32 * BLOCK_PX } else { 0 }
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// Whose marks follow the lines.
    pub hatching: &'a Hatching,
    /// How the surface bends.
    pub shapes: &'a Shapes,
    /// Out.
    pub bend_axis: &'a Target,
}

/// Finds the lines.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = BendAxisRules { step: step(inputs.hatching) };
    let Shapes { normal, bend, .. } = inputs.shapes;
    let resources = [
        ("bend_axis_rules", recorder.uniform("bend axis rules", &rules)),
        ("shape_normal", normal.into()),
        ("shape_bend", bend.into()),
        ("bend_axis", inputs.bend_axis.into()),
    ];
    recorder.pixels("surface/bend_axis", inputs.bend_axis.size_px(), &resources);
}
