//! Tests that nothing pops: from one frame of a flight at 300 m/s to the next, no vertex moves by more than a pixel.
//!
//! Three motions are distinguished, each in pixels of the later frame:
//!
//! - *whole*: how far a vertex moves in the world. This includes the vertex's gliding along the surface, which is
//!   invisible: positions and normals are those of the surface at a pixel, not of the mesh.
//! - *across*: the part of that motion along the surface's normal.
//! - *in place*: how far the mesh moves along its normal at a fixed point, which is *across* without gliding over
//!   curved land. It needs no matching vertex, so it also covers splits and merges.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

mod mesh;
mod motions;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use common::stores::{Bumpy, Fate};
use common::{World, gpu, grid_of, pose_of, rough_height_m};
use glam::DVec2;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::pyramid::TileStore;
use hachure::pyramid::store::ContinentStore;
use hachure::pyramid::tile::PATCH_QUADS;
use hachure::scene::camera::Camera;
use hachure::scene::path::CameraPath;
use hachure::scene::view::{Pose, View};
use hachure::source::Silent;
use hachure::style::{Style, preset_text};
use hachure::tiles::Terrain;
use hachure::tiles::terrain::{Loading, TerrainOptions};
use hachure::world::Surfaces;

use crate::tests::popping::mesh::Mesh;
use crate::tests::popping::motions::{Motions, motions};

const SIZE_PX: [u32; 2] = [320, 180];
const FPS: f64 = 30.0;
const SPEED_M_PER_S: f64 = 300.0;
const SPACING_M: f64 = 10.0;
/// Largest motion that the frame guarantees.
const MAX_PX: f64 = 1.0;
/// Vertices along a side of a patch.
const SIDE: usize = PATCH_QUADS as usize + 1;

/// Motions in a flight.
#[derive(Default)]
struct Flight {
    all: Motions,
    /// Numbers of pairs of frames in which *whole*, *across* and *in place* exceed [`MAX_PX`] somewhere.
    frames_over: [usize; 3],
    /// Planted: each 30th frame compared with the one 30 frames before.
    seldom: Motions,
    /// Planted: frames without morphing.
    unmorphed: Motions,
}

/// Flies along `poses` and returns the mesh of each frame.
fn film(name: &str, gpu: &Gpu, world: &mut Surfaces, poses: &[Pose]) -> Vec<Mesh> {
    let style = Style::parse("plain", preset_text("plain").unwrap()).unwrap();
    let mut renderer = Renderer::new(gpu).unwrap();
    let view_of = |pose: Pose| View::whole(pose, pose, SIZE_PX);
    // In a window that has been open for a while after a jump, nothing fades any more.
    let start = Instant::now();
    while world.terrain.options().loading == Loading::Stream && start.elapsed() < Duration::from_secs(30) {
        let rest = Mesh::read(gpu, &mut renderer, world, view_of(poses[0]), &style);
        if !rest.late && start.elapsed() > Duration::from_secs(2) {
            break;
        }
        // Other tests need the processor that this frame would only wait with.
        std::thread::sleep(Duration::from_millis(100));
    }
    // Frames are compared after all are drawn, since a window does not wait for a comparison.
    let start = Instant::now();
    let meshes: Vec<Mesh> =
        poses.iter().map(|pose| Mesh::read(gpu, &mut renderer, world, view_of(*pose), &style)).collect();
    let frame_ms = start.elapsed().as_secs_f64() * 1000.0 / poses.len() as f64;
    println!("{name}: {} frames of {frame_ms:.0} ms, {} late", meshes.len(), count_late(&meshes));
    meshes
}

fn count_late(meshes: &[Mesh]) -> usize {
    meshes.iter().filter(|mesh| mesh.late).count()
}

/// Flies along `poses` and compares each frame with the one before.
fn fly(name: &str, gpu: &Gpu, world: &mut Surfaces, poses: &[Pose], plants: bool) -> Flight {
    let meshes = film(name, gpu, world, poses);
    let grid_projection = world.terrain.grid_projection().clone();
    let mut flight = Flight::default();
    for (number, pair) in meshes.windows(2).enumerate() {
        let moved = motions(&pair[0], &pair[1], &grid_projection);
        for kind in 0..3 {
            flight.frames_over[kind] += usize::from(moved.most(kind) > MAX_PX);
        }
        flight.all.append(moved);
        if plants && number < 15 {
            flight.unmorphed.append(motions(
                &pair[0].without_morphing(),
                &pair[1].without_morphing(),
                &grid_projection,
            ));
        }
    }
    if plants {
        for pair in meshes.iter().step_by(30).collect::<Vec<_>>().windows(2) {
            flight.seldom.append(motions(pair[0], pair[1], &grid_projection));
        }
    }
    println!("50 %, 99 %, 99.9 %, most | whole{:31} | across{:30} | in place", "", "");
    println!("{}", flight.all.line("px a frame"));
    if plants {
        println!("{}", flight.seldom.line("planted: 30 frames"));
        println!("{}", flight.unmorphed.line("planted: no morphing"));
    }
    println!("pairs of frames with more than {MAX_PX} px: {:?}", flight.frames_over);
    flight
}

impl Flight {
    /// Asserts the guarantee for all three motions.
    fn assert_nothing_pops(&self) {
        for (kind, name) in ["whole", "across", "in place"].into_iter().enumerate() {
            assert!(self.all.most(kind) <= MAX_PX, "{name}: {:?}", self.all.worst[kind]);
        }
        let (pairs, lone) = (self.all.whole.len(), self.all.without_partner);
        let least = if common::full() { 1_000_000 } else { 200_000 };
        assert!(pairs > least && lone * 50 < pairs, "{pairs} pairs of vertices, {lone} without partner");
    }
}

/// Returns the poses of a low flight at 300 m/s across rough land: 60 m above the highest ground within 300 m,
/// smoothed.
fn across_rough_land(terrain: &Terrain, frames: usize) -> Vec<Pose> {
    let step_m = SPEED_M_PER_S / FPS;
    let way = DVec2::new(0.6, 0.8);
    let place = |frame: i64| DVec2::new(-2000.0, -2600.0) + way * (step_m * frame as f64);
    let ground_m = |frame: i64| terrain.height_m(place(frame)).unwrap();
    let highest_m = |frame: i64| (-30..=30).map(|offset| ground_m(frame + offset)).fold(f64::MIN, f64::max);
    let smooth_m = |frame: i64| (-20..=20).map(|offset| highest_m(frame + offset)).sum::<f64>() / 41.0 + 60.0;
    let camera = |frame: i64| Camera {
        position_m: place(frame).extend(smooth_m(frame)),
        height_above_ground: false,
        yaw_deg: way.x.atan2(way.y).to_degrees(),
        pitch_deg: -8.0,
        fov_deg: 58.0,
    };
    (0..frames as i64).map(|renderer| pose_of(&camera(renderer))).collect()
}

fn rough() -> Option<World> {
    World::new(grid_of(801, 783, SPACING_M, rough_height_m), 1.0)
}

#[test]
fn nothing_pops_over_rough_land() {
    let Some(mut world) = rough() else { return };
    // Two seconds; in the fast tier one.
    let poses = across_rough_land(&world.surfaces.terrain, if common::full() { 61 } else { 31 });
    let flight = fly("rough land", &world.gpu, &mut world.surfaces, &poses, true);
    flight.assert_nothing_pops();
    for planted in [&flight.seldom, &flight.unmorphed] {
        assert!((0..3).all(|kind| planted.most(kind) > MAX_PX), "planted: {:?}", planted.worst);
    }
}

/// Returns the middle of the continent, like the scene of that name.
fn continent() -> Arc<dyn TileStore> {
    let cache = common::between_runs("built-in-land");
    Arc::new(ContinentStore::open(1, 2048, SPACING_M, Some(&cache), &Silent).unwrap())
}

/// Returns the poses of three seconds of the valley flight; in the fast tier of one.
fn along_the_valley() -> Vec<Pose> {
    let path = CameraPath::read(Path::new("terrain/paths/valley.csv")).unwrap();
    (0..if common::full() { 91 } else { 31 })
        .map(|frame: u32| pose_of(&path.sample(30.0 + f64::from(frame) / FPS)))
        .collect()
}

#[test]
fn nothing_pops_along_the_valley() {
    let Some(gpu) = gpu() else { return };
    let mut surfaces = Terrain::new(&gpu, continent(), TerrainOptions::default()).unwrap().into();
    let flight = fly("valley", &gpu, &mut surfaces, &along_the_valley(), true);
    flight.assert_nothing_pops();
    // Smooth land hardly moves across itself even with planted errors, but its vertices do.
    for planted in [&flight.seldom, &flight.unmorphed] {
        assert!(planted.most(0) > MAX_PX, "planted: {:?}", planted.worst);
    }
}

#[test]
fn nothing_pops_while_tiles_stream() {
    let Some(gpu) = gpu() else { return };
    // Tiles that arrive in time, and in the long tier tiles that arrive too late and fade in.
    for delay_ms in [5, 1500].into_iter().take(if common::full() { 2 } else { 1 }) {
        let store = Bumpy::new(continent(), delay_ms, Box::new(|_, _| Fate::Comes));
        let options = TerrainOptions { loading: Loading::Stream, ..TerrainOptions::default() };
        let mut surfaces = Terrain::new(&gpu, store, options).unwrap().into();
        let (name, poses) = (format!("tiles of {delay_ms} ms"), along_the_valley());
        if delay_ms < 100 {
            fly(&name, &gpu, &mut surfaces, &poses, false).assert_nothing_pops();
        } else {
            // Larger motion comes from missing detail, which is reported as late. The flight is twenty times as fast,
            // so that it needs tiles before they arrive even where frames are slow.
            let poses = [0, 20, 40, 60, 60, 60, 60].map(|frame| poses[frame]);
            let meshes = film(&name, &gpu, &mut surfaces, &poses);
            assert!(count_late(&meshes) > 0, "expected late frames, found none");
        }
    }
}
