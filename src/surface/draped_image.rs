//! Images on the land, as each pixel sees them. See `shaders/surface/draped_image.wgsl`.
//!
//! Why: `docs/decisions/draped-images.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::imagery::ResidentImagery;
use crate::style::Image;

/// A hue with its strength, and the factor of the light.
pub(crate) const DRAPED_IMAGE: TargetKind = TargetKind::storage(
    "draped image",
    wgpu::TextureFormat::Rg32Uint,
    Group::Surface.shows("Hue of images on the land, and the factor of the light").with_float_words(0b10),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The `Terrain` uniform.
    pub terrain: Named,
    pub imagery: &'a ResidentImagery,
    /// What the style makes of images.
    pub style: &'a Image,
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    pub draped_image: &'a Target,
}

/// Reads the images at each pixel.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("draped", recorder.uniform("images", &inputs.imagery.uniform(inputs.style))),
        inputs.terrain.clone(),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("surface_id", inputs.surface_id.into()),
        ("draped_image", inputs.draped_image.into()),
    ];
    resources.extend(inputs.imagery.resources());
    recorder.pixels("surface/draped_image", inputs.draped_image.size_px(), &resources);
}
