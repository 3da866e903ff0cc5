//! Meshes and where they stand, as the GPU has them.

use glam::{DVec3, Vec2, Vec3};

pub(crate) use crate::gpu::wgsl::shared::meshes::MeshInstance;
pub(crate) use crate::gpu::wgsl::shared::meshes::MeshTriangle;
pub(crate) use crate::gpu::wgsl::surface::meshes::cull::Standing;
use crate::mesh::placed::Placed;
use crate::mesh::{Across, Mesh};

/// All that stands in a world, for the GPU.
pub(super) fn standings(placed: &Placed) -> Vec<Standing> {
    let mut firsts = Vec::with_capacity(placed.meshes.len());
    let (mut first_vertex, mut first_triangle) = (0, 0);
    for mesh in &placed.meshes {
        firsts.push([first_vertex, first_triangle]);
        first_vertex += mesh.vertices_m.len() as u32;
        first_triangle += mesh.triangles.len() as u32;
    }
    let of = |standing: &crate::mesh::placed::Standing| {
        let mesh = placed.mesh(standing);
        let [first_vertex, first_triangle] = firsts[standing.mesh];
        let [coarse, fine] = fixed_point(standing.middle_m);
        let row = |i: usize| standing.world_from_mesh.row(i).as_vec3().to_array();
        Standing {
            east: row(0),
            first_vertex,
            north: row(1),
            vertices: mesh.vertices_m.len() as u32,
            up: row(2),
            first_triangle,
            coarse,
            triangles: mesh.triangles.len() as u32,
            fine,
            is_solid: u32::from(mesh.is_solid),
            first_place: standing.first_vertex,
            first_number: standing.first_triangle,
            radius_m: (mesh.radius_m * standing.scale) as f32,
            mean_edge_m: (mesh.mean_edge_m * standing.scale) as f32,
        }
    };
    placed.standing.iter().map(of).collect()
}

/// A place in the world with more digits than f32 has: in units of 64 m, and the rest in units of 2⁻²⁴ m.
pub(super) fn fixed_point(place_m: DVec3) -> [[i32; 3]; 2] {
    let coarse = (place_m / 64.0).round();
    let fine = ((place_m - coarse * 64.0) * f64::from(1 << 24)).round();
    [coarse.as_ivec3().to_array(), fine.as_ivec3().to_array()]
}

/// The triangles of a mesh for the GPU.
pub(super) fn packed(mesh: &Mesh) -> impl Iterator<Item = MeshTriangle> + '_ {
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
