//! The passes of trees for an eye, in the order in which they run.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::scene::view::View;
use crate::surface::edges::EdgeList;
use crate::surface::trees::colors::Colored;
use crate::surface::trees::place::Placed;
use crate::surface::trees::sway::Swaying;
use crate::surface::trees::{DrawnTrees, edges, impostor, marks, place, raster, shadow, sway, tile_depth};

/// The view of an eye, and the targets over which trees are drawn.
pub(super) struct EyeInputs<'a> {
    /// The uniform of `view_of_eye`.
    pub view: &'a Resource,
    pub view_of_eye: &'a View,
    /// Depth of land and models.
    pub depth: &'a Target,
    /// Surface ids of land and models.
    pub surface_id: &'a Target,
    /// [`LOCAL_COLOR`](crate::surface::local_color::LOCAL_COLOR), in a style that needs it.
    pub local_color: Option<&'a Target>,
}

/// The trees that an eye sees.
pub(super) struct SeenTrees {
    trees: DrawnTrees,
    /// The result of their selection.
    pub placed: Placed,
    /// [`raster::TREE_NORMAL`].
    pub normal: Target,
    /// [`raster::TREE_FORM`].
    pub form: Target,
    swaying: Option<Swaying>,
}

impl SeenTrees {
    /// Returns [`sway::TREE_STEP`], if there is wind.
    pub(super) fn step(&self) -> Option<&Target> {
        self.swaying.as_ref().map(|swaying| &swaying.step)
    }
}

/// Finds the trees of a world's forest and draws them over land and models. Adds the edges of near trees to
/// `edge_list`, which is given if strokes are rebuilt. Returns `None`, and draws nothing, without a forest and while
/// its species are grown in the background.
pub(super) fn see(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    at: &EyeInputs<'_>,
    edge_list: Option<&EdgeList>,
    targets: &mut Targets,
) -> Option<SeenTrees> {
    let &FrameInputs { world, rig, style, light, .. } = inputs;
    let &EyeInputs { view, view_of_eye, depth, surface_id, local_color } = at;
    let (gpu, terrain, forest) = (recorder.gpu(), &world.terrain, world.forest()?);
    let trees = DrawnTrees::of(recorder, forest, world.tree_models())?;
    let (wind, detail, origin_m) = (world.wind(), world.tree_detail(), rig.origin_m);
    let rules = place::Inputs {
        view,
        eye: view_of_eye,
        origin_m,
        terrain,
        forest,
        cover: world.forest_cover(),
        sea_level_m: world.sea_level_m(),
        wind,
        to_sun: light.to_sun,
        has_shadows: style.needs_tree_shadows(),
        depth,
        tile_depth: &tile_depth::target(gpu, targets),
        detail,
    };
    let placed = place::run(recorder, &rules, &trees);
    let swaying = wind.map(|wind| {
        let step = targets.whole(gpu, &sway::TREE_STEP);
        let clock = view_of_eye.clock;
        let instances = placed.instances;
        sway::run(recorder, sway::Inputs { wind, clock, origin_m, detail, trees: &trees, instances, step })
    });
    if let Some(list) = edge_list {
        let (terrain, trees, swaying) = (terrain.uniform(), &trees, swaying.as_ref());
        edges::run(recorder, list, &edges::Inputs { view, terrain, trees, swaying });
    }
    let normal = targets.whole(gpu, &raster::TREE_NORMAL);
    let form = targets.whole(gpu, &raster::TREE_FORM);
    let colored = local_color.map(|local_color| Colored::of(recorder, forest, &trees, local_color.clone()));
    let drawn = raster::Inputs {
        view,
        terrain: terrain.uniform(),
        trees: &trees,
        swaying: swaying.as_ref(),
        colored: colored.as_ref(),
        species: &placed.species,
        depth,
        surface_id,
        tree_normal: &normal,
        tree_form: &form,
    };
    raster::run(recorder, &drawn);
    impostor::run(recorder, &drawn);
    Some(SeenTrees { trees, placed, normal, form, swaying })
}

/// Computes the share of sunlight that trees block, in a style with shadows. `distance` must be that of all surfaces.
pub(super) fn shadow(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    at: &EyeInputs<'_>,
    seen: &SeenTrees,
    distance: &Target,
    targets: &mut Targets,
) -> Option<Target> {
    if !inputs.style.needs_tree_shadows() {
        return None;
    }
    let &EyeInputs { view, depth, surface_id, .. } = at;
    let tree_shadow = targets.whole(recorder.gpu(), &shadow::TREE_SHADOW);
    let thrown = shadow::Inputs {
        view,
        terrain: inputs.world.terrain.uniform(),
        trees: &seen.trees,
        placed: &seen.placed,
        swaying: seen.swaying.as_ref(),
        depth,
        surface_id,
        distance,
        tree_shadow: &tree_shadow,
    };
    shadow::run(recorder, &thrown);
    Some(tree_shadow)
}

/// Computes the distances and normals that hatching marks use: [`marks::MARK_DISTANCE`] and [`marks::MARK_SURFACE`].
pub(super) fn marks(
    recorder: &mut Recorder<'_>,
    [surface_id, distance, normal, tree_form]: [&Target; 4],
    view: &Resource,
    targets: &mut Targets,
) -> [Target; 2] {
    let gpu = recorder.gpu();
    let [mark_distance, mark_surface] =
        [marks::MARK_DISTANCE, marks::MARK_SURFACE].map(|kind| targets.whole(gpu, &kind));
    let inputs = marks::Inputs {
        view,
        surface_id,
        distance,
        normal,
        tree_form,
        mark_distance: &mark_distance,
        mark_surface: &mark_surface,
    };
    marks::run(recorder, &inputs);
    [mark_distance, mark_surface]
}
