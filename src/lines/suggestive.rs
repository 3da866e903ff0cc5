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

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style of the suggestive contours.
    pub style: &'a Strokes,
    pub position: &'a Target,
    pub normal: &'a Target,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    pub radial: &'a Target,
    /// Position of the other eye of a stereo pair, relative to the rig's origin.
    pub other_eye_m: Option<[f32; 3]>,
}

/// Suggestive contours of two eyes that are farther apart on the surface are not drawn, in pixels; `lines/strokes` uses
/// the same distance for contours.
const AGREE_PX: f32 = 1.5;

/// Adds the suggestive contours to the edge list.
pub(crate) fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
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
    Ordered { shader: "lines/suggestive".into(), find: None, stages: 3, groups, kept: 0 }.run(recorder, &resources);
}
