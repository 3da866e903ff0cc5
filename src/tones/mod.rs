//! Tones from pictures of the surface: the lightness of each pixel, its colour before lines and haze, and the marks
//! with which tones are hatched.

pub(crate) mod balance;
pub(crate) mod crests;
pub(crate) mod fit;
pub(crate) mod fractal_hatching;
pub(crate) mod hatching;
pub(crate) mod light;
pub(crate) mod masses;
pub(crate) mod plain;
pub(crate) mod relief;
pub(crate) mod tonal_art_map;
pub(crate) mod toon;
pub(crate) mod water;
pub(crate) mod watercolor;

use self::light::LightUniform;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::scene::Light;
use crate::scene::focus::FocusUniform;
use crate::style::{Style, Tone};

/// rgb: linear colour; a: the requested tone, 0 black to 1 white.
pub(crate) const TONE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Colour before lines and haze, and the requested tone.
pub(crate) const TONE: TargetKind =
    TargetKind::storage("tone", TONE_FORMAT, Group::Tones.shows("Colour of the tones; alpha is the requested tone"));

/// The local colours of trees and models, which are not the style's.
#[derive(Clone, Copy)]
pub(crate) struct Local<'a> {
    /// Surface ids, which identify the pixels with local colours.
    pub surface_id: &'a Target,
    pub color: &'a Target,
    /// Weight of the local colours, 0 to 1.
    pub amount: f32,
}

impl Local<'_> {
    /// Returns the bindings of the shaders with local colours.
    fn resources(self) -> [Named; 2] {
        [("surface_id", self.surface_id.into()), ("local_color", self.color.into())]
    }
}

/// Inputs and output of the tone passes.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The `Terrain` uniform, for the earth's curvature.
    pub terrain: Named,
    /// Bindings of the horizon maps, for a style with cast shadows or occlusion.
    pub horizon_maps: Option<[Named; 5]>,
    /// The style, which sets the tone and how light falls.
    pub style: &'a Style,
    /// The light of the scene.
    pub light: &'a Light,
    /// The camera's height in the world, in metres.
    pub camera_z_m: f32,
    /// The heights at which tints of the land begin and end, in metres; never equal.
    pub range_m: [f32; 2],
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// [`FORM_NORMAL`](crate::surface::form::FORM_NORMAL) for a style whose light falls on the form of the land;
    /// otherwise an empty target.
    pub form_normal: &'a Target,
    /// [`RELIEF_LIGHT`](relief::RELIEF_LIGHT) of a style that emphasises relief.
    pub relief_light: Option<&'a Target>,
    /// [`CREST_LIGHT`](crests::CREST_LIGHT) of a style whose crests are lighter.
    pub crest_light: Option<&'a Target>,
    /// The empty target that is bound for pictures that do not exist.
    pub nothing: &'a Target,
    /// The normal and lightness that marks shade, which set how dark marks are on trees; `None` without marks or trees.
    pub mark_surface: Option<&'a Target>,
    /// The share of sunlight that trees block, if there are trees and the style has their shadows.
    pub tree_shadow: Option<&'a Target>,
    /// The local colours of trees and models, if there are any and the style uses them.
    pub local: Option<Local<'a>>,
    /// [`DRAPED_IMAGE`](crate::surface::draped_image::DRAPED_IMAGE), if images are on the land.
    pub image: Option<&'a Target>,
    /// The curve that fits the tones to the picture, in a style that does so.
    pub fit: Option<&'a fit::FrameFit>,
    /// The edited masses of the picture, in a style that edits them.
    pub masses: Option<&'a masses::Cells>,
    /// The output: colour and requested tone.
    pub tone: &'a Target,
}

impl Inputs<'_> {
    /// Returns what passes bind that compute the tone of the light anywhere (`shaders/shared/lit_tone.wgsl`). `water` is a
    /// picture of the water, if there is any.
    fn lit_resources(&self, recorder: &mut Recorder<'_>, water: Option<&Target>) -> Vec<Named> {
        let mut resources = vec![
            ("view", self.view.clone()),
            ("light", recorder.uniform("light", &LightUniform::new(self.style, self.light))),
            ("focus", FocusUniform::on_gpu(recorder, self.light.focus.as_ref())),
            ("distance_m", self.distance.into()),
            ("normal", self.normal.into()),
            ("form_normal", self.form_normal.into()),
            ("crest_light", self.crest_light.unwrap_or(self.nothing).into()),
            ("relief_light", self.relief_light.unwrap_or(self.nothing).into()),
        ];
        resources.extend(water.map(|water| ("water", water.into())));
        resources.extend(self.tree_shadow.map(|tree_shadow| ("tree_shadow", tree_shadow.into())));
        resources.extend(self.image.map(|image| ("draped_image", image.into())));
        if let Some(maps) = self.horizon_maps.clone() {
            resources.push(self.terrain.clone());
            resources.extend(maps);
        }
        resources
    }

    /// Returns the definitions of the same passes.
    fn lit_definitions(&self, water: Option<&Target>) -> [(&'static str, bool); 6] {
        [
            ("CRESTS", self.crest_light.is_some()),
            ("RELIEF", self.relief_light.is_some()),
            ("HORIZON_MAPS", self.horizon_maps.is_some()),
            ("TREE_SHADOWS", self.tree_shadow.is_some()),
            ("WATER", water.is_some()),
            ("DRAPED_IMAGE", self.image.is_some()),
        ]
    }
}

/// Computes the style's tone of the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    match &inputs.style.tone {
        Tone::Plain(_) => plain::run(recorder, inputs),
        Tone::Toon(toon) => toon::run(recorder, toon, inputs),
    }
}
