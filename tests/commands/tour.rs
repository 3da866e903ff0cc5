//! The built-in camera path `tour` over the built-in world.

use std::path::{Path, PathBuf};

use glam::DVec2;
use hachure::scene::path::CameraPath;
use hachure::source::{self, HeightGrid, Silent, WorldMapping, procedural};

use crate::{Place, checked_in};

/// Returns the height of the ground by bilinear interpolation, which is within metres of the surface itself.
fn ground_m(grid: &HeightGrid, mapping: &WorldMapping, east_m: f64, north_m: f64) -> f64 {
    let at = mapping.grid_from_world(DVec2::new(east_m, north_m));
    let (column, row) = (at.x.floor() as usize, at.y.floor() as usize);
    let sample = |dx: usize, dy: usize| f64::from(grid.heights_m[(row + dy) * grid.width as usize + column + dx]);
    let (fx, fy) = (at.x.fract(), at.y.fract());
    let between = |a: f64, b: f64, f: f64| a + (b - a) * f;
    between(between(sample(0, 0), sample(1, 0), fx), between(sample(0, 1), sample(1, 1), fx), fy)
}

/// Returns the heights of the built-in world: as the cache has them, or generated where nothing can be drawn.
fn built_in_land() -> HeightGrid {
    let place = Place::with_built_in_land();
    place.hachure(&["render", "--size", "16x9", "--style", "plain", "-o", "a.png"]);
    let folders = std::fs::read_dir(&place.cache).into_iter().flatten().flatten();
    let files = folders.filter_map(|folder| std::fs::read_dir(folder.path()).ok()).flatten().flatten();
    let is_land = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with("procedural-1.") && name.ends_with(".tif")
    };
    match files.map(|file| file.path()).find(is_land) {
        Some(path) => source::read_all(&*source::open_reader(&path).unwrap(), &path, &Silent).unwrap(),
        None => procedural::generate(1, &Silent),
    }
}

#[test]
fn the_tour_stays_30_m_above_ground_and_inside() {
    let grid = built_in_land();
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
