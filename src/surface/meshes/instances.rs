//! Meshes and their instances in the form that the GPU reads.

use glam::{DVec3, Vec2, Vec3};

pub(crate) use crate::gpu::wgsl::shared::meshes::MeshInstance;
pub(crate) use crate::gpu::wgsl::shared::meshes::MeshTriangle;
pub(crate) use crate::gpu::wgsl::surface::meshes::cull::MeshLevel;
pub(crate) use crate::gpu::wgsl::surface::meshes::cull::Standing;
use crate::mesh::placed::Placed;
use crate::mesh::{Across, Material, Mesh};

/// A mesh, or a coarser level of it.
pub(super) struct LevelMesh<'a> {
    pub mesh: &'a Mesh,
    /// Offset from the middle of the full-resolution mesh to the middle of this level.
    aside_m: DVec3,
    /// Error of the level, in the mesh's unit.
    error_m: f64,
}

impl LevelMesh<'_> {
    /// Returns the vertices, relative to the middle of the full-resolution mesh.
    pub(super) fn vertices(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        let moved = |at_m: &[f32; 3]| (self.aside_m + DVec3::from_array(at_m.map(f64::from))).as_vec3();
        let vertex = move |at_m: &[f32; 3]| {
            // Bit-identical if there is no offset.
            if self.aside_m == DVec3::ZERO { Vec3::from_array(*at_m) } else { moved(at_m) }.extend(1.0).to_array()
        };
        self.mesh.vertices_m.iter().map(vertex)
    }
}

/// Returns all levels of a mesh, finest first.
pub(super) fn levels_of(placed: &Placed, mesh: usize) -> impl Iterator<Item = LevelMesh<'_>> {
    let whole = &*placed.meshes[mesh];
    let coarser = placed.coarser(mesh).iter().map(|level| LevelMesh {
        mesh: &level.mesh,
        aside_m: level.mesh.middle_m - whole.middle_m,
        error_m: level.error_m,
    });
    [LevelMesh { mesh: whole, aside_m: DVec3::ZERO, error_m: 0.0 }].into_iter().chain(coarser)
}

/// Returns all levels of all meshes, and the index of the first level of each mesh, followed by the number of levels.
pub(super) fn levels(placed: &Placed) -> (Vec<MeshLevel>, Vec<u32>) {
    let (mut levels, mut firsts) = (Vec::new(), vec![0]);
    let (mut first_vertex, mut first_triangle) = (0, 0);
    for mesh in 0..placed.meshes.len() {
        let mut first_number = 0;
        for LevelMesh { mesh, error_m, .. } in levels_of(placed, mesh) {
            let (vertices, triangles) = (mesh.vertices_m.len() as u32, mesh.triangles.len() as u32);
            levels.push(MeshLevel {
                first_vertex,
                vertices,
                first_triangle,
                triangles,
                first_number,
                is_solid: u32::from(mesh.is_solid),
                mean_edge_m: mesh.mean_edge_m as f32,
                error_m: error_m as f32,
            });
            first_vertex += vertices;
            first_triangle += triangles;
            first_number += triangles;
        }
        firsts.push(levels.len() as u32);
    }
    (levels, firsts)
}

/// Returns all mesh instances of a world.
pub(super) fn standings(placed: &Placed, levels: &[MeshLevel], firsts: &[u32]) -> Vec<Standing> {
    let mut first_number = 0;
    let of = |standing: &crate::mesh::placed::Standing| {
        let mesh = placed.mesh(standing);
        let [first_level, end] = [firsts[standing.mesh], firsts[standing.mesh + 1]];
        let [coarse, fine] = fixed_point(standing.middle_m);
        let row = |i: usize| standing.world_from_mesh.row(i).as_vec3().to_array();
        let own = Standing {
            east: row(0),
            first_level,
            north: row(1),
            levels: end - first_level,
            up: row(2),
            first_number,
            coarse,
            scale: standing.scale as f32,
            fine,
            radius_m: (mesh.radius_m * standing.scale) as f32,
        };
        first_number += levels[first_level as usize..end as usize].iter().map(|level| level.triangles).sum::<u32>();
        own
    };
    placed.standing.iter().map(of).collect()
}

/// Splits a position in the world, for which f32 has too few digits, into units of 64 m and a rest in units of 2⁻²⁴ m.
pub(super) fn fixed_point(place_m: DVec3) -> [[i32; 3]; 2] {
    let coarse = (place_m / 64.0).round();
    let fine = ((place_m - coarse * 64.0) * f64::from(1 << 24)).round();
    [coarse.as_ivec3().to_array(), fine.as_ivec3().to_array()]
}

/// Returns the triangles of a mesh.
pub(super) fn packed(mesh: &Mesh) -> impl Iterator<Item = MeshTriangle> + '_ {
    let lightness: Vec<f32> = mesh.materials.iter().map(Material::lightness).collect();
    mesh.triangles.iter().map(move |triangle| {
        let lightness = lightness[usize::from(triangle.material)];
        let [corner_a, corner_b, corner_c] = triangle.corners;
        let [across_ab, across_bc, across_ca] = triangle.across.map(|across| match across {
            Across::Border => u32::MAX,
            Across::Again => u32::MAX - 1,
            Across::Triangle { index, is_turned } => index << 1 | u32::from(is_turned),
        });
        let [normal_a, normal_b, normal_c] = triangle.normals.map(|normal| octahedral(normal.as_vec3()));
        MeshTriangle {
            corner_a,
            corner_b,
            corner_c,
            across_ab,
            across_bc,
            across_ca,
            normal_a,
            normal_b,
            normal_c,
            lightness,
        }
    })
}

/// Packs a unit vector into 2 × 16 bits by the octahedral map (Cigolle and others 2014). The error is at most 5e-5 rad.
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
