//! Meshes of known shape, and worlds that contain them.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use hachure::mesh::Mesh;
use hachure::mesh::build::Soup;
use hachure::mesh::placed::{Placed, Stance, Standing};

use crate::tests::common::World;
use crate::tests::common::hill::Hill;

/// Returns a sphere of radius 1: an icosahedron with each triangle split into four, `times` times.
pub fn sphere(times: u32) -> Soup {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut places_m: Vec<DVec3> = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        places_m.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    // The faces of the hull are the triples whose vertices are an edge's length (2) apart.
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let near = |a: usize, b: usize, places: &[DVec3]| (places[a].distance(places[b]) - 2.0).abs() < 1e-9;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b, &places_m) && near(b, c, &places_m) && near(a, c, &places_m) {
                    let [pa, pb, pc] = [a, b, c].map(|i| places_m[i]);
                    let is_out = (pb - pa).cross(pc - pa).dot(pa) > 0.0;
                    triangles.push(if is_out { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
                }
            }
        }
    }
    assert_eq!(triangles.len(), 20);
    for _ in 0..times {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut middle = |a: u32, b: u32| {
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    places_m.push((places_m[a as usize] + places_m[b as usize]) * 0.5);
                    places_m.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    places_m.iter_mut().for_each(|place| *place = place.normalize());
    Soup { places_m, triangles, normals: Vec::new() }
}

/// Returns a cube from -1 to 1.
pub fn cube() -> Soup {
    let places_m = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - 1.0);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Soup { places_m: places_m.collect(), triangles, normals: Vec::new() }
}

/// Returns a wavy open sheet of 12 × 12 quads over the square from -1 to 1.
pub fn sheet() -> Soup {
    let side = 13;
    let at = |i: i32| f64::from(i) / 6.0 - 1.0;
    let places = (0..side * side).map(|i| (at(i % side), at(i / side)));
    let places_m = places.map(|(x, y)| DVec3::new(x, y, 0.5 * (2.3 * x).sin() * (1.7 * y + 0.4).cos())).collect();
    let quad = |i: i32| [i, i + 1, i + side + 1, i + side].map(|corner| corner as u32);
    let triangles = (0..side * (side - 1))
        .filter(|i| i % side < side - 1)
        .flat_map(|i| {
            let [a, b, c, d] = quad(i);
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Soup { places_m, triangles, normals: Vec::new() }
}

/// Returns a torus: a tube of radius 1 around a horizontal circle of radius `major`.
pub fn torus(major: f64, around: u32, across: u32) -> Soup {
    let place = |i: u32, j: u32| {
        let turn = |i: u32, of: u32| std::f64::consts::TAU * f64::from(i) / f64::from(of);
        let (a, b) = (turn(i, around), turn(j, across));
        let out = major + b.cos();
        DVec3::new(out * a.cos(), out * a.sin(), b.sin())
    };
    let places_m = (0..around).flat_map(|i| (0..across).map(move |j| place(i, j))).collect();
    let vertex = |i: u32, j: u32| (i % around) * across + j % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let triangles = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Soup { places_m, triangles: triangles.collect(), normals: Vec::new() }
}

pub fn mesh(soup: Soup) -> Mesh {
    soup.into_mesh("shape.obj".to_owned()).unwrap()
}

/// Returns the analytic hill and its world.
pub fn hill() -> Option<(Hill, World)> {
    let (hill, grid) = Hill::square(321, 10.0);
    Some((hill, World::new(grid, 1.0)?))
}

pub fn stance(origin_m: DVec3, yaw_deg: f64, scale: f64) -> Stance {
    Stance { origin_m, yaw_deg, scale, z_up: true }
}

/// Places one mesh in a world, as its only mesh.
pub fn place(world: &mut World, mesh: &Arc<Mesh>, stance: &Stance) -> Standing {
    let mut placed = Placed::default();
    placed.add(mesh, stance).unwrap();
    let standing = placed.standing[0].clone();
    world.surfaces.set_meshes(placed);
    standing
}

/// Returns the corners of a triangle in the world, in f64.
pub fn corners_m(mesh: &Mesh, standing: &Standing, triangle: usize) -> [DVec3; 3] {
    let turn: DMat3 = standing.world_from_mesh;
    std::array::from_fn(|k| standing.middle_m + turn * mesh.corner_m(triangle, k))
}
