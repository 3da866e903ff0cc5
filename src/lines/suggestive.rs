//! Adds the suggestive contours of the visible surface to the edge list. See `shaders/lines/suggestive.wgsl`.
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
    /// The strokes of the style, with the settings of suggestive contours.
    pub settings: &'a Strokes,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    /// The curvature toward the eye and its derivative ([`super::radial::RADIAL`]).
    pub radial: &'a Target,
    /// Position of the other eye of a stereo pair, relative to the rig's origin.
    pub other_eye_m: Option<[f32; 3]>,
}

/// In a stereo pair, largest distance on the surface between a suggestive contour of one eye and that of the other, in
/// pixels; contours without a partner are not drawn. `lines/strokes` uses the same distance for contours.
const AGREE_PX: f32 = 1.5;

/// Adds the suggestive contours to the edge list.
pub(crate) fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    let rules = SuggestiveRules {
        min_rise: inputs.settings.suggestive_rise,
        largest_cosine: inputs.settings.suggestive_deg.to_radians().cos(),
        agree_px: inputs.other_eye_m.map_or(0.0, |_| AGREE_PX),
        padding: 0.0,
        other_eye_m: inputs.other_eye_m.unwrap_or_default(),
        padding_eye: 0.0,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("suggestive_rules", recorder.uniform("suggestive rules", &rules)),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("radial", inputs.radial.into()),
        edges.edges(),
        edges.draw(),
    ];
    resources.extend(inputs.shapes.resources());
    let groups = Groups::Of(inputs.radial.size_px().map(|side| side.div_ceil(WORKGROUP_PX)));
    Ordered { shader: "lines/suggestive".into(), first_stage_shader: None, groups, words_per_group: 0 }
        .run(recorder, &resources);
}
