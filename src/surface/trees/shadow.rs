//! The shadows of trees. See `shaders/surface/trees/shadow.wgsl`.

use super::DrawnTrees;
use super::place::Placed;
use super::raster::SWAYING_DEFINITIONS;
use super::sway::Swaying;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::{Draw, greatest};
use crate::gpu::recorder::{Attachments, Clears, Drawing, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};
pub(super) use crate::gpu::wgsl::surface::trees::shadow::CORNERS;
use crate::surface::DEPTH_FORMAT;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// The share of sunlight that trees block, 0 to 1.
pub(crate) const TREE_SHADOW: TargetKind =
    TargetKind::attachment("tree shadow", FORMAT, Group::Trees.shows("Share of the sunlight that trees block"));

const STANDING: Draw = Draw {
    // The darkest of overlapping shadows.
    colors: [greatest(FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    ..Draw::triangles("surface/trees/shadow")
};
const SWAYING: Draw = Draw { definitions: SWAYING_DEFINITIONS, ..STANDING };

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The terrain uniform, for the curvature of the earth.
    pub terrain: Named,
    /// The trees in view, and those whose shadows are in view.
    pub trees: &'a DrawnTrees,
    /// The output of [`super::place`].
    pub placed: &'a Placed,
    /// The sway of the trees, if wind blows.
    pub swaying: Option<&'a Swaying>,
    /// Depth of everything that is seen.
    pub depth: &'a Target,
    /// Surface ids of everything that is seen.
    pub surface_id: &'a Target,
    /// Position of everything that is seen.
    pub distance: &'a Target,
    pub tree_shadow: &'a Target,
}

/// Draws the shadows.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let &Inputs { view, ref terrain, trees, placed, swaying, depth, surface_id, distance, tree_shadow } = inputs;
    let draw = if swaying.is_some() { &SWAYING } else { &STANDING };
    let mut drawings: Vec<Drawing> = Vec::new();
    for (species, model) in trees.shared.species.iter().enumerate() {
        let mut resources = vec![
            ("view", view.clone()),
            terrain.clone(),
            ("tree_instances", trees.instances.binding()),
            ("tree_order", trees.order_of(trees.list_of_shadows(species as u32)).binding()),
            ("tree_species", placed.species.clone()),
            ("tree_pictures", Resource::Texture(super::impostor::PICTURES, model.alone.of_species.clone())),
            ("forest", placed.forest.clone()),
            ("surface_id", surface_id.into()),
            ("distance_m", distance.into()),
        ];
        resources.extend(swaying.into_iter().flat_map(Swaying::resources));
        drawings.push(recorder.drawing(draw, &resources));
    }
    let all: Vec<&Drawing> = drawings.iter().collect();
    let on = Attachments { colors: &[tree_shadow], depth: Some(depth), clears: Clears::Colors };
    recorder.render(draw.name, &all, on, |pass| {
        for (species, drawing) in drawings.iter().enumerate() {
            drawing.set(pass);
            trees.draw(pass, trees.list_of_shadows(species as u32), None);
        }
    });
}
