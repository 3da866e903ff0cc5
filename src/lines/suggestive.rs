//! Suggestive contours → the edge list. See `shaders/lines/suggestive.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::{Cx, WORKGROUP_PX};
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::target::Target;
use crate::gpu::wgsl::lines::suggestive::SuggestiveRules;
use crate::style::Strokes;
use crate::surface::edges::EdgeList;

/// What the pass reads.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Whose contours they are.
    pub style: &'a Strokes,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// [`SHAPE_NORMAL`](crate::surface::curvature::SHAPE_NORMAL).
    pub shape_normal: &'a Target,
    /// [`RADIAL`](super::radial::RADIAL).
    pub radial: &'a Target,
}

/// Adds the edges to the list.
pub fn run(cx: &mut Cx<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let rules = SuggestiveRules {
        least_rise: inputs.style.suggestive_rise,
        most_facing: inputs.style.suggestive_deg.to_radians().cos(),
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("suggestive_rules", cx.uniform("suggestive rules", &rules)),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("shape_normal", inputs.shape_normal.into()),
        ("radial", inputs.radial.into()),
        edges.edges(),
        edges.draw(),
    ];
    let groups = Groups::Of(inputs.radial.size_px().map(|side| side.div_ceil(WORKGROUP_PX)));
    Ordered { shader: "lines/suggestive".into(), stages: 3, groups, kept: 0 }.run(cx, &resources);
}
