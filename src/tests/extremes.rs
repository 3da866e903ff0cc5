//! Extreme numbers: far from the origin, on a curved earth, from below the ground to 1000 km above it, from 1 mm to 10
//! km between samples, fields of view of 1° to 150°, pictures of one pixel.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod checked;
mod culling;
mod lands;
mod lettering;
mod scenes;
mod styles;
mod times;
mod twins;
mod views;

use crate::tests::common;

use std::sync::Arc;

use common::shot::{Shot, shoot, shoot_style};
use common::{World, grid_of, random};
use hachure::picture::PartRule;
use hachure::scene::earth::Earth;
use hachure::source::HeightGrid;
use hachure::style::{Style, preset_text};
use hachure::tiles::Terrain;
use hachure::tiles::terrain::TerrainOptions;

/// Checks that every number is finite and that all channels agree about what is sky; returns the number of ground
/// pixels.
fn is_sound(shot: &Shot) -> Result<usize, String> {
    let mut ground = 0;
    for pixel in 0..shot.depth_m.len() {
        let (depth_m, normal) = (shot.depth_m[pixel], shot.normal[pixel]);
        let bad = |what: &str| Err(format!("pixel {:?}: {what}", shot.place(pixel)));
        if !shot.picture[pixel].iter().all(|value| value.is_finite()) || !shot.error[pixel].is_finite() {
            return bad("the picture or the line error is not finite");
        }
        if shot.is_sky(pixel) {
            continue;
        }
        ground += 1;
        if !(depth_m.is_finite() && depth_m > 0.0 && shot.position_m[pixel].is_finite()) {
            return bad(&format!("depth {depth_m}"));
        }
        if (normal.length() - 1.0).abs() > 1e-3 {
            return bad(&format!("normal {normal}"));
        }
    }
    Ok(ground)
}

/// Counts sky pixels whose ray passes below the land inside its extent, so that it must have hit the land. For cameras
/// above the land.
fn holes(world: &World, shot: &Shot) -> usize {
    let [east_m, north_m] = world.surfaces.terrain.extent_m();
    let camera_m = shot.view.pose.position_m;
    let goes_under = |pixel: usize| {
        let ray = shot.ray(pixel);
        let along_m = (f64::from(world.surfaces.terrain.range_m()[0]) - camera_m.z) / ray.z;
        let under = camera_m + ray * along_m;
        // Land smaller than a pixel may be missed between the centres of pixels.
        let pixel_m = along_m / shot.focal_px();
        ray.z < 0.0 && under.x.abs() + pixel_m < 0.499 * east_m && under.y.abs() + pixel_m < 0.499 * north_m
    };
    (0..shot.depth_m.len()).filter(|&pixel| shot.is_sky(pixel) && goes_under(pixel)).count()
}

/// Returns land from −11,000 to 9,000 m with cliffs of one sample, as a function of the position in samples.
fn wild_m(spacing_m: f64) -> impl Fn(f64, f64) -> f64 {
    move |x_m, y_m| {
        let (i, j) = ((x_m / spacing_m).floor(), (y_m / spacing_m).floor());
        let cliff = if random(i as i64, j as i64) < 0.02 { 3000.0 } else { 0.0 };
        let wave = 9000.0 * (i / 40.0).sin() * (j / 33.0).cos();
        (wave + cliff - 1000.0).clamp(-11_000.0, 9_000.0) * (spacing_m / 30.0).min(1.0)
    }
}

#[test]
fn every_camera_lens_and_spacing_gives_a_picture() {
    let (mut cases, mut drawn, mut seen) = (0, 0, 0);
    let (spacings_m, sizes_px) = ([0.001, 10_000.0, 30.0, 1.0], [[1, 1], [96, 54], [3, 200]]);
    let (max_spacings, max_sizes) = if common::full() { (4, 3) } else { (3, 2) };
    for spacing_m in spacings_m.into_iter().take(max_spacings) {
        let Some(mut world) = World::new(grid_of(521, 403, spacing_m, wild_m(spacing_m)), 1.0) else { return };
        let mut renderer = None;
        let heights = ["+0.1", "-500", "-12000", "1000000", "+2", "20000"];
        for (i, z) in heights.into_iter().enumerate() {
            for (fov, pitch) in [(1.0, -5.0), (60.0, -30.0), (150.0, -89.9), (90.0, 10.0)] {
                let view = format!("{},{},{z},{},{pitch},{fov}", 31.3 * spacing_m, -17.1 * spacing_m, 67 * i);
                let pose = world.pose(&view);
                for size_px in sizes_px.into_iter().take(max_sizes) {
                    cases += 1;
                    // The fast tier draws every seventh, which have all heights, lenses and sizes.
                    if !common::full() && cases % 7 != 1 {
                        continue;
                    }
                    drawn += 1;
                    let shot = shoot(&mut world, &mut renderer, pose, size_px);
                    match is_sound(&shot) {
                        Ok(ground) => seen += usize::from(ground > 0),
                        Err(error) => panic!("{spacing_m} m, {view}, {size_px:?}: {error}"),
                    }
                    // From below the ground, the camera sees through it.
                    if !z.contains('-') {
                        assert_eq!(holes(&world, &shot), 0, "{spacing_m} m, {view}, {size_px:?}: holes in the land");
                    }
                }
            }
        }
    }
    println!("{seen} of {drawn} pictures show ground");
    assert!(24 * seen > 5 * drawn, "only {seen} of {drawn} pictures show ground");
}

/// Returns land that repeats every 400 samples, so that positions 1e7 m apart have the same surroundings, and whose
/// levels all halve evenly.
fn periodic() -> HeightGrid {
    let spacing_m = 5000.0;
    grid_of(4096, 512, spacing_m, move |x_m, y_m| {
        let (i, j) = ((x_m / spacing_m + 0.5 * 4095.0).round() as i64, (y_m / spacing_m + 0.5 * 511.0).round() as i64);
        let turn = std::f64::consts::TAU * i.rem_euclid(400) as f64 / 400.0;
        let noise = random(i.rem_euclid(400), j) * 400.0;
        2000.0 + 1500.0 * (5.0 * turn).sin() * (j as f64 / 9.0).cos() + 600.0 * (23.0 * turn).cos() + noise
    })
}

#[test]
fn ten_thousand_kilometres_from_the_origin_nothing_moves() {
    let Some(mut world) = World::new(periodic(), 0.05) else { return };
    let mut renderer = None;
    let mut worst_px = 0.0_f64;
    let mut planted_px = 0.0_f64;
    // A slow path whose steps of a hundredth of a pixel would reveal jitter.
    let steps = if common::full() { 12 } else { 3 };
    for step in 0..steps {
        let (x_m, y_m, yaw) =
            (137.25 * f64::from(step), 80_000.0 + 93.5 * f64::from(step), 5.0 + 0.01 * f64::from(step));
        let view = |east_m: f64| format!("{:.6},{y_m},9000,{yaw},-8,55", x_m + east_m);
        let mut at = |east_m: f64| {
            let pose = world.pose(&view(east_m));
            shoot(&mut world, &mut renderer, pose, [192, 108])
        };
        let (near, far, shifted) = (at(0.0), at(1e7), at(1e7 + 300.0));
        let apart_px = |a: &Shot, b: &Shot| {
            let px = |i: usize| (a.position_m[i] - b.position_m[i]).length() * a.focal_px() / b.position_m[i].length();
            let both = (0..a.depth_m.len()).filter(|&i| !a.is_sky(i) && !b.is_sky(i));
            let mut apart: Vec<f64> = both.map(px).collect();
            assert!(apart.len() > 8000, "{}", apart.len());
            // At contours a pixel may see the near side or the far one.
            common::quantile(&mut apart, 0.995)
        };
        worst_px = worst_px.max(apart_px(&near, &far));
        planted_px = planted_px.max(apart_px(&near, &shifted));
    }
    println!("1e7 m from the origin: {worst_px:.4} px apart; with a step of 300 m: {planted_px:.2} px");
    assert!(worst_px < 0.1, "the picture moves by {worst_px} px");
    assert!(planted_px > 0.1, "a step of 300 m must show");
}

#[test]
fn the_earth_bends_away() {
    for (refraction, drop_m) in [(0.0, 784.8), (0.13, 682.8)] {
        let Some(mut world) = World::new(grid_of(701, 701, 500.0, |_, _| 0.0), 1.0) else { return };
        let options =
            TerrainOptions { inverse_radius: Earth { refraction }.inverse_radius(), ..TerrainOptions::default() };
        world.surfaces = Terrain::new(&world.gpu, Arc::clone(world.surfaces.terrain.store()), options).unwrap().into();
        let pose = world.pose("0,-120000,1500,0,-0.9,4");
        let shot = shoot(&mut world, &mut None, pose, [64, 400]);
        is_sound(&shot).unwrap();
        let (mut checked, mut last) = (0, 0.0_f64);
        for pixel in (0..shot.depth_m.len()).filter(|pixel| !shot.is_sky(*pixel)) {
            let at = shot.position_m[pixel];
            let distance_m = at.truncate().length();
            let expected_m = -1500.0 - drop_m * (distance_m / 1e5).powi(2);
            let apart_px = (at.z - expected_m).abs() * shot.focal_px() / distance_m;
            assert!(apart_px < 0.5, "{distance_m} m away: {} instead of {expected_m}", at.z);
            checked += usize::from(distance_m > 90e3);
            last = last.max(distance_m);
        }
        // From 1500 m the horizon is at √(2 R h); the last 17 km before it are one pixel.
        let horizon_m = (2.0 * 1500.0 / Earth { refraction }.inverse_radius()).sqrt();
        println!(
            "refraction {refraction}: {checked} pixels beyond 90 km, horizon at {last:.0} m, expected {horizon_m:.0} m"
        );
        assert!(
            checked > 500 && (last / horizon_m - 1.0).abs() < 0.13,
            "{checked} pixels beyond 90 km; horizon at {last} m, expected {horizon_m} m"
        );
    }
}

#[test]
fn relief_on_a_bent_earth_keeps_its_error() {
    let Some(mut world) =
        World::new(grid_of(701, 645, 200.0, |x, y| 10.0 * common::rough_height_m(x / 10.0, y / 10.0)), 1.0)
    else {
        return;
    };
    let inverse_radius = Earth { refraction: 0.13 }.inverse_radius();
    let options = TerrainOptions { inverse_radius, ..TerrainOptions::default() };
    world.surfaces = Terrain::new(&world.gpu, Arc::clone(world.surfaces.terrain.store()), options).unwrap().into();
    let mut renderer = None;
    let views = ["-20000,-60000,+500,10,-3,50", "3000,-2000,+40,200,-8,70", "0,-90000,60000,0,-35,60"];
    for view in views.into_iter().take(if common::full() { 3 } else { 1 }) {
        let pose = world.pose(view);
        let shot = shoot(&mut world, &mut renderer, pose, [240, 135]);
        let earth_curvature = world.surfaces.terrain.earth_curvature(pose.position_m.z);
        let errors = |raised_m: f64| {
            let mut errors: Vec<f64> = (0..shot.depth_m.len())
                .filter(|&pixel| !shot.is_sky(pixel))
                .filter_map(|pixel| {
                    let flat = earth_curvature.unbend(shot.position_m[pixel]) + pose.position_m;
                    let true_m = world.surfaces.terrain.height_m(flat.truncate())?;
                    Some((flat.z + raised_m - true_m).abs() * shot.focal_px() / shot.position_m[pixel].length())
                })
                .collect();
            assert!(errors.len() > 5000, "{view}: {}", errors.len());
            common::quantile(&mut errors, 0.999)
        };
        let p999_px = errors(0.0);
        println!("{view}: {p999_px:.3} px");
        assert!(p999_px <= 1.0, "{view}: 99.9 % of the pixels should be off by at most 1 px, found {p999_px}");
        assert!(errors(3.0 * 60_000.0 / shot.focal_px()) > 1.0, "a raised surface must fail");
        // Normals are those of the curved surface; near the camera they equal those of the flat one.
        is_sound(&shot).unwrap();
    }
}

/// Distant land has the same tint as near land of the same elevation, however far it is below the camera's horizontal
/// plane.
#[test]
fn tints_follow_the_height_above_the_sea() {
    // A plateau with a pit behind the camera, so that tints range from 200 m below the plateau to its own height.
    let height_m = |x: f64, y: f64| if x < -6500.0 && y < -6500.0 { -200.0 } else { 0.0 };
    let Some(mut world) = World::new(grid_of(701, 701, 20.0, height_m), 1.0) else { return };
    // An earth a hundredth of the real size: at 5 km the land is 196 m lower.
    let options = TerrainOptions { inverse_radius: 1.0 / 63_710.0, ..TerrainOptions::default() };
    world.surfaces = Terrain::new(&world.gpu, Arc::clone(world.surfaces.terrain.store()), options).unwrap().into();
    let lines = "\n[lines]\ndetector = \"lsa\"\nepsilon = \"footprint\"\nramp = [0.25, 0.5]\ndensity = 2.0\nink = \"#14120f\"\nfaintest = 0.12\nreach = 1.4\n";
    let style = Style::parse("tint", &(preset_text("plain").unwrap().to_owned() + lines)).unwrap();
    let pose = world.pose("0,-3000,300,0,-5.6,4");
    let shot = shoot_style(&mut world, &mut None, pose, pose, [64, 200], &style, &PartRule::default());
    let mean = |from_m: f64, to_m: f64| {
        let is_there = |pixel: &usize| !shot.is_sky(*pixel) && shot.line[*pixel] == 0.0;
        let reds: Vec<f64> = (0..shot.depth_m.len())
            .filter(is_there)
            .filter(|&pixel| (from_m..to_m).contains(&shot.position_m[pixel].length()))
            .map(|pixel| f64::from(shot.picture[pixel][0]))
            .collect();
        assert!(reds.len() > 100, "{} pixels", reds.len());
        reds.iter().sum::<f64>() / reds.len() as f64
    };
    let (near, far) = (mean(0.0, 3200.0), mean(4500.0, 5600.0));
    println!("red channel of the highest tint: {near:.3} near, {far:.3} far away");
    assert!(near > 0.6 && far > 0.8 * near, "red channel near {near}, far {far}");
}
