//! Detected lines of an eye, and the edges for strokes that are found on the visible surface.

use super::{FrameInputs, bend};
use crate::composite::NOTHING;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::lines::{self, apparent, curvature, detector, lsa, radial, ridges, rims, suggestive, threshold};
use crate::style::layers::Measure;
use crate::style::{Detector, Lines, Strokes};
use crate::surface::curvature::Shapes;
use crate::surface::edges::EdgeList;
use crate::surface::meshes::DrawnMeshes;
use crate::surface::trees;

/// The surface that an eye sees.
pub(super) struct OnSurface<'a> {
    pub(super) view: &'a Resource,
    /// The models in view, in a scene with models.
    pub(super) meshes: Option<&'a DrawnMeshes>,
    /// Bindings of the terrain: height atlas and page table.
    pub(super) heights: &'a [Named],
    pub(super) surface_id: &'a Target,
    pub(super) depth: &'a Target,
    pub(super) distance: &'a Target,
    pub(super) normal: &'a Target,
    /// [`WATER`](crate::surface::water::WATER), in a style with water.
    pub(super) water: Option<&'a Target>,
    /// The rims of holes, if the land in view has holes.
    pub(super) rim: Option<&'a Target>,
    /// Position of the other eye of a stereo pair, in metres relative to the rig's origin.
    pub(super) other_eye_m: Option<[f32; 3]>,
}

impl<'a> OnSurface<'a> {
    /// Returns the inputs of the passes that compute the curvature.
    pub(super) fn bend_inputs(&self) -> bend::EyeInputs<'a> {
        let &Self { view, meshes, heights, surface_id, distance, normal, water, .. } = self;
        bend::EyeInputs { view, meshes, heights, surface_id, distance, normal, water }
    }
}

/// Draws the lines of the style's detector, without those along rims, and returns their picture.
pub(super) fn find(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    lines: &Lines,
    on: &OnSurface<'_>,
    targets: &mut Targets,
) -> Target {
    let line = if lines.detector.measure() == Measure::Ink {
        by_curvature(recorder, inputs, lines, on, targets)
    } else {
        detect(recorder, inputs, lines, inputs.style.lines().is_none(), on, targets)
    };
    let Some(rim) = on.rim else { return line };
    let rimless = targets.whole(recorder.gpu(), &rims::RIMLESS);
    let &OnSurface { view, distance, normal, .. } = on;
    rims::run(recorder, &rims::Inputs { view, line: &line, rim, distance, normal, rimless: &rimless });
    rimless
}

/// Draws lines with a detector and its threshold. `only_trees`: land and models have no lines.
fn detect(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    lines: &Lines,
    only_trees: bool,
    on: &OnSurface<'_>,
    targets: &mut Targets,
) -> Target {
    let gpu = recorder.gpu();
    let &OnSurface { view, surface_id, depth, distance, normal, .. } = on;
    let errors = &targets.whole(gpu, &detector::ERRORS);
    let line = targets.whole(gpu, &threshold::LINE);
    let directions = lines.has_eight_directions().then(|| targets.whole(gpu, &lsa::DIRECTIONS));
    let directions = directions.as_ref();
    detector::run(recorder, lines, &detector::Inputs { view, distance, normal, errors, directions });
    let errors = &inputs.world.forest().map_or(errors.clone(), |forest| {
        let tree_normal = &targets.whole(gpu, &trees::raster::TREE_NORMAL);
        let tree_errors = &targets.whole(gpu, &lines::trees::TREE_ERRORS);
        let (height_m, ramp) = (forest.height_m(), lines.ramp);
        let chosen = lines::trees::Inputs {
            view,
            height_m,
            only_trees,
            ramp,
            surface_id,
            depth,
            tree_normal,
            errors,
            tree_errors,
        };
        lines::trees::run(recorder, &chosen);
        tree_errors.clone()
    });
    threshold::run(recorder, lines, &threshold::Inputs { view, errors, directions, line: &line });
    line
}

/// Draws lines by curvature. Trees have no curvature; they get LSA contours.
fn by_curvature(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    lines: &Lines,
    on: &OnSurface<'_>,
    targets: &mut Targets,
) -> Target {
    let gpu = recorder.gpu();
    let &OnSurface { view, surface_id, distance, normal, .. } = on;
    let settings = &inputs.style.curvature;
    let tree_line = if inputs.world.forest().is_some() {
        detect(recorder, inputs, &Lines { detector: Detector::Lsa, ..lines.clone() }, true, on, targets)
    } else {
        targets.sized(gpu, &NOTHING, [1, 1])
    };
    let (_, radial) = curvatures(recorder, settings.feature_px, on, targets);
    let line = targets.whole(gpu, &curvature::CURVATURE_LINE);
    let (radial, tree_line) = (&radial, &tree_line);
    let origin_m = inputs.rig.origin_m;
    let drawn =
        curvature::Inputs { view, settings, origin_m, surface_id, distance, normal, radial, tree_line, line: &line };
    curvature::run(recorder, &drawn);
    line
}

/// Computes the curvature of the surface, and its radial curvature, that is, toward the eye.
fn curvatures(
    recorder: &mut Recorder<'_>,
    feature_px: f32,
    on: &OnSurface<'_>,
    targets: &mut Targets,
) -> (Shapes, Target) {
    let shapes = bend::shapes(recorder, feature_px, &on.bend_inputs(), targets);
    let toward_eye = targets.sized(recorder.gpu(), &radial::RADIAL, shapes.normal.size_px());
    radial::run(recorder, &radial::Inputs { view: on.view, shapes: &shapes, radial: &toward_eye });
    (shapes, toward_eye)
}

/// Adds the edges that are found on the visible surface: suggestive contours, ridges and valleys, as the style's
/// strokes require.
pub(super) fn add_edges(
    recorder: &mut Recorder<'_>,
    edges: &EdgeList,
    strokes: &Strokes,
    on: &OnSurface<'_>,
    targets: &mut Targets,
) {
    let &OnSurface { view, distance, normal, other_eye_m, .. } = on;
    if let Some(feature_px) = strokes.suggestive_px {
        let (shapes, radial) = curvatures(recorder, feature_px, on, targets);
        let (shapes, radial) = (&shapes, &radial);
        let inputs = suggestive::Inputs { view, settings: strokes, distance, normal, shapes, radial, other_eye_m };
        suggestive::run(recorder, edges, &inputs);
    }
    if let Some(feature_px) = strokes.ridge_px {
        let (shapes, _) = curvatures(recorder, feature_px, on, targets);
        let (shapes, min_bend) = (&shapes, strokes.ridge_bend);
        let apparent = strokes.ridge_apparent.then(|| {
            let apparent = targets.sized(recorder.gpu(), &apparent::APPARENT, shapes.normal.size_px());
            apparent::run(recorder, &apparent::Inputs { view, shapes, apparent: &apparent });
            apparent
        });
        let sides = [(false, strokes.ridge_width), (true, strokes.valley_width)];
        for (valleys, _) in sides.into_iter().filter(|(_, width)| *width > 0.0) {
            let apparent = apparent.as_ref();
            let inputs = ridges::Inputs { view, min_bend, valleys, distance, normal, shapes, apparent };
            ridges::run(recorder, edges, &inputs);
        }
    }
}
