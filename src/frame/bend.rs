//! How the surface bends that an eye sees, for lines, marks and light.

use crate::composite::NOTHING;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, Targets};
use crate::surface::curvature::{self, Shapes};
use crate::surface::meshes::{DrawnMeshes, curvature as mesh_curvature};

/// What an eye sees.
pub(super) struct AtEye<'a> {
    /// `View`.
    pub(super) view: &'a Resource,
    /// What stands on the land.
    pub(super) meshes: Option<&'a DrawnMeshes>,
    /// Heights and tables.
    pub(super) heights: &'a [Named],
    pub(super) surface_id: &'a Target,
    pub(super) position: &'a Target,
    pub(super) normal: &'a Target,
    /// Of a style with water, which does not bend.
    pub(super) water: Option<&'a Target>,
}

/// Its shape, with features of `feature_px`. The next call writes over it.
pub(super) fn shapes(cx: &mut Cx<'_>, feature_px: f32, eye: &AtEye<'_>, targets: &mut Targets) -> Shapes {
    let gpu = cx.gpu();
    let &AtEye { view, meshes, heights: terrain, surface_id, position, normal, water } = eye;
    let shapes = Shapes::of(gpu, targets);
    let nothing = &targets.sized(gpu, &NOTHING, [1, 1]);
    let water = water.unwrap_or(nothing);
    let land = curvature::Inputs { view, terrain, feature_px, surface_id, position, water, shapes: &shapes };
    curvature::run(cx, &land);
    if let Some(meshes) = meshes {
        let shapes = &shapes;
        let inputs = mesh_curvature::Inputs { view, meshes, feature_px, surface_id, position, normal, shapes };
        mesh_curvature::run(cx, &inputs);
    }
    shapes
}
