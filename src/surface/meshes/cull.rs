//! Selects the meshes that an eye sees. See `shaders/surface/meshes/cull.wgsl`.
//!
//! A mesh is left out if its bounding sphere is out of view, if the earth hides it, or if all of it is smaller than
//! [`SMALLEST_PX`]. It is drawn at the coarsest level whose error is at most [`LARGEST_ERROR_PX`] in the middle of the
//! picture. A mesh whose mean edge at that level is shorter than [`SHORTEST_EDGE_PX`] is drawn, but adds no edges to
//! the edge list: they would be noise. [`seen`] is the CPU twin, in f64, and a test compares the GPU with it.
//!
//! If more is in view than there is room for, larger errors are allowed. Meshes that have no room even at the coarsest
//! levels, which are the last ones of the scene, are left out and counted ([`MeshDraws::left_out`]).

use super::DrawnMeshes;
use super::instances::fixed_point;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::surface::meshes::cull::Cull as CullUniform;
pub(crate) use crate::gpu::wgsl::surface::meshes::cull::MeshDraws;
#[cfg(test)]
use crate::mesh::placed::{Placed, Standing};
use crate::scene::view::{Rig, View};
#[cfg(test)]
use crate::tiles::earth_curvature::EarthCurvature;
use bytemuck::Zeroable;

/// Meshes smaller than this across are not drawn, in pixels.
pub(crate) const SMALLEST_PX: f64 = 1.0;
/// The largest error of a level on the picture, in pixels.
pub(crate) const LARGEST_ERROR_PX: f64 = 0.5;
/// Meshes whose mean edge is shorter than this at their nearest point have no edges, in pixels.
pub(crate) const SHORTEST_EDGE_PX: f64 = 0.5;
/// Threads of a workgroup; the square of this number must be at least `MAX_INSTANCES`.
const WORKGROUP: u32 = 256;

/// Offset of the workgroup counts for vertices in [`MeshDraws`].
pub(super) const VERTEX_GROUPS: u64 = std::mem::offset_of!(MeshDraws, vertex_groups) as u64;
/// Offset of the workgroup counts for triangles with edges.
pub(super) const NEAR_GROUPS: u64 = std::mem::offset_of!(MeshDraws, near_groups) as u64;

/// Sums of each workgroup.
const COUNTS: BufferKind = BufferKind::storage("mesh counts");

/// Vertices in view at each of the errors that are tried.
const DEMAND: BufferKind = BufferKind::storage("mesh demand");
/// The initial demand.
const NO_DEMAND: [u32; crate::gpu::wgsl::surface::meshes::cull::TRIES as usize] =
    [0; crate::gpu::wgsl::surface::meshes::cull::TRIES as usize];

/// Culls all mesh instances of the world. `terrain` is the terrain uniform, for the curvature of the earth.
pub(crate) fn run(recorder: &mut Recorder<'_>, view: &Resource, rig: &Rig, terrain: Named, meshes: &DrawnMeshes) {
    let [origin_coarse, origin_fine] = fixed_point(rig.origin_m);
    let groups = meshes.standing().div_ceil(WORKGROUP);
    let bytes = u64::from(groups) * 16;
    let counts = recorder.buffer(&COUNTS, bytes).slice(0, bytes);
    // All eyes of a rig draw the same levels: those that its nearest and sharpest eye needs.
    let focal_px = rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max);
    let eyes_m = rig.eyes.iter().map(|eye| eye.pose.position_m.distance(rig.origin_m)).fold(0.0, f64::max);
    let room = meshes.room();
    let demand = recorder.buffer(&DEMAND, size_of_val(&NO_DEMAND) as u64);
    recorder.reset(&demand, &NO_DEMAND);
    // Demand is counted only if the whole world might not fit.
    let first = meshes.may_lack_room().then_some(3);
    for stage in first.into_iter().chain(0..3) {
        let uniform = CullUniform {
            origin_coarse,
            stage,
            origin_fine,
            smallest_px: SMALLEST_PX as f32,
            shortest_edge_px: SHORTEST_EDGE_PX as f32,
            error_m: (LARGEST_ERROR_PX / focal_px) as f32,
            eyes_m: eyes_m as f32,
            room_vertices: room.vertices as u32,
            room_triangles: room.triangles as u32,
            ..CullUniform::zeroed()
        };
        let resources = [
            ("view", view.clone()),
            ("cull", recorder.uniform("cull", &uniform)),
            ("standings", meshes.meshes.standings.binding()),
            ("mesh_levels", meshes.meshes.levels.binding()),
            ("mesh_instances", meshes.instances.binding()),
            ("mesh_counts", counts.binding()),
            ("mesh_draws", meshes.draws.binding()),
            ("mesh_demand", demand.binding()),
            terrain.clone(),
        ];
        recorder.groups("surface/meshes/cull", [if stage == 1 { 1 } else { groups }, 1], &resources);
    }
}

/// A mesh instance that is in view.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VisibleInstance {
    /// Index into [`Placed::standing`].
    pub standing: usize,
    /// Level of detail; 0 is the whole mesh.
    pub level: usize,
    /// Whether its edges are added to the edge list.
    pub is_near: bool,
}

/// The CPU twin: returns the instances in view, in the order of [`Placed::standing`].
#[cfg(test)]
pub(crate) fn seen(placed: &Placed, view: &View, earth_curvature: &EarthCurvature) -> Vec<VisibleInstance> {
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
        let nearest_m = (away_m - radius_m).max(0.0);
        let is_fine = |error_m: f64| error_m * standing.scale * focal_px <= LARGEST_ERROR_PX * nearest_m;
        let coarser = placed.coarser(standing.mesh);
        let level = coarser.iter().take_while(|level| is_fine(level.error_m)).count();
        let drawn = level.checked_sub(1).map_or(mesh, |level| &coarser[level].mesh);
        let edge_px_m = drawn.mean_edge_m * standing.scale * focal_px;
        Some(VisibleInstance { standing: number, level, is_near: edge_px_m >= SHORTEST_EDGE_PX * (away_m - radius_m) })
    };
    placed.standing.iter().enumerate().filter_map(of).collect()
}
