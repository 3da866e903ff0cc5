//! Draws the trees in view that are meshes: depth, surface id and normal. See `shaders/surface/trees/raster.wgsl`.

use super::colors::Colored;
use super::sway::{STEP_FORMAT, Swaying};
use super::{DrawnTrees, list_of};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::Buffer;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Drawing, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::shared::trees::{MIDDLE, NEAR};
pub(super) use crate::gpu::wgsl::surface::trees::raster::TreeVertex;
use crate::surface::local_color::LOCAL_COLOR_FORMAT;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

pub(super) const NORMAL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Normal of trees, at pixels whose surface id is a tree; undefined elsewhere. The last channel is lightness.
pub(crate) const TREE_NORMAL: TargetKind =
    TargetKind::attachment("tree normal", NORMAL_FORMAT, Group::Trees.shows("Normal and lightness of trees"));

pub(super) const FORM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// xyz: normal of the rounded body that the crown fills; w: how far the plane through the crown's middle that faces the
/// eye is behind the visible surface, in metres along the view axis. Written where a tree is seen.
pub(crate) const TREE_FORM: TargetKind = TargetKind::attachment(
    "tree form",
    FORM_FORMAT,
    Group::Trees.shows("Normal of the rounded body that the crown of a tree fills"),
);

/// Shader definitions of trees in wind.
pub(super) const SWAYING_DEFINITIONS: &[&str] = &["WIND"];

/// Inputs and outputs of the passes that draw trees.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The terrain uniform, for the curvature of the earth.
    pub terrain: Named,
    /// The trees in view.
    pub trees: &'a DrawnTrees,
    /// The sway of the trees, if wind blows.
    pub swaying: Option<&'a Swaying>,
    /// The trees' local colours, if the style needs them.
    pub colored: Option<&'a Colored>,
    /// Species records, from [`super::place`].
    pub species: &'a Resource,
    pub depth: &'a Target,
    pub surface_id: &'a Target,
    pub tree_normal: &'a Target,
    pub tree_form: &'a Target,
}

impl Inputs<'_> {
    /// Returns the variant of the pass `name` for this frame.
    pub(super) fn variant(&self, name: &'static str) -> Draw {
        let [id, normal, form] = [ID_FORMAT, NORMAL_FORMAT, FORM_FORMAT].map(replaced);
        let standing = Draw { depth: Some(DEPTH_FORMAT), writes_depth: true, ..Draw::triangles(name) };
        let (step, color) = (replaced(STEP_FORMAT), replaced(LOCAL_COLOR_FORMAT));
        match (self.swaying.is_some(), self.colored.is_some()) {
            (false, false) => Draw { colors: [id, normal, form, None, None], ..standing },
            (true, false) => {
                Draw { definitions: SWAYING_DEFINITIONS, colors: [id, normal, form, step, None], ..standing }
            }
            (false, true) => {
                Draw { definitions: &["LOCAL_COLOR"], colors: [id, normal, form, color, None], ..standing }
            }
            (true, true) => {
                Draw { definitions: &["LOCAL_COLOR", "WIND"], colors: [id, normal, form, step, color], ..standing }
            }
        }
    }

    /// Returns the bindings that the shaders of both passes have, for one list of trees.
    pub(super) fn resources(&self, list: u32) -> Vec<Named> {
        let mut resources = vec![
            ("view", self.view.clone()),
            self.terrain.clone(),
            ("tree_instances", self.trees.instances.binding()),
            ("tree_order", self.trees.order_of(list).binding()),
            ("tree_species", self.species.clone()),
        ];
        resources.extend(self.swaying.into_iter().flat_map(Swaying::resources));
        resources
    }

    /// Draws lists of trees, each with its list number and the indices of its mesh, over the current contents of the
    /// targets.
    pub(super) fn draw(
        &self,
        recorder: &mut Recorder<'_>,
        name: &'static str,
        drawings: &[(u32, Option<&Buffer>, Drawing)],
    ) {
        let all: Vec<&Drawing> = drawings.iter().map(|(.., drawing)| drawing).collect();
        let mut colors = vec![self.surface_id, self.tree_normal, self.tree_form];
        colors.extend(self.swaying.map(|swaying| &swaying.step));
        colors.extend(self.colored.map(|colored| &colored.local_color));
        let on = Attachments { colors: &colors, depth: Some(self.depth), clears: Clears::Nothing };
        recorder.render(name, &all, on, |pass| {
            for (list, indices, drawing) in drawings {
                drawing.set(pass);
                self.trees.draw(pass, *list, *indices);
            }
        });
    }
}

/// Draws the trees.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let draw = &inputs.variant("surface/trees/raster");
    let mut drawings: Vec<(u32, Option<&Buffer>, Drawing)> = Vec::new();
    for (number, model) in inputs.trees.shared.species.iter().enumerate() {
        for (level, mesh) in [(NEAR, &model.near), (MIDDLE, &model.middle)] {
            let list = list_of(inputs.trees.species(), number as u32, level);
            let mut resources = inputs.resources(list);
            resources.push(("tree_vertices", mesh.vertices.binding()));
            resources.extend(inputs.colored.map(|colored| {
                let colors = &colored.colors.species[number];
                ("tree_colors", if level == NEAR { colors.near.binding() } else { colors.middle.binding() })
            }));
            drawings.push((list, Some(&mesh.indices), recorder.drawing(draw, &resources)));
        }
    }
    inputs.draw(recorder, draw.name, &drawings);
}
