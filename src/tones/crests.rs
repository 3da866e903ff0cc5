//! Crests are lighter and hollows darker. See `shaders/tones/crests.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use super::light::LightUniform;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::tones::crests::CrestRules;
use crate::scene::Light;
use crate::style::Style;
use crate::surface::curvature::Shapes;

/// What is added to the light of a place, -1 to 1.
pub const CREST_LIGHT: TargetKind = TargetKind::storage("crest light", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Whose light it is.
    pub style: &'a Style,
    /// The scene's.
    pub light: &'a Light,
    /// Of the surface.
    pub position: &'a Target,
    /// How it bends.
    pub shapes: &'a Shapes,
    /// Out.
    pub crest_light: &'a Target,
}

/// Finds what crests gain and hollows lose.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = CrestRules { most: inputs.style.light.crests };
    let Shapes { normal, bend, .. } = inputs.shapes;
    let resources = [
        ("view", inputs.view.clone()),
        ("light", recorder.uniform("light", &LightUniform::new(inputs.style, inputs.light))),
        ("crest_rules", recorder.uniform("crest rules", &rules)),
        ("position", inputs.position.into()),
        ("shape_normal", normal.into()),
        ("shape_bend", bend.into()),
        ("crest_light", inputs.crest_light.into()),
    ];
    recorder.pixels("tones/crests", inputs.crest_light.size_px(), &resources);
}
