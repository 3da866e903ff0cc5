//! Which meshes an eye sees. See `shaders/surface/meshes/cull.wgsl`.
//!
//! A mesh is left out where its sphere is out of view, where the earth hides it, and where all of it is smaller than
//! [`SMALLEST_PX`]. One whose mean edge is shorter than [`SHORTEST_EDGE_PX`] is drawn, but its edges are not looked
//! for: they would be noise. [`seen`] says the same in f64, and a test holds the GPU against it.

use bytemuck::Zeroable;
use glam::DVec3;

use super::DrawnMeshes;
use super::instances::fixed_point;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Cx;
pub(crate) use crate::gpu::wgsl::surface::meshes::cull::Cull as CullUniform;
pub use crate::gpu::wgsl::surface::meshes::cull::MeshDraws;
use crate::mesh::placed::{Placed, Standing};
use crate::scene::view::View;
use crate::tiles::earth_curvature::EarthCurvature;

/// What is smaller than this across is not drawn.
pub const SMALLEST_PX: f64 = 1.0;
/// Meshes whose mean edge is shorter on the picture, at their nearest point, have no edges.
pub const SHORTEST_EDGE_PX: f64 = 0.5;
/// Threads of a workgroup; `MOST_STANDING` over this is at most this, too.
const WORKGROUP: u32 = 256;

/// Where [`MeshDraws`] has the workgroups for vertices.
pub(super) const VERTEX_GROUPS: u64 = std::mem::offset_of!(MeshDraws, vertex_groups) as u64;
/// Where it has those for triangles with edges.
pub(super) const NEAR_GROUPS: u64 = std::mem::offset_of!(MeshDraws, near_groups) as u64;

/// Sums of workgroups.
const COUNTS: BufferKind = BufferKind::storage("mesh counts");

/// Decides for all that stands in the world. Reads `terrain`, for the curvature of the earth.
pub fn run(cx: &mut Cx<'_>, view: &Resource, origin_m: DVec3, terrain: Named, meshes: &DrawnMeshes) {
    let [origin_coarse, origin_fine] = fixed_point(origin_m);
    let groups = (meshes.placed().standing.len() as u32).div_ceil(WORKGROUP);
    let bytes = u64::from(groups) * 16;
    let counts = cx.buffer(&COUNTS, bytes).slice(0, bytes);
    for stage in 0..3 {
        let uniform = CullUniform {
            origin_coarse,
            stage,
            origin_fine,
            smallest_px: SMALLEST_PX as f32,
            shortest_edge_px: SHORTEST_EDGE_PX as f32,
            ..CullUniform::zeroed()
        };
        let resources = [
            ("view", view.clone()),
            ("cull", cx.uniform("cull", &uniform)),
            ("standings", meshes.meshes.standings.binding()),
            ("mesh_instances", meshes.instances.binding()),
            ("mesh_counts", counts.binding()),
            ("mesh_draws", meshes.draws.binding()),
            terrain.clone(),
        ];
        cx.groups("surface/meshes/cull", [if stage == 1 { 1 } else { groups }, 1], &resources);
    }
}

/// What a view sees of what stands in a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleInstance {
    /// Which of [`Placed::standing`].
    pub standing: usize,
    /// Its edges are looked for.
    pub is_near: bool,
}

/// The twin: those in view, in the order of [`Placed::standing`].
pub fn seen(placed: &Placed, view: &View, earth_curvature: &EarthCurvature) -> Vec<VisibleInstance> {
    let (frustum, focal_px) = (view.frustum(), view.focal_px());
    let of = |(number, standing): (usize, &Standing)| {
        let mesh = placed.mesh(standing);
        let flat_m = standing.middle_m - view.pose.position_m;
        let top_m = standing.middle_m.z + mesh.radius_m * standing.scale;
        let radius_m = mesh.radius_m * standing.scale * (1.0 + top_m * earth_curvature.inverse_radius).max(1.0);
        let at_m = earth_curvature.bend(flat_m);
        let away_m = at_m.length();
        if 2.0 * radius_m * focal_px < SMALLEST_PX * away_m
            || !frustum.may_see_sphere(at_m, radius_m)
            || earth_curvature.hides_sphere(flat_m, mesh.radius_m * standing.scale)
        {
            return None;
        }
        let edge_px_m = mesh.mean_edge_m * standing.scale * focal_px;
        Some(VisibleInstance { standing: number, is_near: edge_px_m >= SHORTEST_EDGE_PX * (away_m - radius_m) })
    };
    placed.standing.iter().enumerate().filter_map(of).collect()
}
