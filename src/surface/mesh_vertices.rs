//! Which meshes a view sees, and where their vertices are. See `shaders/surface/mesh_vertices.wgsl`.
//!
//! A mesh is left out where its box is out of view, where the earth hides it, and where all of it is smaller than
//! [`SMALLEST_PX`]. One whose mean edge is shorter than [`SHORTEST_EDGE_PX`] is drawn, but its edges are not looked for:
//! they would be noise.

use std::convert::Infallible;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec2, Vec3};

use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;
use crate::mesh::placed::{Placed, Standing};
use crate::mesh::{Across, Mesh};
use crate::surface::view::View;
use crate::tiles::earth_curvature::EarthCurvature;
use crate::tiles::frustum::Bounds;

/// What is smaller than this across is not drawn.
pub const SMALLEST_PX: f64 = 1.0;
/// Meshes whose mean edge is shorter on the picture, at their nearest point, have no edges.
pub const SHORTEST_EDGE_PX: f64 = 0.5;
/// Threads of a workgroup, and workgroups of a row: the shaders have the same.
const WORKGROUP: u32 = 64;
const ROW: u32 = 65_535;

/// `MeshInstance` in `shaders/shared/meshes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MeshInstance {
    east: [f32; 4],
    north: [f32; 4],
    up: [f32; 4],
    first_vertex: u32,
    vertices: u32,
    vertices_before: u32,
    first_triangle: u32,
    triangles: u32,
    near_before: u32,
    is_near: u32,
    is_solid: u32,
    first_place: u32,
    first_number: u32,
    padding_a: u32,
    padding_b: u32,
}

crate::gpu::shared::describe!(MeshInstance as "MeshInstance" in "surface/mesh_resolve": east, north, up, first_vertex, vertices, vertices_before, first_triangle, triangles, near_before, is_near, is_solid, first_place, first_number, padding_a, padding_b);

/// `MeshTriangle` in `shaders/shared/meshes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MeshTriangle {
    corner_a: u32,
    corner_b: u32,
    corner_c: u32,
    across_ab: u32,
    across_bc: u32,
    across_ca: u32,
    normal_a: u32,
    normal_b: u32,
    normal_c: u32,
}

crate::gpu::shared::describe!(MeshTriangle as "MeshTriangle" in "surface/mesh_resolve": corner_a, corner_b, corner_c, across_ab, across_bc, across_ca, normal_a, normal_b, normal_c);

/// What a view sees of what stands in a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Which of [`Placed::standing`].
    pub standing: usize,
    /// Its edges are looked for.
    pub is_near: bool,
}

/// Those in view, in the order of [`Placed::standing`].
pub fn seen(placed: &Placed, view: &View, earth_curvature: &EarthCurvature) -> Vec<Seen> {
    let (frustum, focal_px) = (view.frustum(), view.focal_px());
    let of = |(number, standing): (usize, &Standing)| {
        let mesh = placed.mesh(standing);
        let radius_m = mesh.radius_m * standing.scale;
        let middle_m = standing.middle_m - view.pose.position_m;
        let flat = Bounds { low_m: middle_m - DVec3::splat(radius_m), high_m: middle_m + DVec3::splat(radius_m) };
        let bounds = earth_curvature.bend_bounds(&flat)?;
        let away_m = middle_m.length();
        if !frustum.may_see(&bounds) || 2.0 * radius_m * focal_px < SMALLEST_PX * away_m {
            return None;
        }
        let edge_px_m = mesh.mean_edge_m * standing.scale * focal_px;
        Some(Seen { standing: number, is_near: edge_px_m >= SHORTEST_EDGE_PX * (away_m - radius_m) })
    };
    placed.standing.iter().enumerate().filter_map(of).collect()
}

/// Vertices of the meshes themselves.
const VERTICES: BufferKind = BufferKind::storage("mesh vertices");
/// [`MeshTriangle`]s of the meshes themselves.
const TRIANGLES: BufferKind = BufferKind::storage("mesh triangles");
/// [`MeshInstance`]s in view.
const INSTANCES: BufferKind = BufferKind::storage("mesh instances");
/// Vertices of all that stands in the world, metres from the rig's origin; those of what is not in view mean nothing.
pub const POSITIONS: BufferKind = BufferKind::storage("mesh positions");

/// The meshes of a world on the GPU.
struct MeshBuffers {
    placed: Arc<Placed>,
    /// Of each mesh: its first vertex and its first triangle.
    firsts: Vec<[u32; 2]>,
    vertices: Buffer,
    triangles: Buffer,
}

impl MeshBuffers {
    fn new(gpu: &Gpu, placed: &Arc<Placed>) -> Self {
        let (mut vertices, mut triangles): (Vec<[f32; 4]>, Vec<MeshTriangle>) = (Vec::new(), Vec::new());
        let mut firsts = Vec::new();
        for mesh in &placed.meshes {
            firsts.push([vertices.len() as u32, triangles.len() as u32]);
            vertices.extend(mesh.vertices_m.iter().map(|[x, y, z]| [*x, *y, *z, 1.0]));
            triangles.extend(packed(mesh));
        }
        Self {
            placed: Arc::clone(placed),
            firsts,
            vertices: Buffer::with(gpu, &VERTICES, &vertices),
            triangles: Buffer::with(gpu, &TRIANGLES, &triangles),
        }
    }
}

/// What an eye sees of the meshes, on the GPU.
pub struct SeenMeshes {
    meshes: Arc<MeshBuffers>,
    /// As many as are in view: the shaders ask how many there are.
    instances: Buffer,
    positions: Buffer,
    /// Triangles of each instance in view.
    pub triangles: Vec<u32>,
    /// Triangles whose edges are looked for.
    pub near_triangles: u32,
    vertices: u32,
}

impl SeenMeshes {
    /// Uploads what an eye sees of a world, and the meshes themselves if they are others than before.
    pub fn upload(
        cx: &mut Cx<'_>,
        placed: &Arc<Placed>,
        view: &View,
        origin_m: DVec3,
        earth_curvature: &EarthCurvature,
    ) -> Self {
        let meshes = cx.kept(
            |known: &MeshBuffers| Arc::ptr_eq(&known.placed, placed),
            |gpu| Ok::<_, Infallible>(MeshBuffers::new(gpu, placed)),
        );
        let Ok(meshes) = meshes;
        let mut instances = Vec::new();
        let (mut vertex_count, mut near_count) = (0, 0);
        for Seen { standing, is_near } in seen(placed, view, earth_curvature) {
            let standing = &placed.standing[standing];
            let mesh = placed.mesh(standing);
            let [first_vertex, first_triangle] = meshes.firsts[standing.mesh];
            let (vertices, triangles) = (mesh.vertices_m.len() as u32, mesh.triangles.len() as u32);
            let middle_m = (standing.middle_m - origin_m).to_array();
            let row = |i: usize| standing.world_from_mesh.row(i).extend(middle_m[i]).as_vec4().to_array();
            instances.push(MeshInstance {
                east: row(0),
                north: row(1),
                up: row(2),
                first_vertex,
                vertices,
                vertices_before: vertex_count,
                first_triangle,
                triangles,
                near_before: near_count,
                is_near: u32::from(is_near),
                is_solid: u32::from(mesh.is_solid),
                first_place: standing.first_vertex,
                first_number: standing.first_triangle,
                padding_a: 0,
                padding_b: 0,
            });
            vertex_count += vertices;
            near_count += if is_near { triangles } else { 0 };
        }
        let bytes = instances.len().max(1) * size_of::<MeshInstance>();
        Self {
            instances: cx.upload(&INSTANCES, &instances).slice(0, bytes as u64),
            positions: cx.buffer(&POSITIONS, placed.vertices() * size_of::<[f32; 4]>() as u64),
            triangles: instances.iter().map(|instance| instance.triangles).collect(),
            near_triangles: near_count,
            vertices: vertex_count,
            meshes,
        }
    }

    /// Places the vertices of what is in view. Reads `terrain`; writes [`POSITIONS`].
    pub fn place(&self, cx: &mut Cx<'_>, terrain: Named) {
        if self.vertices == 0 && !cx.rehearses() {
            return;
        }
        let resources = [
            ("mesh_instances", self.instances.binding()),
            ("mesh_vertices", self.meshes.vertices.binding()),
            ("mesh_positions", self.positions.binding()),
            terrain,
        ];
        cx.groups("surface/mesh_vertices", groups(self.vertices), &resources);
    }

    /// What `shaders/shared/meshes.wgsl` declares, for the passes after this one.
    pub fn resources(&self) -> [Named; 3] {
        [
            ("mesh_instances", self.instances.binding()),
            ("mesh_triangles", self.meshes.triangles.binding()),
            ("mesh_places", self.positions.binding()),
        ]
    }
}

/// Workgroups for so many threads, in rows.
pub(crate) fn groups(threads: u32) -> [u32; 2] {
    let groups = threads.div_ceil(WORKGROUP).max(1);
    [groups.min(ROW), groups.div_ceil(ROW)]
}

fn packed(mesh: &Mesh) -> impl Iterator<Item = MeshTriangle> + '_ {
    mesh.triangles.iter().map(|triangle| {
        let [corner_a, corner_b, corner_c] = triangle.corners;
        let [across_ab, across_bc, across_ca] = triangle.across.map(|across| match across {
            Across::Border => u32::MAX,
            Across::Again => u32::MAX - 1,
            Across::Triangle { index, is_turned } => index << 1 | u32::from(is_turned),
        });
        let [normal_a, normal_b, normal_c] = triangle.normals.map(|normal| octahedral(normal.as_vec3()));
        MeshTriangle { corner_a, corner_b, corner_c, across_ab, across_bc, across_ca, normal_a, normal_b, normal_c }
    })
}

/// A unit vector in 2 × 16 bits: folded onto an octahedron (Cigolle and others 2014). Off by 5e-5 rad at most.
fn octahedral(normal: Vec3) -> u32 {
    let on = normal / normal.abs().element_sum();
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    let folded = if on.z >= 0.0 {
        on.truncate()
    } else {
        Vec2::new((1.0 - on.y.abs()) * sign(on.x), (1.0 - on.x.abs()) * sign(on.y))
    };
    let [low, high] = folded.to_array().map(|v| u32::from((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16));
    low | high << 16
}
