//! Tests that the edges that the GPU finds equal those of brute force on the triangles as drawn.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DMat3, DVec3};
use hachure::frame::Renderer;
use hachure::mesh::build::Soup;
use hachure::mesh::{Across, Mesh};
use hachure::style::Style;
use hachure::surface::SURFACE_ID;
use hachure::surface::edges::Edge;
use hachure::surface::edges::{EDGE_DRAW, EDGES};

use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::{World, full};
use crate::tests::helpers::stroke_lines::strokes_left;
use crate::tests::helpers::styles::of_outlines;
use crate::tests::meshes::shapes;

const SIZE_PX: [u32; 2] = [640, 360];
const CREASE_DEG: f32 = 30.0;

type Bits = [u32; 3];
/// Edges as their two ends, the lesser first, and their kind.
type Found = HashSet<([Bits; 2], u32)>;

fn bits(at_m: [f32; 3]) -> Bits {
    // Negative zero becomes positive zero.
    at_m.map(|v| (v + 0.0).to_bits())
}

fn ends(a: Bits, b: Bits) -> [Bits; 2] {
    if a < b { [a, b] } else { [b, a] }
}

struct Bench {
    world: World,
    renderer: Renderer,
    style: Style,
}

impl Bench {
    fn new() -> Option<Self> {
        let (_, mut world) = shapes::hill()?;
        let mut style = of_outlines(Style::load("strokes").unwrap());
        let strokes = style.strokes_mut().unwrap();
        strokes.crease_deg = Some(CREASE_DEG);
        // Strokes, and so edges, are updated in every frame.
        strokes.update_every = 1;
        // A renderer is created for scenes with meshes.
        shapes::place(&mut world, &Arc::new(shapes::mesh(shapes::cube())), &shapes::stance(DVec3::ZERO, 0.0, 1.0));
        let renderer = Renderer::new(&world.gpu).unwrap();
        Some(Self { world, renderer, style })
    }

    /// Returns the edges of a mesh in the sky, so high that nothing else is in view, and its vertices as drawn.
    fn find(&mut self, mesh: &Mesh, yaw_deg: f64, away_m: f64) -> (Vec<Edge>, Vec<[f32; 3]>) {
        let pose = self.world.pose(&format!("100,200,3000,{yaw_deg},40,40"));
        let middle_m = pose.position_m + pose.forward * away_m;
        let mesh = Arc::new(mesh.clone());
        shapes::place(&mut self.world, &mesh, &shapes::stance(middle_m, 13.0, 1.0));
        let view = still(pose, SIZE_PX);
        let gpu = &self.world.gpu;
        draw(gpu, &mut self.world.surfaces, &mut self.renderer, &view, &self.style, &NOON);
        let vertices: u32 = strokes_left(gpu, &self.renderer, &EDGE_DRAW, 1)[0];
        let edges = strokes_left(gpu, &self.renderer, &EDGES, vertices as usize / 2);
        let drawn = self.renderer.drawn_mesh_vertices(gpu, &self.world.surfaces).unwrap().unwrap();
        (edges, drawn.into_iter().map(|[x, y, z, _]| [x, y, z]).collect())
    }
}

/// Finds edges by brute force. Returns them, and the edges that rounding decides.
fn brute(mesh: &Mesh, drawn: &[[f32; 3]]) -> (Found, HashSet<[Bits; 2]>) {
    struct Side {
        normal: DVec3,
        faces: bool,
        is_sure: bool,
        /// Whether the triangle's edge runs from the lesser end to the greater.
        is_forward: bool,
    }
    let mut edges: HashMap<[Bits; 2], Vec<Side>> = HashMap::new();
    for triangle in &mesh.triangles {
        let corners = triangle.corners.map(|corner| drawn[corner as usize]);
        let [a, b, c] = corners.map(|corner| DVec3::from_array(corner.map(f64::from)));
        let normal = (b - a).cross(c - a).normalize();
        let toward = -normal.dot(a) / a.length();
        let [a, b, c] = corners.map(bits);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let is_forward = from < to;
            edges.entry(ends(from, to)).or_default().push(Side {
                normal,
                faces: toward > 0.0,
                is_sure: toward.abs() > 2e-5,
                is_forward,
            });
        }
    }
    let (mut found, mut unsure) = (Found::new(), HashSet::new());
    let min_cosine = f64::from(CREASE_DEG).to_radians().cos();
    for (ends, sides) in edges {
        let [one, other] = sides.as_slice() else {
            found.insert((ends, 1));
            continue;
        };
        let turned = if one.is_forward == other.is_forward { -1.0 } else { 1.0 };
        let cosine = turned * one.normal.dot(other.normal);
        if !one.is_sure || !other.is_sure || (cosine - min_cosine).abs() < 1e-5 {
            unsure.insert(ends);
        }
        if (one.faces == other.faces) == (turned < 0.0) {
            found.insert((ends, 0));
        } else if cosine < min_cosine && (one.faces || !mesh.is_solid) {
            found.insert((ends, 2));
        }
    }
    (found, unsure)
}

fn of_gpu(edges: &[Edge]) -> Found {
    let found: Found = edges.iter().map(|edge| (ends(bits(edge.a_m), bits(edge.b_m)), edge.kind)).collect();
    assert_eq!(found.len(), edges.len(), "the list must not contain an edge twice");
    found
}

/// Counts edges that only one of both has and that rounding does not explain. Also returns how many edges of each kind
/// brute force has.
fn differences(gpu: &Found, (brute, unsure): &(Found, HashSet<[Bits; 2]>)) -> (usize, [usize; 3]) {
    let counts = [0, 1, 2].map(|kind| brute.iter().filter(|edge| edge.1 == kind).count());
    (gpu.symmetric_difference(brute).filter(|edge| !unsure.contains(&edge.0)).count(), counts)
}

/// Returns the mesh rotated, so that no axis is special.
fn turned(soup: Soup, by: f64) -> Mesh {
    let turn = DMat3::from_euler(glam::EulerRot::ZYX, by, 1.3 * by + 0.2, 0.7 * by + 0.4);
    shapes::mesh(Soup { places_m: soup.places_m.into_iter().map(|place| turn * place).collect(), ..soup })
}

#[test]
fn the_gpu_finds_what_brute_force_finds() {
    let Some(mut bench) = Bench::new() else { return };
    for (name, soup) in [("sphere", shapes::sphere(4)), ("cube", shapes::cube()), ("sheet", shapes::sheet())] {
        let (mut all, mut unsure) = ([0; 3], 0);
        // In the fast tier the sphere, whose many edges rounding may decide, is seen by every second eye.
        let is_drawn = |(eye, _): &(usize, f64)| full() || *eye == 0 || name == "sphere" && *eye % 2 == 0;
        for (eye, away_m) in [4.0, 5.0, 7.5, 12.0, 40.0].into_iter().enumerate().filter(is_drawn) {
            let mesh = turned(soup.clone(), 0.9 * eye as f64);
            let (edges, drawn) = bench.find(&mesh, 70.0 * eye as f64, away_m);
            let gpu = of_gpu(&edges);
            let brute = brute(&mesh, &drawn);
            let (differ, counts) = differences(&gpu, &brute);
            assert_eq!(differ, 0, "{name} from {away_m} m: {counts:?} edges");
            unsure += brute.1.len();
            (0..3).for_each(|kind| all[kind] += counts[kind]);
            if mesh.is_solid {
                // Contours are closed, even where rounding decides.
                let mut degrees: HashMap<Bits, u32> = HashMap::new();
                for (ends, _) in gpu.iter().filter(|edge| edge.1 == 0) {
                    ends.iter().for_each(|end| *degrees.entry(*end).or_default() += 1);
                }
                assert!(!degrees.is_empty() && degrees.values().all(|degree| degree % 2 == 0), "{name}");
            }
        }
        println!("{name}: {all:?} contours, borders, creases; rounding decides {unsure}");
        assert!(unsure * 100 <= all.iter().sum(), "{unsure}");
        assert_eq!([all[1] > 0, all[2] > 0], [name == "sheet", name == "cube"]);
    }
}

#[test]
fn a_triangle_that_winds_the_other_way_makes_no_difference() {
    let Some(mut bench) = Bench::new() else { return };
    let mut soup = shapes::sphere(3);
    for i in [7, 8, 100, 333, 700] {
        soup.triangles[i].swap(0, 1);
    }
    let contours =
        |found: Found| -> HashSet<[Bits; 2]> { found.into_iter().filter(|e| e.1 == 0).map(|e| e.0).collect() };
    let one = contours(of_gpu(&bench.find(&shapes::mesh(soup), 0.0, 5.0).0));
    let other = contours(of_gpu(&bench.find(&shapes::mesh(shapes::sphere(3)), 0.0, 5.0).0));
    assert!(one == other && !one.is_empty());
}

#[test]
fn an_eye_in_the_plane_of_a_face_sees_closed_contours() {
    let Some(mut bench) = Bench::new() else { return };
    // A prism with 64 sides whose caps are seen exactly edge-on, and which has sliver triangles.
    for yaw_deg in [0.0, 30.0, 117.0] {
        let forward = bench.world.pose(&format!("0,0,3000,{yaw_deg},40,40")).forward;
        let across = forward.cross(DVec3::Z).normalize();
        let up = across.cross(forward);
        let ring = |i: usize| {
            let (sin, cos) = (i as f64 * std::f64::consts::TAU / 64.0).sin_cos();
            forward * cos + across * sin
        };
        let mut places_m: Vec<DVec3> = (0..64).map(ring).collect();
        places_m.extend((0..64).map(|i| ring(i) - up));
        let mut triangles = Vec::new();
        for i in 1..63 {
            triangles.extend([[0, i, i + 1], [64, 65 + i, 64 + i]]);
        }
        for i in 0..64 {
            let next = (i + 1) % 64;
            triangles.extend([[i, i + 64, next + 64], [i, next + 64, next]]);
        }
        let mesh = shapes::mesh(Soup { places_m, triangles, normals: Vec::new() });
        assert!(mesh.is_solid);
        for away_m in [6.0, 100.0] {
            let gpu = of_gpu(&bench.find(&mesh, yaw_deg, away_m).0);
            let mut degrees: HashMap<Bits, u32> = HashMap::new();
            for (ends, _) in gpu.iter().filter(|edge| edge.1 == 0) {
                ends.iter().for_each(|end| *degrees.entry(*end).or_default() += 1);
            }
            assert!(!degrees.is_empty() && degrees.values().all(|degree| degree % 2 == 0), "{yaw_deg} {away_m}");
        }
    }
}

#[test]
fn planted_errors_are_found() {
    let Some(mut bench) = Bench::new() else { return };
    let mesh = turned(shapes::sphere(3), 0.5);
    let (edges, drawn) = bench.find(&mesh, 0.0, 5.0);
    let truth = brute(&mesh, &drawn);
    assert_eq!(differences(&of_gpu(&edges), &truth).0, 0);
    // Planted: a triangle at the contour is flipped without updating its neighbours.
    let at_contour = (0..mesh.triangles.len())
        .find(|&i| {
            let [a, b, _] = mesh.triangles[i].corners.map(|corner| bits(drawn[corner as usize]));
            truth.0.contains(&(ends(a, b), 0)) && !truth.1.contains(&ends(a, b))
        })
        .unwrap();
    let mut wound = mesh.clone();
    wound.triangles[at_contour].corners.swap(0, 1);
    assert!(differences(&of_gpu(&bench.find(&wound, 0.0, 5.0).0), &truth).0 > 0);
    // Planted: one wrong neighbour, then one missing.
    for across in
        [Across::Triangle { index: u32::try_from(mesh.triangles.len() / 2).unwrap(), is_turned: true }, Across::Again]
    {
        let mut spoiled = mesh.clone();
        for triangle in &mut spoiled.triangles {
            if triangle.across[0] == (Across::Triangle { index: at_contour as u32, is_turned: false }) {
                triangle.across[0] = across;
            }
        }
        spoiled.triangles[at_contour].across[0] = across;
        let found: Found =
            bench.find(&spoiled, 0.0, 5.0).0.iter().map(|e| (ends(bits(e.a_m), bits(e.b_m)), e.kind)).collect();
        assert!(differences(&found, &truth).0 > 0, "{across:?}");
    }
    // Planted: a vertex at another position.
    let mut moved = drawn;
    moved[mesh.triangles[at_contour].corners[0] as usize][1] += 0.05;
    assert!(differences(&of_gpu(&edges), &brute(&mesh, &moved)).0 > 0);
}

#[test]
fn what_is_far_has_no_edges_and_then_is_not_drawn() {
    let Some(mut bench) = Bench::new() else { return };
    let mesh = turned(shapes::sphere(3), 0.5);
    let focal_px = 180.0 / 20.0_f64.to_radians().tan();
    let last_m = mesh.mean_edge_m * focal_px / 0.5 + mesh.radius_m;
    assert!(!bench.find(&mesh, 0.0, 0.98 * last_m).0.is_empty());
    assert!(bench.find(&mesh, 0.0, 1.02 * last_m).0.is_empty());
    let gone_m = 2.0 * mesh.radius_m * focal_px;
    let pixels = |bench: &mut Bench, away_m: f64| {
        bench.find(&mesh, 0.0, away_m);
        let gpu = &bench.world.gpu;
        let ids: Vec<u32> =
            hachure::gpu::readback::read_as(gpu, bench.renderer.target(&SURFACE_ID).unwrap(), [0, 0], SIZE_PX).unwrap();
        ids.into_iter().filter(|id| id >> 31 == 1).count()
    };
    assert!(pixels(&mut bench, 0.5 * gone_m) > 0);
    assert_eq!(pixels(&mut bench, 1.02 * gone_m), 0);
}
