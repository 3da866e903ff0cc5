//! The surface is right: positions lie on decision 6's surface to within the allowed error in pixels, normals are its
//! derivative, there is no crack, and the channels agree with each other.

mod common;

use common::field::Field;
use common::shot::{Shot, shoot};
use common::{World, grid_of, quantile, rough_height_m};
use common::hill::Hill;
use rayon::prelude::*;

const SIZE_PX: [u32; 2] = [320, 180];

/// `x,y,z,yaw,pitch,fov` with x and y in parts of half the extent: from near to far, along and down.
const VIEWS: [(f64, f64, &str); 10] = [
    (0.10, -0.15, "+10,20,-3,60"),
    (0.10, -0.15, "+10,200,-60,40"),
    (-0.20, 0.30, "+2,100,0,20"),
    (0.30, 0.25, "+60,300,-8,90"),
    (-0.35, -0.30, "+300,45,-20,60"),
    (0.40, -0.45, "+1000,330,-15,35"),
    (-0.10, 0.05, "+3000,10,-90,60"),
    (0.00, -0.60, "9000,0,-25,45"),
    (0.05, 0.10, "30000,0,-88,40"),
    (-0.80, -0.90, "12000,42,-14,20"),
];

fn views(world: &World) -> Vec<String> {
    let half_m = world.terrain.extent_m().map(|extent| 0.5 * extent);
    VIEWS.iter().map(|(x, y, rest)| format!("{},{},{rest}", x * half_m[0], y * half_m[1])).collect()
}

/// Height errors in pixels of the pixels on the field, `raised_px` added to the heights: 0, or a planted error.
fn errors_px(world: &World, shot: &Shot, raised_px: f64) -> Vec<f64> {
    let field = Field { grid: &world.grid, mapping: &world.mapping };
    let focal_px = shot.focal_px();
    (0..shot.depth_m.len())
        .into_par_iter()
        .filter(|&pixel| !shot.is_sky(pixel))
        .filter_map(|pixel| {
            let place_m = shot.world_m(pixel);
            let px_per_m = focal_px / shot.position_m[pixel].length();
            let error_m = place_m.z + raised_px / px_per_m - field.height_m(place_m.truncate())?;
            Some(error_m.abs() * px_per_m)
        })
        .collect()
}

/// Whether (99.9 %, all) of the errors are within (1, 2) times the allowed error.
fn holds(p999_px: f64, max_px: f64, allowed_px: f64) -> bool {
    p999_px <= allowed_px && max_px <= 2.0 * allowed_px
}

fn heights_hold(name: &str, world: Option<World>, allowed_px: f64) {
    let Some(mut world) = world else { return };
    world.terrain.set_lod_error_px(allowed_px);
    let mut frame = None;
    let mut failures = Vec::new();
    let mut planted = 0;
    for (i, view) in views(&world).iter().enumerate() {
        let pose = world.pose(view);
        let shot = shoot(&mut world, &mut frame, pose, SIZE_PX);
        let mut errors = errors_px(&world, &shot, 0.0);
        let max_px = errors.iter().copied().fold(0.0, f64::max);
        let p999_px = quantile(&mut errors, 0.999);
        let (patches, count) = (shot.report.patches, errors.len());
        println!("{name}, view {i}, {allowed_px} px: p99.9 {p999_px:.4}, max {max_px:.4} ({count} pixels, {patches} patches)");
        if count > 0 && !holds(p999_px, max_px, allowed_px) {
            failures.push(format!("{view}: p99.9 {p999_px:.3} px, max {max_px:.3} px"));
        }
        if count > 1000 {
            let mut errors = errors_px(&world, &shot, 2.0 * allowed_px);
            let max_px = errors.iter().copied().fold(0.0, f64::max);
            assert!(!holds(quantile(&mut errors, 0.999), max_px, allowed_px), "heights that are off by 2 px must fail");
            planted += 1;
        }
    }
    assert!(planted >= 5, "only {planted} views show the terrain");
    assert!(failures.is_empty(), "{name}, {allowed_px} px allowed:\n{}", failures.join("\n"));
}

fn hill() -> Option<World> {
    World::new(Hill::square(321, 10.0).1, 1.0)
}

fn rough() -> Option<World> {
    World::new(grid_of(701, 645, 20.0, rough_height_m), 1.0)
}

#[test]
fn heights_of_a_smooth_hill() {
    heights_hold("hill", hill(), 1.0);
    heights_hold("hill", hill(), 0.25);
}

#[test]
fn heights_of_rough_land() {
    heights_hold("rough", rough(), 1.0);
    heights_hold("rough", rough(), 0.25);
}

#[test]
fn heights_of_mount_rainier() {
    let world = || World::real("dem/geotiff/mt_rainier_90m.tif", 1.0);
    heights_hold("Rainier", world(), 1.0);
    heights_hold("Rainier", world(), 0.25);
}

#[test]
fn heights_of_the_alps() {
    let world = || World::real("dem/geotiff/N46E008_alps.tif", 1.0);
    heights_hold("Alps", world(), 1.0);
    heights_hold("Alps", world(), 0.25);
}

#[test]
fn heights_of_a_projected_grid() {
    let world = || World::real("dem/encodings_rainier/utm10n_90m_nodata-9999_f32.tif", 1.0);
    heights_hold("UTM", world(), 1.0);
    heights_hold("UTM", world(), 0.25);
}
