//! Light that emphasises relief, for stepped or smooth tones: warped or scaled by curvature, or grazing the land's form
//! at several scales.
//!
//! Warping and scaling use the view-centred curvature of the picture: [`gradient`] computes the gradient of depth,
//! [`diffuse`] blurs it up to silhouettes and creases, and [`radiance`] or [`scaling`] derives its curvature and lights
//! the pixel. [`exaggerate`] uses the land's own forms instead. All write a tone for each pixel, which `tones/toon`
//! uses in place of its own light.
//!
//! Sources: Vergne, Pacanowski, Barla, Granier and Schlick 2009 and 2010; Rusinkiewicz, Burns and DeCarlo 2006.
//!
//! Why: `docs/decisions/relief.md`.

pub(crate) mod diffuse;
pub(crate) mod exaggerate;
pub(crate) mod gradient;
pub(crate) mod radiance;
pub(crate) mod scaling;
pub(crate) mod surroundings;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind, Targets};
pub(crate) use crate::gpu::wgsl::shared::relief::ReliefRules;
use crate::scene::Light;
use crate::scene::focus::FocusUniform;
use crate::scene::view::Pose;
use crate::style::{Relief, ReliefKind, Style};
use crate::tones::light::LightUniform;

/// rgb: the colour of the light, of luminance 1; a: the requested tone.
pub(crate) const RELIEF_LIGHT: TargetKind = TargetKind::storage(
    "relief light",
    wgpu::TextureFormat::Rgba16Float,
    Group::Tones.shows("Colour of the light that emphasises relief, and the requested tone"),
);

/// `ReliefRules` are not a uniform, since passes already have three of these (`docs/decisions/software-drivers.md`).
const RULES: BufferKind = BufferKind::storage("relief rules");

/// Inputs of the passes.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub relief: &'a Relief,
    /// The style, for its light.
    pub style: &'a Style,
    /// The light of the scene.
    pub light: &'a Light,
    /// The pose of the eye.
    pub pose: &'a Pose,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The `Terrain` uniform and the bindings of the horizon maps, for a style with cast shadows or occlusion.
    pub horizon_maps: Option<(Named, [Named; 5])>,
    /// The share of sunlight that trees block, if there are trees and the style has their shadows.
    pub tree_shadow: Option<&'a Target>,
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// [`FORM_NORMAL`](crate::surface::form::FORM_NORMAL), or one empty texel.
    pub form_normal: &'a Target,
}

/// Resources that several passes bind.
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

/// Returns the definitions of the two passes that have shadows, and whether the shadows exist: those of land and those
/// of trees.
fn shadows(inputs: &Inputs<'_>) -> [(&'static str, bool); 2] {
    [("HORIZON_MAPS", inputs.horizon_maps.is_some()), ("TREE_SHADOWS", inputs.tree_shadow.is_some())]
}

/// Returns the bindings of `shaders/shared/lit_surface.wgsl`, for the two passes that have shadows.
fn lit_surface(inputs: &Inputs<'_>, shared: &Shared) -> Vec<Named> {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("light", shared.light.clone()),
        ("focus", shared.focus.clone()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("form_normal", inputs.form_normal.into()),
    ];
    if let Some((terrain, maps)) = inputs.horizon_maps.clone() {
        resources.push(terrain);
        resources.extend(maps);
    }
    resources.extend(inputs.tree_shadow.map(|tree_shadow| ("tree_shadow", tree_shadow.into())));
    resources
}

/// Lights the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
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
    let bends = inputs.relief.needs_curvature();
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
