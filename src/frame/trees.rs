//! The passes of trees, in the order in which they run: for each eye that sees a forest.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::scene::view::View;
use crate::surface::edges::EdgeList;
use crate::surface::trees::colors::Colored;
use crate::surface::trees::place::Placed;
use crate::surface::trees::sway::Swaying;
use crate::surface::trees::{DrawnTrees, edges, impostor, marks, place, raster, shadow, sway};

/// What trees are drawn for, and over.
pub(super) struct AtEye<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// The same.
    pub view_of_eye: &'a View,
    /// With all that stands on the land but trees.
    pub depth: &'a Target,
    /// The same.
    pub surface_id: &'a Target,
    /// [`LOCAL_COLOR`](crate::surface::local_color::LOCAL_COLOR), in a style that asks for it.
    pub local_color: Option<&'a Target>,
}

/// The trees that an eye sees.
pub(super) struct SeenTrees {
    trees: DrawnTrees,
    /// What they were told.
    pub placed: Placed,
    /// [`raster::TREE_NORMAL`].
    pub normal: Target,
    /// [`raster::TREE_FORM`].
    pub form: Target,
    swaying: Option<Swaying>,
}

impl SeenTrees {
    /// [`sway::TREE_STEP`], where wind blows.
    pub(super) fn step(&self) -> Option<&Target> {
        self.swaying.as_ref().map(|swaying| &swaying.step)
    }
}

/// Finds the trees of a world's forest and draws them over what is there. Nothing while its species are grown beside the
/// frame. Adds the edges of near ones to the list, where strokes are made anew.
pub(super) fn see(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    at: &AtEye<'_>,
    edge_list: Option<&EdgeList>,
    targets: &mut Targets,
) -> Option<SeenTrees> {
    let &FrameInputs { world, rig, style, light, .. } = inputs;
    let &AtEye { view, view_of_eye, depth, surface_id, local_color } = at;
    let (gpu, terrain, forest) = (recorder.gpu(), &world.terrain, world.forest()?);
    let trees = DrawnTrees::of(recorder, forest, world.tree_models())?;
    let (wind, detail, origin_m) = (world.wind(), world.tree_detail(), rig.origin_m);
    let asked = place::Inputs {
        view,
        eye: view_of_eye,
        origin_m,
        terrain,
        forest,
        cover: world.forest_cover(),
        wind,
        to_sun: light.to_sun,
        has_shadows: style.needs_tree_shadows(),
        detail,
    };
    let placed = place::run(recorder, &asked, &trees);
    let swaying = wind.map(|wind| {
        let step = targets.whole(gpu, &sway::TREE_STEP);
        let clock = view_of_eye.clock;
        sway::run(recorder, sway::Inputs { wind, clock, origin_m, detail, trees: &trees, step })
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

/// What trees take of the sun, in a style that has shadows, where all positions are there.
pub(super) fn shadow(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    at: &AtEye<'_>,
    seen: &SeenTrees,
    position: &Target,
    targets: &mut Targets,
) -> Option<Target> {
    if !inputs.style.needs_tree_shadows() {
        return None;
    }
    let &AtEye { view, depth, surface_id, .. } = at;
    let tree_shadow = targets.whole(recorder.gpu(), &shadow::TREE_SHADOW);
    let thrown = shadow::Inputs {
        view,
        terrain: inputs.world.terrain.uniform(),
        trees: &seen.trees,
        placed: &seen.placed,
        swaying: seen.swaying.as_ref(),
        depth,
        surface_id,
        position,
        tree_shadow: &tree_shadow,
    };
    shadow::run(recorder, &thrown);
    Some(tree_shadow)
}

/// Where marks lie, and what they shade.
pub(super) fn marks(
    recorder: &mut Recorder<'_>,
    [surface_id, position, normal, tree_form]: [&Target; 4],
    view: &Resource,
    targets: &mut Targets,
) -> [Target; 2] {
    let gpu = recorder.gpu();
    let [mark_place, mark_surface] = [marks::MARK_PLACE, marks::MARK_SURFACE].map(|kind| targets.whole(gpu, &kind));
    let inputs = marks::Inputs {
        view,
        surface_id,
        position,
        normal,
        tree_form,
        mark_place: &mark_place,
        mark_surface: &mark_surface,
    };
    marks::run(recorder, &inputs);
    [mark_place, mark_surface]
}
