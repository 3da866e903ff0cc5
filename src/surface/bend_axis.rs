//! The direction along which the land bends most, for hatching marks that follow it. See
//! `shaders/surface/bend_axis.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::curvature::Shapes;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::bend_axis::BendAxisRules;
use crate::style::hatching::Hatching;

/// xy: cosine and sine of twice the axis's angle on the map (counter-clockwise from east), times its confidence, 0 to
/// 1. The size is [`mark_normal_size`](super::mark_normal::mark_normal_size).
pub(crate) const BEND_AXIS: TargetKind = TargetKind::storage(
    "bend axis",
    wgpu::TextureFormat::Rgba16Float,
    Group::Form.shows("Direction in which the land bends most"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    /// The hatching whose marks follow the axes.
    pub hatching: &'a Hatching,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    pub bend_axis: &'a Target,
}

pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = BendAxisRules { step: inputs.hatching.axis_step(), pad: 0, blocks: inputs.bend_axis.size_px() };
    let Shapes { normal, bend, .. } = inputs.shapes;
    let resources = [
        ("bend_axis_rules", recorder.uniform("bend axis rules", &rules)),
        ("shape_normal", normal.into()),
        ("shape_bend", bend.into()),
        ("bend_axis", inputs.bend_axis.into()),
    ];
    recorder.pixels("surface/bend_axis", inputs.bend_axis.size_px(), &resources);
}
