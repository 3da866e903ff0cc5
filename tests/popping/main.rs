//! Nothing pops: from one frame of a flight at 300 m/s to the next, no vertex moves by more than a pixel.
//!
//! Three motions are told apart, each in pixels of the later frame:
//!
//! - *whole*: how far a vertex moves in the world. It includes the vertex's gliding along the surface, of which nothing
//!   is seen: positions and normals are those of the surface at a pixel, not of the mesh.
//! - *across*: the part of that motion along the surface's normal.
//! - *in place*: how far the mesh moves along its normal where the place stays: what is left of *across* when gliding
//!   over bent land is taken out. It needs no partner, so it also holds what splits and merges do.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod common;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use common::stores::{Bumpy, Fate};
use common::{World, gpu, grid_of, quantile, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::frame::{Frame, Light, Requirements};
use hachure::gpu::Gpu;
use hachure::pyramid::{ContinentStore, PATCH_QUADS, TileStore};
use hachure::scene::camera::Camera;
use hachure::scene::path::CameraPath;
use hachure::source::Silent;
use hachure::style::{Style, preset_text};
use hachure::surface::view::{Part, Pose, View};
use hachure::tiles::Terrain;
use hachure::tiles::selection::{PatchInstance, PatchKey};
use hachure::tiles::terrain::{Loading, TerrainOptions};
use hachure::tiles::warp::Warp;
use rayon::prelude::*;

const SIZE_PX: [u32; 2] = [320, 180];
const FPS: f64 = 30.0;
const SPEED_M_PER_S: f64 = 300.0;
const SPACING_M: f64 = 10.0;
/// What is promised for a frame.
const MOST_PX: f64 = 1.0;
/// Vertices along a side of a patch.
const SIDE: usize = PATCH_QUADS as usize + 1;

/// A patch as it was drawn.
#[derive(Clone)]
struct Patch {
    instance: PatchInstance,
    /// In the world, row by row.
    vertices_m: Vec<DVec3>,
}

/// The mesh of a frame.
#[derive(Clone)]
struct Mesh {
    view: View,
    patches: HashMap<PatchKey, Patch>,
    /// Whether some of it was coarser than its error allows.
    late: bool,
}

impl Patch {
    fn at(&self, i: usize, j: usize) -> DVec3 {
        self.vertices_m[j * SIDE + i]
    }

    /// The mesh's normal at a vertex: from neighbours so far away that they have not merged with it.
    fn normal(&self, i: usize, j: usize) -> Option<DVec3> {
        (0..4).map(|reach| 1 << reach).find_map(|reach: usize| {
            let (low, high) = (|k: usize| k.saturating_sub(reach), |k: usize| (k + reach).min(SIDE - 1));
            let east = self.at(high(i), j) - self.at(low(i), j);
            let south = self.at(i, high(j)) - self.at(i, low(j));
            let normal = south.cross(east);
            (normal.z.abs() > 1e-9 * east.length() * south.length()).then(|| normal.normalize())
        })
    }

    /// The height of a triangle over a place, and its normal, if it is over it. Two triangles to a quad, divided from
    /// its first corner to its last.
    fn quad_at(&self, i: usize, j: usize, place_m: DVec2) -> Option<(f64, DVec3)> {
        let (first, last) = (self.at(i, j), self.at(i + 1, j + 1));
        [self.at(i + 1, j), self.at(i, j + 1)].into_iter().find_map(|side| {
            let (a, b) = (side - first, last - first);
            let area = a.truncate().perp_dot(b.truncate());
            if area.abs() < 1e-3 {
                return None;
            }
            let from = place_m - first.truncate();
            let (u, v) = (from.perp_dot(b.truncate()) / area, a.truncate().perp_dot(from) / area);
            (u >= -1e-4 && v >= -1e-4 && u + v <= 1.0 + 1e-4)
                .then(|| (first.z + u * a.z + v * b.z, a.cross(b).normalize()))
        })
    }
}

/// A patch of the next coarser level.
fn parent(key: PatchKey) -> PatchKey {
    PatchKey { level: key.level + 1, x: key.x >> 1, y: key.y >> 1 }
}

impl Mesh {
    fn read(gpu: &Gpu, frame: &mut Frame, terrain: &mut Terrain, view: View, style: &Style) -> Self {
        let light = Light { to_sun: DVec3::new(-0.5, 0.5, 0.7).normalize(), haze_m: 30_000.0, haze_srgb: None };
        let prepared = frame.render(gpu, terrain, &view, style, &light);
        let vertices = frame.drawn_vertices(gpu, &prepared).unwrap().expect("one batch");
        let selection = &prepared.selection;
        let instances = selection.solid.iter().chain(&selection.with_holes);
        let camera_m = view.pose.position_m;
        let world_m = |at: &[f32; 4]| camera_m + DVec3::new(at[0].into(), at[1].into(), at[2].into());
        let patches = vertices.chunks_exact(SIDE * SIDE).zip(instances).map(|(vertices, instance)| Patch {
            instance: *instance,
            vertices_m: vertices.iter().map(world_m).collect(),
        });
        Self { view, patches: selection.leaves.iter().copied().zip(patches).collect(), late: prepared.tiles.late }
    }

    /// Planted: the same without morphing. Where a patch or an edge is on its way to a coarser level, it is there; an
    /// even vertex has not moved yet, so all that takes are vertices of the mesh itself.
    fn without_morphing(&self) -> Self {
        let mut mesh = self.clone();
        for patch in mesh.patches.values_mut() {
            let drawn = patch.vertices_m.clone();
            let [west, east, north, south] = patch.instance.edge_levels;
            for (i, j) in (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j))) {
                let last = SIDE - 1;
                let mut level = patch.instance.inner_level;
                for (is_there, edge) in [(i == 0, west), (i == last, east), (j == 0, north), (j == last, south)] {
                    level = if is_there { edge } else { level };
                }
                let shift = level.ceil() as usize;
                let on_level = |k: usize| k >> shift << shift;
                patch.vertices_m[j * SIDE + i] = drawn[on_level(j) * SIDE + on_level(i)];
            }
        }
        mesh
    }

    /// The height of the mesh at a place, and its normal.
    fn under(&self, warp: &Warp, place_m: DVec2) -> Option<(f64, DVec3)> {
        let grid = warp.grid_from_world(place_m);
        (-12..24_i32).find_map(|level| {
            let stride = f64::from(level).exp2();
            let at = grid / stride;
            let patch_of = |k: f64| (k / f64::from(PATCH_QUADS)).floor() as i64;
            let key = PatchKey { level, x: patch_of(at.x), y: patch_of(at.y) };
            let patch = self.patches.get(&key)?;
            let quad_of = |k: f64, patch: i64| {
                (k - patch as f64 * f64::from(PATCH_QUADS)).clamp(0.0, f64::from(PATCH_QUADS) - 0.5) as usize
            };
            let (i, j) = (quad_of(at.x, key.x), quad_of(at.y, key.y));
            // A vertex morphs to its left and up: a place lies in the quad that it would lie in, or in a later one.
            let near = (j..(j + 2).min(SIDE - 1)).flat_map(|j| (i..(i + 2).min(SIDE - 1)).map(move |i| (i, j)));
            let all = (0..SIDE - 1).flat_map(|j| (0..SIDE - 1).map(move |i| (i, j)));
            near.chain(all).find_map(|(i, j)| patch.quad_at(i, j, place_m))
        })
    }

    /// Pixels that a step at a place covers on the screen.
    fn px(&self, at_m: DVec3, step_m: DVec3) -> f64 {
        let way_m = at_m - self.view.pose.position_m;
        let ray = way_m.normalize();
        (step_m - ray * step_m.dot(ray)).length() * self.view.focal_px() / way_m.length()
    }

    fn is_in_view(&self, at_m: DVec3) -> bool {
        let View { pose, .. } = &self.view;
        let way_m = at_m - pose.position_m;
        let ahead_m = way_m.dot(pose.forward);
        let [wide, high] = SIZE_PX.map(|side| 0.5 * f64::from(side) / self.view.focal_px());
        ahead_m > 0.0 && way_m.dot(pose.right).abs() < wide * ahead_m && way_m.dot(pose.up).abs() < high * ahead_m
    }
}

/// The largest of the motions in pixels, with its patch and its place.
type Worst = Option<(f64, PatchKey, DVec3)>;

/// Motions between two frames, in pixels.
#[derive(Default)]
struct Motions {
    whole: Vec<f64>,
    across: Vec<f64>,
    in_place: Vec<f64>,
    /// Vertices in view of patches that were neither drawn, nor split, nor merged by one level.
    without_partner: usize,
    /// Of *whole*, *across*, *in place*.
    worst: [Worst; 3],
}

impl Motions {
    fn append(&mut self, mut other: Self) {
        self.whole.append(&mut other.whole);
        self.across.append(&mut other.across);
        self.in_place.append(&mut other.in_place);
        self.without_partner += other.without_partner;
        for (kind, worst) in other.worst.into_iter().enumerate() {
            if let Some((px, key, at_m)) = worst {
                self.note(kind, px, key, at_m);
            }
        }
    }

    fn note(&mut self, kind: usize, px: f64, key: PatchKey, at_m: DVec3) {
        if px > self.most(kind) {
            self.worst[kind] = Some((px, key, at_m));
        }
    }

    /// The largest of a kind.
    fn most(&self, kind: usize) -> f64 {
        self.worst[kind].map_or(0.0, |worst| worst.0)
    }

    /// A vertex was at `from_m` and is at `to_m`.
    fn pair(&mut self, after: &Mesh, key: PatchKey, from_m: DVec3, to_m: DVec3, normal: Option<DVec3>) {
        if let Some(normal) = normal.filter(|_| after.is_in_view(to_m)) {
            let step_m = to_m - from_m;
            self.whole.push(after.px(to_m, step_m));
            self.across.push(after.px(to_m, normal * step_m.dot(normal)));
            self.note(0, after.px(to_m, step_m), key, to_m);
            self.note(1, after.px(to_m, normal * step_m.dot(normal)), key, to_m);
        }
    }

    /// The mesh was at `z_m` where it is `at_m` now, or the other way round.
    fn in_place(&mut self, after: &Mesh, key: PatchKey, at_m: DVec3, z_m: f64, normal: DVec3) {
        let px = after.px(at_m, normal * normal.z * (at_m.z - z_m));
        self.in_place.push(px);
        self.note(2, px, key, at_m);
    }

    /// A line of a table.
    fn line(&mut self, name: &str) -> String {
        let of = |values: &mut Vec<f64>| {
            [0.5, 0.99, 0.999, 1.0].map(|part| format!("{:8.3}", quantile(values, part))).join(" ")
        };
        let (whole, across, in_place) = (of(&mut self.whole), of(&mut self.across), of(&mut self.in_place));
        let (count, lone) = (self.whole.len(), self.without_partner);
        format!("{name:24} | {whole} | {across} | {in_place} | {count} vertices, {lone} without partner")
    }
}

/// The motions of the patch `key` of the later mesh, as seen in that one.
fn motions_of(before: &Mesh, after: &Mesh, warp: &Warp, key: PatchKey) -> Motions {
    let mut motions = Motions::default();
    let patch = &after.patches[&key];
    let all = || (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j)));
    let mut pair = |from_m, to_m, normal| motions.pair(after, key, from_m, to_m, normal);
    // A vertex of a coarse patch that a vertex of one of its children is, or comes from.
    let coarse_of = |child: PatchKey, i: usize, j: usize| {
        let of = |patch: i64, k: usize| (patch.rem_euclid(2) as usize * (SIDE - 1) + (k & !1)) / 2;
        (of(child.x, i), of(child.y, j))
    };
    let children = (0..4).map(|k| PatchKey { level: key.level - 1, x: 2 * key.x + k % 2, y: 2 * key.y + k / 2 });
    let merged: Vec<PatchKey> = children.filter(|child| before.patches.contains_key(child)).collect();
    if let Some(old) = before.patches.get(&key) {
        all().for_each(|(i, j)| pair(old.at(i, j), patch.at(i, j), patch.normal(i, j)));
    } else if let Some(old) = before.patches.get(&parent(key)) {
        for (i, j) in all() {
            let (ci, cj) = coarse_of(key, i, j);
            pair(old.at(ci, cj), patch.at(i, j), patch.normal(i, j));
        }
    } else if !merged.is_empty() {
        for (child, (i, j)) in merged.iter().flat_map(|child| all().map(move |at| (child, at))) {
            let (ci, cj) = coarse_of(*child, i, j);
            pair(before.patches[child].at(i, j), patch.at(ci, cj), patch.normal(ci, cj));
        }
    } else {
        motions.without_partner += patch.vertices_m.iter().filter(|at| after.is_in_view(**at)).count();
    }
    for at_m in patch.vertices_m.iter().filter(|at| after.is_in_view(**at)) {
        if let Some((z_m, normal)) = before.under(warp, at_m.truncate()) {
            motions.in_place(after, key, *at_m, z_m, normal);
        }
    }
    motions
}

/// The motions between two frames.
fn motions(before: &Mesh, after: &Mesh, warp: &Warp) -> Motions {
    let mut keys: Vec<PatchKey> = after.patches.keys().copied().collect();
    keys.sort();
    let later: Vec<Motions> = keys.par_iter().map(|key| motions_of(before, after, warp, *key)).collect();
    let mut keys: Vec<PatchKey> = before.patches.keys().copied().collect();
    keys.sort();
    // Two meshes of triangles are farthest apart at a vertex of either, about.
    let earlier = keys.par_iter().map(|key| {
        let mut motions = Motions::default();
        for at_m in before.patches[key].vertices_m.iter().filter(|at| after.is_in_view(**at)) {
            if let Some((z_m, normal)) = after.under(warp, at_m.truncate()) {
                motions.in_place(after, *key, *at_m, z_m, normal);
            }
        }
        motions
    });
    let mut sum = Motions::default();
    earlier.collect::<Vec<_>>().into_iter().chain(later).for_each(|motions| sum.append(motions));
    sum
}

/// What a flight showed.
#[derive(Default)]
struct Flight {
    all: Motions,
    /// Pairs of frames in which *whole*, *across*, *in place* pass [`MOST_PX`] somewhere.
    frames_over: [usize; 3],
    /// Frames of which a part was coarser than its error allows.
    late: usize,
    /// Planted: each 30th frame with the one before it.
    seldom: Motions,
    /// Planted: no morphing.
    unmorphed: Motions,
}

/// Flies along `poses` and compares each frame with the one before.
fn fly(name: &str, gpu: &Gpu, terrain: &mut Terrain, poses: &[Pose], plants: bool) -> Flight {
    let style = Style::parse("plain", preset_text("plain").unwrap()).unwrap();
    let mut frame = Frame::new(gpu, Requirements::of(&style), SIZE_PX).unwrap();
    let warp = terrain.warp().clone();
    let view_of = |pose: Pose| View { pose, previous: pose, picture_px: SIZE_PX, part: Part::whole(SIZE_PX) };
    // A window that has been open for a while: after a jump nothing fades.
    let start = Instant::now();
    while terrain.options().loading == Loading::Stream && start.elapsed() < Duration::from_secs(30) {
        let rest = Mesh::read(gpu, &mut frame, terrain, view_of(poses[0]), &style);
        if !rest.late && start.elapsed() > Duration::from_secs(2) {
            break;
        }
    }
    // Compared when all are drawn: a window does not wait for a comparison either.
    let start = Instant::now();
    let meshes: Vec<Mesh> =
        poses.iter().map(|pose| Mesh::read(gpu, &mut frame, terrain, view_of(*pose), &style)).collect();
    let frame_ms = start.elapsed().as_secs_f64() * 1000.0 / poses.len() as f64;
    let mut flight = Flight { late: meshes.iter().filter(|mesh| mesh.late).count(), ..Flight::default() };
    for (number, pair) in meshes.windows(2).enumerate() {
        let moved = motions(&pair[0], &pair[1], &warp);
        for kind in 0..3 {
            flight.frames_over[kind] += usize::from(moved.most(kind) > MOST_PX);
        }
        flight.all.append(moved);
        if plants && number < 15 {
            flight.unmorphed.append(motions(&pair[0].without_morphing(), &pair[1].without_morphing(), &warp));
        }
    }
    if plants {
        for pair in meshes.iter().step_by(30).collect::<Vec<_>>().windows(2) {
            flight.seldom.append(motions(pair[0], pair[1], &warp));
        }
    }
    println!("{name}: {} frames of {frame_ms:.0} ms, {} late", meshes.len(), flight.late);
    println!("50 %, 99 %, 99.9 %, most | whole{:31} | across{:30} | in place", "", "");
    println!("{}", flight.all.line("px a frame"));
    if plants {
        println!("{}", flight.seldom.line("planted: 30 frames"));
        println!("{}", flight.unmorphed.line("planted: no morphing"));
    }
    println!("pairs of frames with more than {MOST_PX} px: {:?}", flight.frames_over);
    flight
}

impl Flight {
    /// What is promised, of all three motions.
    fn assert_nothing_pops(&self) {
        for (kind, name) in ["whole", "across", "in place"].into_iter().enumerate() {
            assert!(self.all.most(kind) <= MOST_PX, "{name}: {:?}", self.all.worst[kind]);
        }
        let (pairs, lone) = (self.all.whole.len(), self.all.without_partner);
        assert!(pairs > 1_000_000 && lone * 50 < pairs, "{pairs} pairs of vertices, {lone} without partner");
    }
}

fn pose_of(camera: &Camera) -> Pose {
    Pose {
        position_m: camera.position_m,
        forward: camera.forward(),
        right: camera.right(),
        up: camera.up(),
        fov_rad: camera.fov_deg.to_radians(),
    }
}

/// 300 m/s across rough land, low: 60 m above the highest ground within 300 m, smoothed.
fn across_rough_land(terrain: &Terrain, frames: usize) -> Vec<Pose> {
    let step_m = SPEED_M_PER_S / FPS;
    let way = DVec2::new(0.6, 0.8);
    let place = |frame: i64| DVec2::new(-2000.0, -2600.0) + way * (step_m * frame as f64);
    let ground_m = |frame: i64| terrain.height_m(place(frame)).unwrap();
    let highest_m = |frame: i64| (-30..=30).map(|beside| ground_m(frame + beside)).fold(f64::MIN, f64::max);
    let smooth_m = |frame: i64| (-20..=20).map(|beside| highest_m(frame + beside)).sum::<f64>() / 41.0 + 60.0;
    let camera = |frame: i64| Camera {
        position_m: place(frame).extend(smooth_m(frame)),
        height_above_ground: false,
        yaw_deg: way.x.atan2(way.y).to_degrees(),
        pitch_deg: -8.0,
        fov_deg: 58.0,
    };
    (0..frames as i64).map(|frame| pose_of(&camera(frame))).collect()
}

fn rough() -> Option<World> {
    World::new(grid_of(801, 783, SPACING_M, rough_height_m), 1.0)
}

#[test]
fn nothing_pops_over_rough_land() {
    let Some(mut world) = rough() else { return };
    let poses = across_rough_land(&world.terrain, 61);
    let flight = fly("rough land", &world.gpu, &mut world.terrain, &poses, true);
    flight.assert_nothing_pops();
    for planted in [&flight.seldom, &flight.unmorphed] {
        assert!((0..3).all(|kind| planted.most(kind) > MOST_PX), "planted: {:?}", planted.worst);
    }
}

/// The middle of the continent, as the scene of that name has it.
fn continent() -> Arc<dyn TileStore> {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("continent");
    Arc::new(ContinentStore::open(1, 2048, SPACING_M, Some(&cache), &Silent).unwrap())
}

/// Three seconds of the valley flight.
fn along_the_valley() -> Vec<Pose> {
    let path = CameraPath::read(Path::new("terrain/paths/valley.csv")).unwrap();
    (0..91).map(|frame| pose_of(&path.sample(30.0 + f64::from(frame) / FPS))).collect()
}

#[test]
fn nothing_pops_along_the_valley() {
    let Some(gpu) = gpu() else { return };
    let mut terrain = Terrain::new(&gpu, continent(), TerrainOptions::default()).unwrap();
    let flight = fly("valley", &gpu, &mut terrain, &along_the_valley(), true);
    flight.assert_nothing_pops();
    // Smooth land moves across itself by little whatever one does; its vertices tell.
    for planted in [&flight.seldom, &flight.unmorphed] {
        assert!(planted.most(0) > MOST_PX, "planted: {:?}", planted.worst);
    }
}

#[test]
fn nothing_pops_while_tiles_stream() {
    let Some(gpu) = gpu() else { return };
    // Tiles that come in time, and tiles that come too late and fade in.
    for delay_ms in [5, 1500] {
        let store = Bumpy::new(continent(), delay_ms, Box::new(|_, _| Fate::Comes));
        let options = TerrainOptions { loading: Loading::Stream, ..TerrainOptions::default() };
        let mut terrain = Terrain::new(&gpu, store, options).unwrap();
        let flight = fly(&format!("tiles of {delay_ms} ms"), &gpu, &mut terrain, &along_the_valley(), false);
        if delay_ms < 100 {
            flight.assert_nothing_pops();
        } else {
            // What moves by more comes from missing detail, and is told, not promised.
            assert!(flight.late > 0, "nothing came late");
        }
    }
}
