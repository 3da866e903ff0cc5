//! The curvature of the visible surface, for lines, hatching marks and light.

use super::{FrameInputs, rows};
use crate::composite::NOTHING;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::surface::bend_axis::{self, BEND_AXIS};
use crate::surface::curvature::{self, Shapes};
use crate::surface::meshes::{DrawnMeshes, curvature as mesh_curvature};
use crate::tones::crests::{self, CREST_LIGHT};

/// The pictures of an eye that marks and light derive from the curvature. They are computed right after the surface,
/// because the buffers of its meshes are reused for the next eye.
pub(super) struct Bends {
    /// [`BEND_AXIS`], if hatching marks follow the curvature.
    pub(super) axis: Option<Target>,
    /// [`CREST_LIGHT`], in a style with lighter crests.
    pub(super) crest_light: Option<Target>,
}

/// The surface that an eye sees.
pub(super) struct EyeInputs<'a> {
    pub(super) view: &'a Resource,
    /// The models in view, in a scene with models.
    pub(super) meshes: Option<&'a DrawnMeshes>,
    /// Bindings of the terrain: height atlas and page table.
    pub(super) heights: &'a [Named],
    pub(super) surface_id: &'a Target,
    pub(super) distance: &'a Target,
    pub(super) normal: &'a Target,
    /// [`WATER`](crate::surface::water::WATER), in a style with water. Water has no curvature.
    pub(super) water: Option<&'a Target>,
}

/// Computes the curvature of the surface, smoothed to features of `feature_px` pixels. The next call overwrites the
/// targets that it returns.
pub(super) fn shapes(
    recorder: &mut Recorder<'_>,
    feature_px: f32,
    eye: &EyeInputs<'_>,
    targets: &mut Targets,
) -> Shapes {
    let gpu = recorder.gpu();
    let &EyeInputs { view, meshes, heights: terrain, surface_id, distance, normal, water } = eye;
    let shapes = Shapes::of(gpu, targets);
    let nothing = &targets.sized(gpu, &NOTHING, [1, 1]);
    let water = water.unwrap_or(nothing);
    let land = curvature::Inputs { view, terrain, feature_px, surface_id, distance, water, shapes: &shapes };
    curvature::run(recorder, &land);
    if let Some(meshes) = meshes {
        let shapes = &shapes;
        let inputs = mesh_curvature::Inputs { view, meshes, feature_px, surface_id, distance, normal, shapes };
        mesh_curvature::run(recorder, &inputs);
    }
    shapes
}

/// Computes the pictures that the style's marks and light need.
pub(super) fn find(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    eye: &EyeInputs<'_>,
    targets: &mut Targets,
) -> Bends {
    let (gpu, style) = (recorder.gpu(), inputs.style);
    let follows = rows::drawn_hatching(inputs).filter(|hatching| hatching.follows_curvature());
    let axis = follows.map(|hatching| {
        let shapes = &shapes(recorder, hatching.form_px, eye, targets);
        let axis = targets.sized(gpu, &BEND_AXIS, shapes.normal.size_px());
        bend_axis::run(recorder, &bend_axis::Inputs { hatching, shapes, bend_axis: &axis });
        axis
    });
    let crest_light = style.needs_crests().then(|| {
        let shapes = &shapes(recorder, style.light.crests_px, eye, targets);
        let crest_light = targets.whole(gpu, &CREST_LIGHT);
        let (view, distance, light) = (eye.view, eye.distance, inputs.light);
        crests::run(recorder, &crests::Inputs { view, style, light, distance, shapes, crest_light: &crest_light });
        crest_light
    });
    Bends { axis, crest_light }
}
