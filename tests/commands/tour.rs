//! The built-in camera path `tour` over the built-in world.

use std::path::Path;

use glam::DVec2;
use hachure::scene::path::CameraPath;
use hachure::source::{HeightGrid, Silent, WorldMapping, procedural};

use crate::checked_in;

/// Returns the height of the ground by bilinear interpolation, which is within metres of the surface itself.
fn ground_m(grid: &HeightGrid, mapping: &WorldMapping, east_m: f64, north_m: f64) -> f64 {
    let at = mapping.grid_from_world(DVec2::new(east_m, north_m));
    let (column, row) = (at.x.floor() as usize, at.y.floor() as usize);
    let sample = |dx: usize, dy: usize| f64::from(grid.heights_m[(row + dy) * grid.width as usize + column + dx]);
    let (fx, fy) = (at.x.fract(), at.y.fract());
    let between = |a: f64, b: f64, f: f64| a + (b - a) * f;
    between(between(sample(0, 0), sample(1, 0), fx), between(sample(0, 1), sample(1, 1), fx), fy)
}

#[test]
fn the_tour_stays_30_m_above_ground_and_inside() {
    let grid = procedural::generate(1, &Silent);
    let mapping = WorldMapping::new(&grid.georeference, grid.width, grid.height).unwrap();
    let ground = |x: f64, y: f64| ground_m(&grid, &mapping, x, y);
    let path = CameraPath::read_on_ground(Path::new(&checked_in("terrain/paths/tour.csv")), ground).unwrap();
    assert!((20.0..=30.0).contains(&path.duration_s()));
    let mut lowest_m = f64::INFINITY;
    let mut before: Option<glam::DVec3> = None;
    for camera in path.frames(60.0) {
        let at = camera.position_m;
        assert!(at.truncate().abs().max_element() < 11_000.0, "{camera}");
        lowest_m = lowest_m.min(at.z - ground(at.x, at.y));
        let speed_m_per_s = before.replace(at).map_or(0.0, |before| at.distance(before) * 60.0);
        assert!(speed_m_per_s < 1000.0, "{speed_m_per_s} m/s at {camera}");
    }
    assert!(lowest_m > 30.0, "the tour comes within {lowest_m} m of the ground");
    println!("never lower than {lowest_m:.0} m above ground");
}
