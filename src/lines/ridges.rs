//! Adds ridges and valleys to the edge list, either of the surface or apparent ones. See `shaders/lines/ridges.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::target::Target;
use crate::gpu::wgsl::lines::ridges::RidgeRules;
use crate::surface::curvature::Shapes;
use crate::surface::edges::EdgeList;

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The least curvature of a ridge: the change of the normal over a feature, in radians.
    pub min_bend: f32,
    /// Whether valleys are traced instead of ridges.
    pub valleys: bool,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    /// [`APPARENT`](super::apparent::APPARENT), to trace the crests of view-dependent curvature instead.
    pub apparent: Option<&'a Target>,
}

/// Adds the ridges or valleys to the edge list.
pub(crate) fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let rules = RidgeRules { min_bend: inputs.min_bend, orientation: if inputs.valleys { -1.0 } else { 1.0 } };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("ridge_rules", recorder.uniform("ridge rules", &rules)),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        edges.edges(),
        edges.draw(),
    ];
    resources.extend(inputs.shapes.resources());
    resources.extend(inputs.apparent.map(|apparent| ("apparent", apparent.into())));
    let definitions: &[&str] = if inputs.apparent.is_some() { &["APPARENT"] } else { &[] };
    let shader = Compute { name: "lines/ridges", definitions };
    let groups = Groups::Of(inputs.shapes.normal.size_px().map(|side| side.div_ceil(WORKGROUP_PX)));
    Ordered { shader, first_stage_shader: None, groups, words_per_group: 0 }.run(recorder, &resources);
}
