#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::collections::HashMap;

use glam::DVec2;

use super::triangulation::triangulate_within;
use super::*;

const SIZE: [usize; 2] = [161, 121];
const STEP_M: f64 = 5.0;

fn hills(at: DVec2) -> f64 {
    500.0 + 80.0 * (at.x / 90.0).sin() * (at.y / 70.0).cos() + 0.1 * at.x
}

/// Returns the largest distance between the mesh and a function along the vertical, over all points of the lattice that
/// a triangle covers, and the number of points.
fn measured(mesh: &LandMesh, moved_m: f64) -> (f64, usize) {
    let (mut error_m, mut points) = (0.0_f64, 0);
    let half = 0.5 * STEP_M * DVec2::new(SIZE[0] as f64 - 1.0, SIZE[1] as f64 - 1.0);
    for [a, b, c] in mesh.triangles.iter().map(|corners| corners.map(|i| mesh.positions[i as usize])) {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let normal = (b - a).cross(c - a);
        assert!(normal.z > 0.0, "triangles are anticlockwise from above");
        let first = ((low.truncate() + half) / STEP_M).round();
        let last = ((high.truncate() + half) / STEP_M).round();
        for y in first.y as i64..=last.y as i64 {
            for x in first.x as i64..=last.x as i64 {
                let at = STEP_M * DVec2::new(x as f64, y as f64) - half;
                let inside = |p: DVec3, q: DVec3| (q - p).truncate().perp_dot(at - p.truncate()) >= -1e-6;
                if inside(a, b) && inside(b, c) && inside(c, a) {
                    let way = at - a.truncate();
                    let height_m = a.z - (normal.x * way.x + normal.y * way.y) / normal.z;
                    error_m = error_m.max((height_m + moved_m - hills(at + half)).abs());
                    points += 1;
                }
            }
        }
    }
    (error_m, points)
}

#[test]
fn triangles_are_within_the_error_and_few() {
    let lattice = Lattice::of(SIZE, STEP_M, |at| Some(hills(at)));
    let counts = [0.5, 5.0].map(|max_m| {
        let mesh = LandMesh::new(&lattice, max_m).unwrap();
        let (error_m, points) = measured(&mesh, 0.0);
        assert!(points >= SIZE[0] * SIZE[1] && error_m <= max_m + 1e-3, "{error_m} m at {points} points");
        assert!((error_m - mesh.error_m).abs() < 1e-3 && error_m > 0.2 * max_m, "{error_m} m, not {}", mesh.error_m);
        assert!(measured(&mesh, max_m).0 > 1.1 * max_m, "planted error, raised land");
        mesh.triangles.len()
    });
    let all = 2 * (SIZE[0] - 1) * (SIZE[1] - 1);
    assert!(counts[0] * 4 < all && counts[1] * 4 < counts[0], "{counts:?} of {all}");
    assert!(triangulate_within(&lattice, 0.5, 100).is_err());
    // A plane needs two triangles.
    let plane = Lattice::of(SIZE, STEP_M, |at| Some(0.25 * at.x + 0.5 * at.y));
    assert_eq!(LandMesh::new(&plane, 0.01).unwrap().triangles.len(), 2);
}

/// Returns the edges that do not have exactly one edge in the other direction.
fn open_edges(triangles: &[[u32; 3]]) -> usize {
    let mut counts: HashMap<[u32; 2], i32> = HashMap::new();
    for [a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *counts.entry([*from.min(to), *from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    counts.values().filter(|count| **count != 0).count()
}

#[test]
fn a_solid_is_closed_around_holes_and_borders() {
    let hole = |at: DVec2| at.distance(DVec2::new(400.0, 300.0)) < 101.0 || at.x < 60.0;
    let lattice = Lattice::of(SIZE, STEP_M, |at| (!hole(at)).then(|| hills(at)));
    let mesh = LandMesh::new(&lattice, 2.0).unwrap();
    let (positions, mut triangles) = mesh.solid(-10.0);
    assert_eq!(open_edges(&triangles), 0);
    // The volume by the divergence theorem is that of the columns below the land.
    let volume = |triangles: &[[u32; 3]]| {
        let part = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|i| positions[i as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        triangles.iter().map(part).sum::<f64>()
    };
    let cells = (0..(SIZE[0] - 1) * (SIZE[1] - 1)).map(|i| [i % (SIZE[0] - 1), i / (SIZE[0] - 1)]);
    let corners = |[x, y]: [usize; 2]| [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
    let column = |cell: [usize; 2]| {
        let places = corners(cell).map(|[x, y]| STEP_M * DVec2::new(x as f64, y as f64));
        let has_land = places.iter().all(|at| !hole(*at));
        if has_land { places.map(hills).iter().map(|height| (height + 10.0) / 4.0).sum::<f64>() } else { 0.0 }
    };
    let expected = cells.map(column).sum::<f64>() * STEP_M * STEP_M;
    let found = volume(&triangles);
    assert!((found / expected - 1.0).abs() < 0.02, "{found} m³ instead of {expected} m³");
    triangles.pop();
    assert!(open_edges(&triangles) > 0, "planted error, a triangle is missing");
    // No triangle is in the hole.
    let half = 0.5 * STEP_M * DVec2::new(SIZE[0] as f64 - 1.0, SIZE[1] as f64 - 1.0);
    let middle = |corners: &[u32; 3]| corners.map(|i| mesh.positions[i as usize]).iter().sum::<DVec3>() / 3.0;
    assert!(mesh.triangles.iter().all(|corners| !hole(middle(corners).truncate() + half)));
}
