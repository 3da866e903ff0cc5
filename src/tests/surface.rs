//! Tests the surface: positions are on the surface of decision 6 to within the allowed error in pixels, normals are its
//! derivative, there are no cracks, and the channels agree with each other.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::field::Field;
use common::hill::Hill;
use common::shot::{Shot, shoot};
use common::{World, full, grid_of, quantile, rough_height_m};
use glam::DVec2;
use rayon::prelude::*;

fn size_px() -> [u32; 2] {
    if full() { [320, 180] } else { [160, 90] }
}

/// Cameras `x,y,z,yaw,pitch,fov` with x and y as parts of half the extent: from near to far, along the land and down.
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

/// Returns the views of a world; in the fast tier every second one.
fn views(world: &World) -> Vec<String> {
    let (right, bottom) = (f64::from(world.grid.width - 1), f64::from(world.grid.height - 1));
    let corners_m = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)]
        .map(|(column, row)| world.mapping.world_from_grid(column, row));
    let low_m = corners_m.into_iter().reduce(DVec2::min).unwrap();
    let half_m = 0.5 * (corners_m.into_iter().reduce(DVec2::max).unwrap() - low_m);
    let some = VIEWS.iter().step_by(if full() { 1 } else { 2 });
    some.map(|(x, y, rest)| format!("{},{},{rest}", x * half_m[0], y * half_m[1])).collect()
}

/// Returns the height errors of the pixels on the field, in pixels. `raised_px` is added to the heights: 0, or a
/// planted error.
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

/// Returns whether 99.9 % of the errors are within the allowed error, and all within twice that.
fn holds(p999_px: f64, max_px: f64, allowed_px: f64) -> bool {
    p999_px <= allowed_px && max_px <= 2.0 * allowed_px
}

fn heights_hold(name: &str, world: Option<World>, allowed_px: f64) {
    let Some(mut world) = world else { return };
    world.surfaces.terrain.set_lod_error_px(allowed_px);
    let mut renderer = None;
    let mut failures = Vec::new();
    let mut planted = 0;
    for (i, view) in views(&world).iter().enumerate() {
        let pose = world.pose(view);
        let shot = shoot(&mut world, &mut renderer, pose, size_px());
        let mut errors = errors_px(&world, &shot, 0.0);
        let max_px = errors.iter().copied().fold(0.0, f64::max);
        let p999_px = quantile(&mut errors, 0.999);
        let (patches, count) = (shot.report.patches, errors.len());
        println!(
            "{name}, view {i}, {allowed_px} px: p99.9 {p999_px:.4}, max {max_px:.4} ({count} pixels, {patches} patches)"
        );
        if count > 0 && !holds(p999_px, max_px, allowed_px) {
            failures.push(format!("{view}: p99.9 {p999_px:.3} px, max {max_px:.3} px"));
        }
        if count > shot.depth_m.len() * 10 / 576 {
            let mut errors = errors_px(&world, &shot, 2.0 * allowed_px);
            let max_px = errors.iter().copied().fold(0.0, f64::max);
            assert!(!holds(quantile(&mut errors, 0.999), max_px, allowed_px), "planted heights were not detected");
            planted += 1;
        }
    }
    assert!(planted >= if full() { 5 } else { 3 }, "only {planted} views show the terrain");
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
    if full() {
        heights_hold("rough", rough(), 0.25);
    }
}

#[test]
fn heights_of_mount_rainier() {
    let world = || World::real("dem/geotiff/mt_rainier_90m.tif", 1.0);
    heights_hold("Rainier", world(), 1.0);
    if full() {
        heights_hold("Rainier", world(), 0.25);
    }
}

#[test]
fn heights_of_the_alps() {
    let world = || World::real("dem/geotiff/N46E008_alps.tif", 1.0);
    heights_hold("Alps", world(), 1.0);
    if full() {
        heights_hold("Alps", world(), 0.25);
    }
}

#[test]
fn heights_of_a_projected_grid() {
    let world = || World::real("dem/encodings_rainier/utm10n_90m_nodata-9999_f32.tif", 1.0);
    heights_hold("UTM", world(), 1.0);
    if full() {
        heights_hold("UTM", world(), 0.25);
    }
}

/// Returns lengths of the difference to the field's normal, at pixels that are finer than the samples, where level 0 is
/// drawn.
fn normal_errors(world: &World, shot: &Shot, turned: f64) -> Vec<f64> {
    let field = Field { grid: &world.grid, mapping: &world.mapping };
    let (focal_px, spacing_m) = (shot.focal_px(), world.surfaces.terrain.grid_projection().spacing_m());
    (0..shot.depth_m.len())
        .into_par_iter()
        .filter(|&pixel| !shot.is_sky(pixel) && shot.position_m[pixel].length() / focal_px < 0.9 * spacing_m)
        .filter_map(|pixel| {
            let normal = field.normal(shot.world_m(pixel).truncate(), spacing_m)?;
            let drawn = glam::DQuat::from_rotation_x(turned) * shot.normal[pixel];
            Some((drawn - normal).length())
        })
        .collect()
}

fn normals_hold(name: &str, world: Option<World>) {
    let Some(mut world) = world else { return };
    let mut renderer = None;
    let mut measured = 0;
    for (i, view) in views(&world).iter().enumerate().take(if full() { 6 } else { 3 }) {
        let pose = world.pose(view);
        let shot = shoot(&mut world, &mut renderer, pose, size_px());
        let mut errors = normal_errors(&world, &shot, 0.0);
        if errors.len() < shot.depth_m.len() * 10 / 576 {
            continue;
        }
        measured += 1;
        let max = errors.iter().copied().fold(0.0, f64::max);
        let p999 = quantile(&mut errors, 0.999);
        println!("{name}, view {i}: normals p99.9 {p999:.6}, max {max:.6} ({} pixels)", errors.len());
        assert!(p999 <= 1e-3 && max <= 0.05, "{name}, {view}");
        let mut errors = normal_errors(&world, &shot, 2e-3);
        assert!(quantile(&mut errors, 0.999) > 1e-3, "planted normals were not detected");
    }
    assert!(measured >= 2, "{name}: {measured} near views");
}

#[test]
fn normals_are_the_derivative() {
    normals_hold("hill", hill());
    normals_hold("rough", rough());
    if full() {
        normals_hold("Rainier", World::real("dem/geotiff/mt_rainier_90m.tif", 1.0));
    }
    normals_hold("UTM", World::real("dem/encodings_rainier/utm10n_90m_nodata-9999_f32.tif", 1.0));
}

/// Counts sky pixels whose four neighbours are surface.
fn pinholes(shot: &Shot) -> usize {
    (0..shot.depth_m.len())
        .filter(|&pixel| {
            shot.is_sky(pixel)
                && [[1, 0], [-1, 0], [0, 1], [0, -1]]
                    .into_iter()
                    .all(|step| shot.neighbour(pixel, step).is_some_and(|neighbour| !shot.is_sky(neighbour)))
        })
        .count()
}

fn sky(shot: &Shot) -> usize {
    (0..shot.depth_m.len()).filter(|&pixel| shot.is_sky(pixel)).count()
}

/// Counts, among every eleventh pixel, rays that pass below the surface by more than `allowed_px` before they end,
/// which means that they went through a crack.
fn seen_through(world: &World, shot: &Shot, allowed_px: f64) -> usize {
    let field = Field { grid: &world.grid, mapping: &world.mapping };
    let focal_px = shot.focal_px();
    (0..shot.depth_m.len())
        .into_par_iter()
        .step_by(11)
        .filter(|&pixel| !shot.is_sky(pixel))
        .filter(|&pixel| {
            let way_m = shot.position_m[pixel];
            let distance_m = way_m.length();
            (1..100).any(|step| {
                let along_m = way_m * (f64::from(step) / 100.0).sqrt();
                let at_m = shot.view.pose.position_m + along_m;
                let allowed_m = allowed_px * along_m.length().min(distance_m) / focal_px;
                field.height_m(at_m.truncate()).is_some_and(|height_m| height_m - at_m.z > allowed_m)
            })
        })
        .count()
}

fn no_crack(name: &str, world: Option<World>) {
    let Some(mut world) = world else { return };
    let mut renderer = None;
    // Looking down, all of the picture is surface; looking ahead, there are no holes in it. Each step moves a few
    // pixels and turns.
    let paths = [("+150,0,-90,50", true, 4.0), ("+900,30,-60,40", true, 40.0), ("+40,60,-6,60", false, 7.0)];
    let (steps, all_px): (u32, &[f64]) = if full() { (20, &[1.0, 4.0]) } else { (5, &[4.0]) };
    for &allowed_px in all_px {
        world.surfaces.terrain.set_lod_error_px(allowed_px);
        for (path, is_down, step_m) in &paths {
            let start = world.pose(&format!("300,-200,{path}"));
            let (mut holes, mut through, mut last) = (0, 0, None);
            for step in 0..steps {
                let mut pose = start;
                let way_m = step_m * f64::from(step);
                pose.position_m += glam::DVec3::new(0.8 * way_m, 0.6 * way_m, 0.0);
                let turn = glam::DQuat::from_rotation_z(0.003 * f64::from(step));
                (pose.forward, pose.right, pose.up) = (turn * pose.forward, turn * pose.right, turn * pose.up);
                let shot = shoot(&mut world, &mut renderer, pose, size_px());
                holes += if *is_down { sky(&shot) } else { pinholes(&shot) };
                if step % 5 == 0 {
                    through += seen_through(&world, &shot, 2.0 * allowed_px);
                }
                last = Some(shot);
            }
            println!(
                "{name}, {path}, {allowed_px} px: {holes} holes in {steps} pictures, {through} rays through the surface"
            );
            assert_eq!(holes, 0, "{name}, {path}, {allowed_px} px");
            assert_eq!(through, 0, "{name}, {path}, {allowed_px} px");
            // Planted: one pixel, then one patch is missing.
            let mut shot = last.unwrap();
            let [width, height] = size_px();
            let middle = (width * (height - height / 9) + width / 2) as usize;
            let depth_m = std::mem::replace(&mut shot.depth_m[middle], f64::INFINITY);
            assert_eq!((pinholes(&shot), sky(&shot) > 0), (1, true), "a missing pixel was not detected");
            shot.depth_m[middle] = depth_m;
            let id = shot.id[middle];
            for pixel in 0..shot.id.len() {
                if shot.id[pixel] == id {
                    shot.depth_m[pixel] = f64::INFINITY;
                }
            }
            assert!(sky(&shot) > 0, "a missing patch was not detected");
        }
    }
}

#[test]
fn the_hill_has_no_crack() {
    // The hill is as large as the widest view down.
    no_crack("hill", World::new(Hill::square(701, 10.0).1, 1.0));
}

#[test]
fn rough_land_has_no_crack() {
    no_crack("rough", rough());
}

#[test]
fn channels_agree() {
    let Some(mut world) = rough() else { return };
    let mut renderer = None;
    for view in views(&world) {
        let pose = world.pose(&view);
        let shot = shoot(&mut world, &mut renderer, pose, size_px());
        let (mut off_axis, mut off_ray_px) = (0.0_f64, 0.0_f64);
        for pixel in 0..shot.depth_m.len() {
            let (position_m, normal) = (shot.position_m[pixel], shot.normal[pixel]);
            assert_eq!(shot.is_sky(pixel), shot.id[pixel] == 0);
            if shot.is_sky(pixel) {
                assert_eq!((position_m, normal), (glam::DVec3::ZERO, glam::DVec3::ZERO));
                continue;
            }
            assert!((normal.length() - 1.0).abs() < 1e-6);
            off_axis = off_axis.max((position_m.dot(pose.forward) / shot.depth_m[pixel] - 1.0).abs());
            let off = position_m / position_m.dot(pose.forward) - shot.ray(pixel);
            off_ray_px = off_ray_px.max(off.length() * shot.focal_px());
        }
        println!("{view}: depth off the axis by {off_axis:.2e}, position off the ray by {off_ray_px:.2e} px");
        assert!(off_axis < 1e-6 && off_ray_px < 2e-3, "{view}");
        // Planted: the ray of the next pixel.
        let pixel = shot.depth_m.len() - 2;
        let off = shot.position_m[pixel] / shot.depth_m[pixel] - shot.ray(pixel + 1);
        assert!(shot.is_sky(pixel) || off.length() * shot.focal_px() > 0.5);
    }
}
