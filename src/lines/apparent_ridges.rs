//! Apparent ridges and valleys → the edge list. See `shaders/lines/apparent_ridges.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::target::Target;
use crate::gpu::wgsl::lines::apparent_ridges::ApparentRules;
use crate::surface::curvature::Shapes;
use crate::surface::edges::EdgeList;

/// Inputs of the pass.
pub struct Inputs<'a> {
    pub view: &'a Resource,
    /// The least curvature of a ridge, in turns of the normal (radians) over a feature.
    pub least_bend: f32,
    /// Whether valleys are traced instead of ridges.
    pub valleys: bool,
    pub position: &'a Target,
    pub normal: &'a Target,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    pub apparent: &'a Target,
}

/// Adds the ridges or valleys to the edge list.
pub fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let rules = ApparentRules { least_bend: inputs.least_bend, side: if inputs.valleys { -1.0 } else { 1.0 } };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("apparent_rules", recorder.uniform("apparent rules", &rules)),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("apparent", inputs.apparent.into()),
        edges.edges(),
        edges.draw(),
    ];
    resources.extend(inputs.shapes.resources());
    let groups = Groups::Of(inputs.shapes.normal.size_px().map(|side| side.div_ceil(WORKGROUP_PX)));
    Ordered { shader: "lines/apparent_ridges".into(), find: None, stages: 3, groups, kept: 0 }
        .run(recorder, &resources);
}
