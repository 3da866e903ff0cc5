//! The picture bounds the work: with any relief and any allowed error, a picture has a bounded number of triangles and
//! reports its error. Undeclared no-data values give a warning.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

#[path = "../src/tests/common/mod.rs"]
mod common;

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use common::shot::{Shot, ink, shoot, shoot_style};
use common::{World, baked, grid_of, random};
use glam::DVec2;
use hachure::internals::AllPatches;
use hachure::internals::GridProjection;
use hachure::internals::Viewpoint;
use hachure::internals::largest_lod_error_px;
use hachure::internals::max_patches;
use hachure::internals::select;
use hachure::internals::select_within;
use hachure::internals::terrain_view;
use hachure::picture::PartRule;
use hachure::pyramid::TileStore;
use hachure::scene::view::{Part, Pose, View};
use hachure::source::{HeightGrid, HeightReader, OpenOptions, Window, WorldMapping, open_reader_with};

const SIZE_PX: [u32; 2] = [64, 36];
/// Many times the duration of any picture here.
const LONG: Duration = Duration::from_secs(20);

/// Returns a hill of `side` × `side` samples, 1 m apart.
fn hill(side: u32) -> HeightGrid {
    grid_of(side, side, 1.0, move |x_m, y_m| hill_m(f64::from(side), x_m, y_m))
}

fn hill_m(side_m: f64, x_m: f64, y_m: f64) -> f64 {
    0.4 * side_m * (-(x_m * x_m + y_m * y_m) / (0.08 * side_m * side_m)).exp() + 0.02 * side_m * (x_m * 0.3).sin()
}

/// Returns heights given by column and row, 1 m apart.
fn by_sample(side: u32, height_m: impl Fn(i64, i64) -> f64) -> HeightGrid {
    let half = 0.5 * f64::from(side - 1);
    grid_of(side, side, 1.0, move |x_m, y_m| height_m((x_m + half).round() as i64, (half - y_m).round() as i64))
}

/// Returns a camera near the southern edge, a little above the ground, that looks north.
fn from_the_edge(side: u32) -> String {
    format!("1,{},+{},3,-4,60", -0.4 * f64::from(side), 0.05 * f64::from(side))
}

fn budget(grid: &HeightGrid, error_px: f64) -> u64 {
    let pixels = f64::from(SIZE_PX[0] * SIZE_PX[1]);
    max_patches(pixels, f64::from(grid.width) * f64::from(grid.height), error_px, 512 << 20) as u64
}

/// Draws a picture; `None` without a GPU.
fn draw(grid: HeightGrid, camera: &str, error_px: f64) -> Option<(World, Shot, Duration)> {
    let start = Instant::now();
    let mut world = World::new(grid, error_px)?;
    let pose = world.pose(camera);
    let shot = shoot(&mut world, &mut None, pose, SIZE_PX);
    Some((world, shot, start.elapsed()))
}

#[test]
fn every_relief_gives_a_picture_within_the_budget() {
    let side = 100;
    let check = |height_m: f64| move |i: i64, j: i64| if (i + j) % 2 == 0 { height_m } else { -height_m };
    let land = move |i: i64, j: i64| hill_m(f64::from(side), i as f64 - 50.0, j as f64 - 50.0);
    let cases: Vec<(&str, HeightGrid)> = vec![
        ("spikes of 200 km", by_sample(20, |i, j| if (i * 7 + j * 13) % 11 == 0 { 2e5 } else { 0.0 })),
        ("heights of 655 km", by_sample(side, |i, j| random(i, j) * 655e3)),
        ("a checkerboard of 8 km", by_sample(side, check(8000.0))),
        ("undeclared voids", by_sample(side, move |i, j| if random(i, j) < 0.01 { -9999.0 } else { land(i, j) })),
        ("one spike", by_sample(side, move |i, j| if (i, j) == (50, 70) { 2e5 } else { land(i, j) })),
        ("a checkerboard of half of all numbers", by_sample(20, check(f64::from(f32::MAX) / 2.0))),
        ("a checkerboard of 1e30", by_sample(side, check(1e30))),
        ("denormal heights", by_sample(side, |i, j| random(i, j) * 1e-40)),
        ("one height", by_sample(side, |_, _| 7.0)),
        ("islands", by_sample(side, move |i, j| if (i / 9 + j / 7) % 3 == 0 { f64::NAN } else { land(i, j) * 1e3 })),
    ];
    for (name, grid) in cases {
        let (camera, most) = (from_the_edge(grid.width), budget(&grid, 1.0));
        let Some((_, shot, took)) = draw(grid, &camera, 1.0) else { return };
        let report = &shot.report;
        println!("{name}: {} patches, {:.2} px, {took:.2?}", report.patches, report.error_px);
        assert!(report.patches <= most, "{name}: {} patches, more than the budget of {most}", report.patches);
        assert!(took < LONG, "{name}: took {took:?}");
        assert!(
            shot.picture.iter().flatten().all(|value| value.is_finite()),
            "{name}: the picture has values that are not finite"
        );
        assert_eq!(report.over_budget > 0, report.error_px > 1.0, "{name}: over_budget does not match error_px");
    }
}

#[test]
fn ordinary_land_is_within_the_budget() {
    for (side, camera) in [(20, "1,-8,+1,3,5,60"), (100, "1,-40,+2,3,0,60"), (300, "0,0,+1,77,-3,90")] {
        let Some((_, shot, _)) = draw(hill(side), camera, 1.0) else { return };
        assert_eq!((shot.report.over_budget, shot.report.error_px), (0, 1.0), "{side}: {}", shot.report.patches);
        assert!(4 * shot.report.patches <= budget(&hill(side), 1.0), "{side}: {} patches", shot.report.patches);
    }
}

#[test]
fn an_error_that_takes_too_much_is_reported_and_kept() {
    let grid = hill(100);
    let most = budget(&grid, 1e-9);
    let Some(mut world) = World::new(grid, 1e-9) else { return };
    let pose = world.pose("1,-40,+2,3,0,60");
    let mut renderer = None;
    let shot = shoot(&mut world, &mut renderer, pose, SIZE_PX);
    let report = &shot.report;
    assert_eq!(report.over_budget, 1);
    assert!(report.patches <= most && report.patches > most / 2, "{} of {most} patches", report.patches);
    assert!(report.error_px > 1e-6 && report.error_px < 0.1, "{} px", report.error_px);
    // The positions are on the surface itself, so the measured error is smaller than that of the mesh.
    let drawn = renderer.as_ref().unwrap();
    let measured = largest_lod_error_px(&world.gpu, drawn, &shot.view, &world.surfaces.terrain, 0).unwrap().unwrap();
    assert!(measured < report.error_px.max(0.01), "measured {measured} px, reported {} px", report.error_px);
    // A picture does not depend on what was drawn before.
    let other = world.pose("9,30,+20,180,-20,40");
    shoot(&mut world, &mut renderer, other, [96, 54]);
    let again = shoot(&mut world, &mut renderer, pose, SIZE_PX);
    assert_eq!((again.report.error_px, again.report.patches), (report.error_px, report.patches));
    assert!(again.picture == shot.picture);
}

#[test]
fn toward_steep_land_the_surface_gets_coarser_step_by_step() {
    let Some(mut world) = World::new(by_sample(100, |i, j| 100.0 * random(i, j)), 1.0) else { return };
    let picture_px = [128, 72];
    let mut before = None;
    let mut over = 0;
    for step in 0..60 {
        let pose = world.pose(&format!("3,{},120,2,-20,60", -300.0 * 0.96_f64.powi(step)));
        let view = View::whole(pose, pose, picture_px);
        let prepared = world.surfaces.terrain.prepare(&world.gpu, &terrain_view(&view));
        let error_px = prepared.detail.error_px;
        let change = before.replace(error_px).map_or(1.0, |before: f64| (error_px / before).max(before / error_px));
        // The camera approaches by 4 % of its distance per step.
        assert!(change < 1.2, "step {step}: the error changes by a factor of {change}");
        over += u32::from(prepared.detail.is_over_budget);
    }
    assert!((5..60).contains(&over), "{over} steps were over the budget");
}

#[test]
fn parts_of_a_picture_have_one_error() {
    let Some(mut world) = World::new(by_sample(100, |i, j| 3000.0 * random(i, j)), 0.05) else { return };
    let pose = world.pose(&from_the_edge(100));
    let parts = PartRule { whole_px: 1, part_px: 48, ..PartRule::default() };
    let mut draw = || shoot_style(&mut world, &mut None, pose, pose, [128, 72], &ink("footprint"), &parts);
    let shot = draw();
    assert!(shot.report.parts > 4 && shot.report.over_budget == 1, "{:?}", shot.report);
    assert!(draw().picture == shot.picture);
    // A part that sees little could have a smaller error, but has the error of all parts.
    let part = Part { origin_px: [60, 40], size_px: [8, 8] };
    let view = View::of_part(pose, pose, [128, 72], part);
    let alone_px = world.surfaces.terrain.detail_of(&world.gpu, &terrain_view(&view)).error_px;
    assert!(
        alone_px < 0.9 * shot.report.error_px,
        "alone the part has {alone_px} px, the picture {} px",
        shot.report.error_px
    );
    world.surfaces.terrain.hold_error_px(shot.report.error_px);
    let held_px = world.surfaces.terrain.detail_of(&world.gpu, &terrain_view(&view)).error_px;
    assert!((held_px / shot.report.error_px - 1.0).abs() < 1e-9, "the part has {held_px} px");
}

fn view_of(pose: Pose) -> View {
    View::whole(pose, pose, SIZE_PX)
}

/// Tests the planted error: the same selection without a budget takes more patches.
#[test]
fn without_a_budget_steep_land_takes_more() {
    let grid = by_sample(60, |i, j| if (i + j) % 2 == 0 { 8000.0 } else { -8000.0 });
    let (_folder, pyramid) = baked(&grid);
    let store: Arc<dyn TileStore> = Arc::new(pyramid);
    let patches = AllPatches::read(&store).unwrap();
    let mapping = WorldMapping::new(store.georeference(), grid.width, grid.height).unwrap();
    let grid_projection = GridProjection::fit(&mapping, grid.width, grid.height);
    let camera: hachure::scene::camera::Camera = "0,-20,9000,0,-60,60".parse().unwrap();
    let view = view_of(common::pose_of(&camera));
    let mut viewpoint = Viewpoint {
        camera_m: camera.position_m,
        frusta: terrain_view(&view).frusta,
        focal_px: view.focal_px(),
        error_px: 1e-3,
        earth_curvature: Default::default(),
        is_above_ground: true,
        nearest_m: 500.0,
    };
    let anchor = grid_projection.anchor(DVec2::ZERO);
    let most = 200;
    assert!(select_within(&patches, &grid_projection, anchor, &viewpoint, most).is_none());
    let all = select(&patches, &grid_projection, anchor, &viewpoint).leaves.len();
    assert!(all > 4 * most, "{all} patches without a budget, expected more than four times {most}");
    // A larger error fits into the budget, and then the budget does not change the selection.
    viewpoint.error_px = 1e4;
    let within = select_within(&patches, &grid_projection, anchor, &viewpoint, most).unwrap();
    assert_eq!(within.leaves, select(&patches, &grid_projection, anchor, &viewpoint).leaves);
}

/// Writes a plain as an ASCII grid with 9 no-data samples.
fn write_marked(path: &Path) {
    let mut text = "ncols 30\nnrows 30\nxllcorner 0\nyllcorner 0\ncellsize 10\n".to_owned();
    for i in 0..900 {
        text += if i % 100 == 7 { "-9999 " } else { "300.5 " };
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn marks_are_reported_and_are_voids_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("marked.asc");
    write_marked(&path);
    let window = Window { x: 0, y: 0, width: 30, height: 30 };
    let open = |no_data| open_reader_with(&path, &OpenOptions { no_data, ..OpenOptions::default() }).unwrap();
    let voids =
        |reader: &dyn HeightReader| reader.read(window).unwrap().iter().filter(|height| height.is_nan()).count();
    assert_eq!((voids(&*open(None)), voids(&*open(Some(-9999.0))), voids(&*open(Some(5.0)))), (0, 9, 0));
    assert_ne!(
        open(None).identity(),
        open(Some(-9999.0)).identity(),
        "nodata does not change the identity of the pyramid"
    );

    let hachure = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
        let output = command.args(arguments).env("HACHURE_CACHE", folder.path().join("cache")).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let name = path.to_str().unwrap();
    let (status, out, stderr) = hachure(&["info", name, "--json"]);
    assert!(status == Some(0) && out.contains("\"void_samples\": 0"), "{out}{stderr}");
    let line =
        "marked.asc: 9 samples are -9999 m (1.0 %), which usually means no-data; --nodata -9999 treats them as no-data";
    assert_eq!(stderr.matches(line).count(), 1, "{stderr}");
    let (status, out, stderr) = hachure(&["info", name, "--json", "--nodata", "-9999"]);
    assert!(status == Some(0) && out.contains("\"void_samples\": 9") && !stderr.contains("usually"), "{out}{stderr}");
    let baked = folder.path().join("baked.tif");
    let (status, out, stderr) =
        hachure(&["bake", name, "-o", baked.to_str().unwrap(), "--nodata", "-9999", "--json", "--voids", "holes"]);
    assert!(status == Some(0) && out.contains("\"void_samples\": 9"), "{out}{stderr}");
    assert_eq!(hachure(&["info", name, "--nodata", "nothing"]).0, Some(2));

    // A scene of files may set nodata; other scenes may not.
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, "[world]\ndem = \"marked.asc\"\nnodata = -9999\n").unwrap();
    assert_eq!(hachure::scene::Scene::read(&scene).unwrap().heights.no_data, Some(-9999.0));
    for wrong in ["[world]\nprocedural = { seed = 1 }\nnodata = 1\n", "[world]\ndem = \"a.tif\"\nnodata = nan\n"] {
        assert!(hachure::scene::Scene::parse(&scene, wrong).is_err(), "{wrong}");
    }
}
