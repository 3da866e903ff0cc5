//! Suggestive contours → the edge list. See `shaders/lines/suggestive.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::target::Target;
use crate::gpu::wgsl::lines::suggestive::SuggestiveRules;
use crate::style::Strokes;
use crate::surface::curvature::Shapes;
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
    /// How it bends.
    pub shapes: &'a Shapes,
    /// [`RADIAL`](super::radial::RADIAL).
    pub radial: &'a Target,
    /// Where the other eye of a pair is in the rig.
    pub other_eye_m: Option<[f32; 3]>,
}

/// Lines of two eyes that lie farther apart on the surface are no partners; `lines/strokes` asks for as much of contours.
const AGREE_PX: f32 = 1.5;

/// Adds the edges to the list.
pub fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let rules = SuggestiveRules {
        least_rise: inputs.style.suggestive_rise,
        most_facing: inputs.style.suggestive_deg.to_radians().cos(),
        agree_px: inputs.other_eye_m.map_or(0.0, |_| AGREE_PX),
        padding: 0.0,
        other_eye_m: inputs.other_eye_m.unwrap_or_default(),
        padding_eye: 0.0,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("suggestive_rules", recorder.uniform("suggestive rules", &rules)),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("radial", inputs.radial.into()),
        edges.edges(),
        edges.draw(),
    ];
    resources.extend(inputs.shapes.resources());
    let groups = Groups::Of(inputs.radial.size_px().map(|side| side.div_ceil(WORKGROUP_PX)));
    Ordered { shader: "lines/suggestive".into(), stages: 3, groups, kept: 0 }.run(recorder, &resources);
}
