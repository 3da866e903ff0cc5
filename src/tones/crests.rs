//! Lightens crests and darkens hollows. See `shaders/tones/crests.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::light::LightUniform;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::tones::crests::CrestRules;
use crate::scene::Light;
use crate::style::Style;
use crate::surface::curvature::Shapes;

/// Value that is added to the light of a pixel, −1 to 1.
pub(crate) const CREST_LIGHT: TargetKind = TargetKind::storage(
    "crest light",
    wgpu::TextureFormat::R32Float,
    Group::Tones.shows("Light that crests gain and hollows lose"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style whose light settings apply.
    pub style: &'a Style,
    /// The light of the scene.
    pub light: &'a Light,
    pub distance: &'a Target,
    /// The curvature of the surface.
    pub shapes: &'a Shapes,
    pub crest_light: &'a Target,
}

/// Computes how much crests gain and hollows lose.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = CrestRules { most: inputs.style.light.crests };
    let Shapes { normal, bend, .. } = inputs.shapes;
    let resources = [
        ("view", inputs.view.clone()),
        ("light", recorder.uniform("light", &LightUniform::new(inputs.style, inputs.light))),
        ("crest_rules", recorder.uniform("crest rules", &rules)),
        ("distance_m", inputs.distance.into()),
        ("shape_normal", normal.into()),
        ("shape_bend", bend.into()),
        ("crest_light", inputs.crest_light.into()),
    ];
    recorder.pixels("tones/crests", inputs.crest_light.size_px(), &resources);
}
