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

/// What the pass reads.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Bends of less are no ridges, in turns of the normal over a feature.
    pub least_bend: f32,
    /// Valleys and not ridges.
    pub valleys: bool,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// How it bends.
    pub shapes: &'a Shapes,
    /// [`APPARENT`](super::apparent::APPARENT).
    pub apparent: &'a Target,
}

/// Adds the edges to the list.
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
    Ordered { shader: "lines/apparent_ridges".into(), stages: 3, groups, kept: 0 }.run(recorder, &resources);
}
