//! Tones from pictures of the surface: how light each place is, and its colour before lines and haze; and the marks
//! that tones are hatched with.

pub mod balance;
pub mod crests;
pub mod fractal_hatching;
pub mod hatching;
pub mod light;
pub mod plain;
pub mod relief;
pub mod tonal_art_map;
pub mod toon;
pub mod water;
pub mod watercolor;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::scene::Light;
use crate::style::{Style, Tone};

/// rgb: linear colour; a: the tone asked for, 0 black to 1 white.
pub const TONE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Colour before lines and haze, and the tone that is asked for.
pub const TONE: TargetKind = TargetKind::storage("tone", TONE_FORMAT);

/// Colours that are not the style's.
#[derive(Clone, Copy)]
pub struct Local<'a> {
    /// Which pixels have them.
    pub surface_id: &'a Target,
    /// [`LOCAL_COLOR`](crate::surface::local_color::LOCAL_COLOR).
    pub color: &'a Target,
    /// How much of them.
    pub amount: f32,
}

impl Local<'_> {
    /// By the names in the shaders.
    fn resources(self) -> [Named; 2] {
        [("surface_id", self.surface_id.into()), ("local_color", self.color.into())]
    }
}

/// What kinds of tones read and write.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// `Terrain`, for the earth's curvature.
    pub terrain: Named,
    /// What the land sees of the sun and the sky, for a style that asks.
    pub horizon_maps: Option<[Named; 5]>,
    /// Whose tone it is, and how light falls.
    pub style: &'a Style,
    /// The scene's.
    pub light: &'a Light,
    /// The camera's height in the world.
    pub camera_z_m: f32,
    /// The lowest and the highest place of the land.
    pub range_m: [f32; 2],
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// [`FORM_NORMAL`](crate::surface::form::FORM_NORMAL) for a style whose light falls on the form of the land, or
    /// nothing.
    pub form_normal: &'a Target,
    /// [`RELIEF_LIGHT`](relief::RELIEF_LIGHT) of a style that brings out relief.
    pub relief_light: Option<&'a Target>,
    /// [`CREST_LIGHT`](crests::CREST_LIGHT) of a style whose crests are lighter.
    pub crest_light: Option<&'a Target>,
    /// What stands for pictures that are not there.
    pub nothing: &'a Target,
    /// What marks shade, which says how dark they are on trees; none where there are no marks or trees.
    pub mark_surface: Option<&'a Target>,
    /// What the shadows of trees take of the sun, if there are any and the style asks.
    pub tree_shadow: Option<&'a Target>,
    /// The own colours of trees and models, if there are any and the style asks.
    pub local: Option<Local<'a>>,
    /// Out: colour, and the tone that is asked for.
    pub tone: &'a Target,
}

/// Gives what the inputs show the style's tone.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    match &inputs.style.tone {
        Tone::Plain(_) => plain::run(recorder, inputs),
        Tone::Toon(toon) => toon::run(recorder, toon, inputs),
    }
}
