//! Light that brings out relief, for tones in steps or smooth ones: warped or scaled by curvature, or grazing the land's
//! form at several scales.
//!
//! Warp and scaling ask how the picture bends toward the eye: [`gradient`] finds how depth rises, [`diffuse`] blurs that up
//! to silhouettes and creases, and [`radiance`] or [`scaling`] takes its curvature and lights the place. [`exaggerate`] asks
//! the land's own forms instead. All write a tone for each pixel, which `tones/toon` takes in place of its own light.
//!
//! Sources: Vergne, Pacanowski, Barla, Granier and Schlick 2009 and 2010; Rusinkiewicz, Burns and DeCarlo 2006.
//!
//! Why: `docs/decisions/relief.md`.

pub mod diffuse;
pub mod exaggerate;
pub mod gradient;
pub mod radiance;
pub mod scaling;
pub mod surroundings;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind, Targets};
pub(crate) use crate::gpu::wgsl::shared::relief::ReliefRules;
use crate::scene::Light;
use crate::scene::focus::FocusUniform;
use crate::scene::view::Pose;
use crate::style::{Relief, ReliefKind, Style};
use crate::tones::light::LightUniform;

/// rgb: the colour of the light, of luminance 1; a: the tone that is asked for.
pub const RELIEF_LIGHT: TargetKind = TargetKind::storage("relief light", wgpu::TextureFormat::Rgba16Float);

/// `ReliefRules`: no uniform, since passes have three of these already (`docs/decisions/software-drivers.md`).
const RULES: BufferKind = BufferKind::storage("relief rules");

/// What the passes read.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Whose relief.
    pub relief: &'a Relief,
    /// The style's light.
    pub style: &'a Style,
    /// The scene's.
    pub light: &'a Light,
    /// Of the eye.
    pub pose: &'a Pose,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// What the land sees of the sun and the sky, for a style that asks, with `Terrain`.
    pub horizon_maps: Option<(Named, [Named; 5])>,
    /// What the shadows of trees take of the sun, if there are any and the style asks.
    pub tree_shadow: Option<&'a Target>,
    /// What is seen.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// [`FORM_NORMAL`](crate::surface::form::FORM_NORMAL), or one empty texel.
    pub form_normal: &'a Target,
}

/// What several passes bind.
struct Shared {
    light: Resource,
    focus: Resource,
    rules: Resource,
}

impl Relief {
    fn rules(&self) -> ReliefRules {
        ReliefRules {
            scale_px: self.scale_px,
            coarser_far: self.coarser_far,
            coarser_aside: self.coarser_aside,
            coarser_level: self.coarser_level,
            crease_rad: self.crease_deg.to_radians(),
            alpha_px: self.alpha_px,
            foreshortening: self.foreshortening,
            ..ReliefRules::default()
        }
    }
}

/// By which shadows there are: those of trees count 1, and those of land 2.
fn shadows(inputs: &Inputs<'_>) -> usize {
    usize::from(inputs.tree_shadow.is_some()) + 2 * usize::from(inputs.horizon_maps.is_some())
}

/// What both passes with shadows read of them.
fn shadow_resources(inputs: &Inputs<'_>) -> impl Iterator<Item = Named> {
    let of_land =
        inputs.horizon_maps.clone().into_iter().flat_map(|(terrain, maps)| std::iter::once(terrain).chain(maps));
    of_land.chain(inputs.tree_shadow.map(|tree_shadow| ("tree_shadow", tree_shadow.into())))
}

/// Lights what the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let relief_light = targets.whole(recorder.gpu(), &RELIEF_LIGHT);
    let shared = Shared {
        light: recorder.uniform("light", &LightUniform::new(inputs.style, inputs.light)),
        focus: FocusUniform::on_gpu(recorder, inputs.light.focus.as_ref()),
        rules: recorder.upload(&RULES, &[inputs.relief.rules()]).binding(),
    };
    let shared = &shared;
    if inputs.relief.kind == ReliefKind::Exaggerated {
        exaggerate::run(recorder, inputs, shared, &relief_light);
        return relief_light;
    }
    let bends = inputs.relief.asks_for_curvature();
    let slopes = bends.then(|| {
        let pictures =
            [&gradient::DEPTH_GRADIENT, &gradient::BLURRED_GRADIENT].map(|kind| targets.whole(recorder.gpu(), kind));
        gradient::run(recorder, inputs, shared, &pictures[0]);
        diffuse::run(recorder, inputs, &pictures)
    });
    match inputs.relief.kind {
        ReliefKind::Scaling => scaling::run(recorder, inputs, shared, slopes.as_ref(), &relief_light),
        _ => radiance::run(recorder, inputs, shared, slopes.as_ref(), &relief_light),
    }
    relief_light
}
