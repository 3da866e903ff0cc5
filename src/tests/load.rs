//! Tests that pictures do not depend on load: whatever order tiles arrive in, and whatever else the machine does, a
//! file is bit-identical.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;
use crate::tests::helpers::styles::of_outlines;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use common::stores::{Accident, Bumpy, Fate, Shuffled};
use common::{grid_of, pose_of, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::frame::{Light, Renderer};
use hachure::gpu::Gpu;
use hachure::gpu::readback::read_buffer;
use hachure::lines::strokes::samples::Sample;
use hachure::lines::strokes::{COUNTS, SEGMENTS, Segment, StrokeCounts};
use hachure::picture::{self, PictureRequest};
use hachure::pyramid::store::{Ground, MosaicStore};
use hachure::pyramid::surface::statistics::TileStatistics;
use hachure::pyramid::{self, BakeOptions, Pyramid, TileAddress, TileStore};
use hachure::scene::camera::Camera;
use hachure::scene::view::{Pose, View};
use hachure::source::{HeightGrid, Silent, WorldMapping};
use hachure::style::{Style, names};
use hachure::surface::edges::{EDGES, Edge};
use hachure::tiles::Terrain;
use hachure::tiles::atlas::SLOT_BYTES;
use hachure::tiles::earth_curvature::EarthCurvature;
use hachure::tiles::grid_projection::GridProjection;
use hachure::tiles::needed::{LevelRule, TileBounds, needed};
use hachure::tiles::terrain::TerrainOptions;

const SIZE_PX: [u32; 2] = [96, 54];
const ROOM: u64 = 64 << 20;

fn bake(grid: &HeightGrid, path: &Path) -> Arc<dyn TileStore> {
    pyramid::bake(grid, path, &BakeOptions::default(), &Silent).unwrap();
    Arc::new(Pyramid::open(path).unwrap())
}

type Land = (&'static str, Arc<dyn TileStore>);

/// Bakes a land with measured errors.
fn measured(folder: &Path) -> Land {
    ("measured", bake(&grid_of(1401, 1290, 20.0, rough_height_m), &folder.join("land.tif")))
}

/// Returns the measured land, the same without a sidecar file of errors, and a mosaic of two members.
fn lands(folder: &Path) -> [Land; 3] {
    let measured = measured(folder);
    std::fs::copy(folder.join("land.tif"), folder.join("bare.tif")).unwrap();
    let estimated = pyramid::store::open_local_cog(&folder.join("bare.tif")).unwrap().unwrap();
    let coarse = bake(&grid_of(520, 500, 40.0, rough_height_m), &folder.join("coarse.tif"));
    let fine = bake(&grid_of(700, 640, 10.0, rough_height_m), &folder.join("fine.tif"));
    let mosaic = Arc::new(MosaicStore::new(vec![fine, coarse]).unwrap());
    [measured, ("estimated", estimated), ("mosaic", mosaic)]
}

/// Loads a style; in the fast tier without water and streams, whose maps of all the tiles take longest.
fn style(name: &str) -> Style {
    let style = Style::load(name).unwrap();
    if is_long() { style } else { of_outlines(style) }
}

/// Draws views of a land one after the other, as for a file, and returns the bits of all pixels of each.
struct Easel {
    gpu: Gpu,
    style: Style,
    renderer: Option<Renderer>,
}

impl Easel {
    fn new(name: &str) -> Option<Self> {
        Some(Self { gpu: common::gpu()?, style: style(name), renderer: None })
    }

    fn take_up(&mut self, name: &str) {
        self.style = style(name);
        self.renderer = None;
    }

    fn draw(&mut self, store: &Arc<dyn TileStore>, memory_bytes: u64, poses: &[Pose]) -> Vec<Vec<[u32; 4]>> {
        let options = TerrainOptions { tile_memory_bytes: memory_bytes, ..TerrainOptions::default() };
        let mut surfaces = Terrain::new(&self.gpu, Arc::clone(store), options).unwrap().into();
        let light =
            Light { to_sun: DVec3::new(-0.5, 0.5, 0.3).normalize(), haze_m: 30_000.0, haze_srgb: None, focus: None };
        if let Some(renderer) = &mut self.renderer {
            renderer.forget();
        }
        let mut previous = poses[0];
        poses
            .iter()
            .map(|pose| {
                let still = PictureRequest::still(*pose, SIZE_PX, &self.style, light);
                let request = PictureRequest { previous: std::mem::replace(&mut previous, *pose), ..still };
                let mut bits = Vec::new();
                picture::render(&self.gpu, &mut self.renderer, &mut surfaces, &request, |band| {
                    bits.extend(band.picture.iter().map(|texel| texel.map(f32::to_bits)));
                    Ok::<_, std::convert::Infallible>(())
                })
                .unwrap();
                bits
            })
            .collect()
    }
}

fn poses(store: &Arc<dyn TileStore>, views: &[&str]) -> Vec<Pose> {
    let ground = Ground::new(Arc::clone(store));
    let size = store.levels()[0];
    let mapping = WorldMapping::new(store.georeference(), size.width, size.height).unwrap();
    let pose = |view: &&str| {
        let camera: Camera = view.parse().unwrap();
        pose_of(&camera.on_ground(|x, y| {
            let grid = mapping.grid_from_world(DVec2::new(x, y));
            ground.height_m(grid.x, grid.y).unwrap_or(f64::from(store.range_m()[1]))
        }))
    };
    views.iter().map(pose).collect()
}

/// Counts pixels that differ.
fn apart(a: &[[u32; 4]], b: &[[u32; 4]]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Draws with one tile delayed to be the last, for up to `most` different tiles in turn. Returns how many drawings
/// differ from the one without delays.
fn differing_orders(easel: &mut Easel, land: &Land, memory_bytes: u64, views: &[&str], most: usize) -> usize {
    let (name, inner) = land;
    let poses = poses(inner, views);
    let first = Shuffled::new(Arc::clone(inner), 0, None);
    let expected = easel.draw(&(Arc::clone(&first) as Arc<dyn TileStore>), memory_bytes, &poses);
    let tiles = first.fetched();
    let count = tiles.len().min(most);
    let mut differing = 0;
    for i in 0..count {
        let late = tiles[tiles.len() - 1 - i * tiles.len() / count];
        let store: Arc<dyn TileStore> = Shuffled::new(Arc::clone(inner), 1 + i as u64, Some(late));
        let drawn = easel.draw(&store, memory_bytes, &poses);
        let pixels: Vec<usize> = drawn.iter().zip(&expected).map(|(a, b)| apart(a, b)).collect();
        if pixels.iter().any(|pixels| *pixels > 0) {
            println!("{name}, {}: with {late:?} last {pixels:?} pixels differ", easel.style.name);
            differing += 1;
        }
    }
    println!("{name}, {}: {differing} of {count} orders differ; {} tiles", easel.style.name, tiles.len());
    differing
}

/// Cameras of a flight; the ground under the camera is not in the picture.
const FLIGHT: [&str; 4] = [
    "-2000,-3000,+300,30,-12,60",
    "-1990,-2950,+280,33,-11,60",
    "-1980,-2900,+260,36,-10,60",
    "-1900,-2500,+200,50,-4,60",
];

/// Returns whether all presets are drawn, in more orders, which takes minutes.
fn is_long() -> bool {
    std::env::var_os("HACHURE_LARGE").is_some()
}

#[test]
fn any_order_of_tiles_gives_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let lands = lands(folder.path());
    let Some(mut easel) = Easel::new("plain") else { return };
    let mut differing = 0;
    for land in &lands {
        let most = if is_long() {
            100
        } else if common::full() {
            16
        } else {
            3
        };
        differing += differing_orders(&mut easel, land, ROOM, &FLIGHT[..1], most);
        differing += differing_orders(&mut easel, land, ROOM, &FLIGHT[3..], most);
    }
    let styles: Vec<&str> = if is_long() { names() } else { vec!["pencil"] };
    for style in styles {
        easel.take_up(style);
        let most = if is_long() { 24 } else { 2 };
        differing += differing_orders(&mut easel, &lands[0], ROOM, &FLIGHT[3..], most);
    }
    assert_eq!(differing, 0);
}

/// Memory for fewer tiles than the views of the flight need.
const TIGHT: u64 = 20 * SLOT_BYTES;

#[test]
fn too_little_memory_gives_one_coarser_picture() {
    let folder = tempfile::tempdir().unwrap();
    let land = measured(folder.path());
    let Some(mut easel) = Easel::new("lsa") else { return };
    // In each view, different tiles are loaded by chance when the error is raised.
    let (views, orders) = if common::full() { (&[0, 1, 2, 3][..], 4) } else { (&[3][..], 2) };
    let of_view = |i: &usize| differing_orders(&mut easel, &land, TIGHT, &FLIGHT[*i..=*i], orders);
    let differing: usize = views.iter().map(of_view).sum();
    assert_eq!(differing, 0);
    // The tiles of earlier frames are still there, and make no difference either.
    let step = if common::full() { 1 } else { 3 };
    let flight: Vec<Pose> = poses(&land.1, &FLIGHT).into_iter().step_by(step).collect();
    let together = easel.draw(&land.1, TIGHT, &flight);
    let apart_px: Vec<usize> = flight
        .iter()
        .zip(&together)
        .map(|(pose, drawn)| apart(&easel.draw(&land.1, TIGHT, &[*pose])[0], drawn))
        .collect();
    assert!(apart_px.iter().all(|apart_px| *apart_px == 0), "{apart_px:?}");
    let ample = easel.draw(&land.1, ROOM, &flight[..1]);
    assert!(apart(&together[0], &ample[0]) > 0, "the memory is not too little");
}

#[test]
fn a_tile_that_is_another_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let land = measured(folder.path());
    let Some(mut easel) = Easel::new("plain") else { return };
    let poses = poses(&land.1, &FLIGHT[..1]);
    let expected = easel.draw(&land.1, ROOM, &poses);
    // Planted: one tile is raised by ten centimetres.
    let raised: Accident = Box::new(|tile, _| match tile {
        TileAddress { level: 0, x: 2, y: 2 } => Fate::ComesRaised(0.1),
        _ => Fate::Comes,
    });
    let store: Arc<dyn TileStore> = Bumpy::new(Arc::clone(&land.1), 0, raised);
    let pixels = apart(&easel.draw(&store, ROOM, &poses)[0], &expected[0]);
    println!("{pixels} pixels differ");
    assert!(pixels > 0);
}

#[test]
fn what_the_last_tile_wants_is_missed_where_it_is_not_asked_for() {
    // Planted: the tiles that are needed by a view that does not know the statistics of one of its tiles. If the
    // statistics of no tile requested further tiles, the tests of orders above would test nothing.
    let folder = tempfile::tempdir().unwrap();
    let (_, store) = measured(folder.path());
    let size = store.levels()[0];
    let mapping = WorldMapping::new(store.georeference(), size.width, size.height).unwrap();
    let grid_projection = GridProjection::fit(&mapping, size.width, size.height);
    let pose = poses(&store, &FLIGHT[..1])[0];
    let view = View::whole(pose, pose, SIZE_PX);
    let earth_curvature = EarthCurvature { inverse_radius: 0.0, camera_z_m: pose.position_m.z, lowest_m: 0.0 };
    let rule = LevelRule {
        camera_m: pose.position_m,
        frusta: vec![view.frustum()],
        focal_px: view.focal_px(),
        error_px: 0.5,
        earth_curvature,
        margin_m: 0.0,
    };
    let mut all: HashMap<TileAddress, TileStatistics> = HashMap::new();
    for (level, size) in (0..).zip(store.levels()) {
        for (x, y) in (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| (x, y))) {
            let address = TileAddress { level, x, y };
            all.insert(address, Arc::clone(&store).load(address).unwrap().statistics);
        }
    }
    let find = |without: Option<TileAddress>| {
        let known = |tile| all.get(&tile).filter(|_| Some(tile) != without);
        let mut places = TileBounds::default();
        let found = needed(
            &hachure::tiles::needed::Land { store: &*store, grid_projection: &grid_projection },
            &mut places,
            known,
            &rule,
            0.0,
        );
        found.into_iter().map(|tile| tile.address).collect::<Vec<_>>()
    };
    let expected = find(None);
    let missed = expected.iter().filter(|tile| find(Some(**tile)).len() < expected.len()).count();
    println!("{missed} of {} tiles request others", expected.len());
    assert!(missed > 0);
}

/// Returns the stroke lists in their order: edges, segments, samples.
fn lists(easel: &Easel) -> (Vec<Edge>, Vec<Segment>, Vec<Sample>) {
    let strokes = easel.renderer.as_ref().and_then(Renderer::strokes).unwrap();
    let raw = |kind| strokes.buffer(kind).unwrap().raw;
    let counts: StrokeCounts = read_buffer(&easel.gpu, &raw(&COUNTS), 1).unwrap()[0];
    let edges = read_buffer(&easel.gpu, &raw(&EDGES), counts.edges as usize).unwrap();
    let segments = read_buffer(&easel.gpu, &raw(&SEGMENTS), counts.segments as usize).unwrap();
    (edges, segments, strokes.samples().read(&easel.gpu).unwrap().1)
}

#[test]
fn films_of_strokes_are_the_same_from_run_to_run() {
    let folder = tempfile::tempdir().unwrap();
    let land = measured(folder.path());
    let Some(mut easel) = Easel::new("pen") else { return };
    let (views, runs) = if is_long() {
        (&FLIGHT[..], 40)
    } else if common::full() {
        (&FLIGHT[..], 2)
    } else {
        (&FLIGHT[2..], 1)
    };
    for style in if is_long() { &["pen", "strokes", "pencil", "brush"][..] } else { &["pen"] } {
        easel.take_up(style);
        let poses = poses(&land.1, views);
        let expected = easel.draw(&land.1, ROOM, &poses);
        let (edges, segments, samples) = lists(&easel);
        assert!(edges.len() > 500 && segments.len() > 100 && samples.len() > 200, "{} {}", edges.len(), segments.len());
        for run in 0..runs {
            let store: Arc<dyn TileStore> = Shuffled::new(Arc::clone(&land.1), run, None);
            let drawn = easel.draw(&store, ROOM, &poses);
            let found = lists(&easel);
            assert!(found.0 == edges, "{style}, run {run}: edges are in another order");
            assert!(found.1 == segments, "{style}, run {run}: segments are in another order");
            assert!(found.2 == samples, "{style}, run {run}: samples differ");
            let pixels: Vec<usize> = drawn.iter().zip(&expected).map(|(a, b)| apart(a, b)).collect();
            assert!(pixels.iter().all(|pixels| *pixels == 0), "{style}, run {run}: {pixels:?} pixels differ");
        }
        // Planted: two swapped segments.
        let mut swapped = segments.clone();
        swapped.swap(0, 1);
        assert!(swapped != segments);
    }
}
