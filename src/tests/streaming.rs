//! Tests streaming of tiles: a frame never waits, there are never holes, settled frames equal those of a file, memory
//! stays within its caps, and failed tiles are replaced by their parents.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::sync::Arc;
use std::time::{Duration, Instant};

use common::shot::{Shot, shoot};
use common::stores::{Accident, Bumpy, Fate};
use common::{World, grid_of, random, rough_height_m};
use glam::DVec3;
use hachure::frame::Renderer;
use hachure::pyramid::store::Altered;
use hachure::pyramid::tile::TILE_STRIDE;
use hachure::pyramid::{LoadedTile, TileAddress, TileStore};
use hachure::scene::view::View;
use hachure::tiles::Terrain;
use hachure::tiles::cache::{LEAST, TILE_BYTES, TileCache};
use hachure::tiles::needed::{Land, LevelRule, TileBounds, needed};
use hachure::tiles::terrain::{Loading, TerrainOptions};
use proptest::prelude::*;

const SIZE_PX: [u32; 2] = [160, 90];
const VIEW: &str = "-2000,-3000,+300,30,-12,60";

/// Returns a world whose tiles arrive with delays and accidents; every frame is drawn as in a window.
fn bumpy(delay_ms: u64, memory_bytes: u64, accident: Accident) -> Option<(World, Arc<Bumpy>)> {
    let mut world = World::new(grid_of(1401, 1290, 20.0, rough_height_m), 1.0)?;
    let store = Bumpy::new(Arc::clone(world.surfaces.terrain.store()), delay_ms, accident);
    let options =
        TerrainOptions { loading: Loading::Stream, tile_memory_bytes: memory_bytes, ..TerrainOptions::default() };
    world.surfaces = Terrain::new(&world.gpu, Arc::clone(&store) as Arc<dyn TileStore>, options).unwrap().into();
    Some((world, store))
}

const ROOM: u64 = 64 << 20;

fn smooth() -> Accident {
    Box::new(|_, _| Fate::Comes)
}

/// Counts sky pixels whose four neighbours are surface.
fn pinholes(shot: &Shot) -> usize {
    let is_ground = |pixel: usize, step| shot.neighbour(pixel, step).is_some_and(|neighbour| !shot.is_sky(neighbour));
    let sides = [[1, 0], [-1, 0], [0, 1], [0, -1]];
    (0..shot.depth_m.len()).filter(|&i| shot.is_sky(i) && sides.iter().all(|step| is_ground(i, *step))).count()
}

/// Draws until no frame is late, or the time is up, and calls `each` with every picture. Returns whether it settled.
fn settle(world: &mut World, renderer: &mut Option<Renderer>, view: &str, mut each: impl FnMut(&World, &Shot)) -> bool {
    let pose = world.pose(view);
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(30) {
        let shot = shoot(world, renderer, pose, SIZE_PX);
        each(world, &shot);
        if !shot.report.late {
            return true;
        }
    }
    false
}

/// Returns the picture of a file.
fn awaited(world: &World, view: &str) -> Shot {
    let mut still = World::new(world.grid.clone(), 1.0).unwrap();
    let pose = still.pose(view);
    shoot(&mut still, &mut None, pose, SIZE_PX)
}

/// Returns the largest distance between the positions of two pictures, in pixels.
fn apart_px(a: &Shot, b: &Shot) -> f64 {
    let px = |i: usize| match (a.is_sky(i), b.is_sky(i)) {
        (true, true) => 0.0,
        (false, false) => (a.position_m[i] - b.position_m[i]).length() * a.focal_px() / b.position_m[i].length(),
        _ => f64::INFINITY,
    };
    (0..a.depth_m.len()).map(px).fold(0.0, f64::max)
}

#[test]
fn a_slow_store_stops_no_frame() {
    let Some((mut world, store)) = bumpy(300, ROOM, smooth()) else { return };
    let expected = awaited(&world, VIEW);
    let mut renderer = None;
    let (mut frames, mut late, mut slowest_ms) = (0, 0, 0.0_f64);
    let mut last = None;
    let settled = settle(&mut world, &mut renderer, VIEW, |world, shot| {
        assert_eq!(pinholes(shot), 0, "frame {frames}");
        frames += 1;
        late += usize::from(shot.report.late);
        slowest_ms = slowest_ms.max(shot.report.prepare_ms);
        let counts = world.surfaces.terrain.tile_counts();
        assert!(counts.gpu_bytes <= ROOM && counts.cache_bytes <= ROOM);
        last = Some(shot.position_m.clone());
    });
    let fetches = store.fetches.load(std::sync::atomic::Ordering::Relaxed);
    println!("{frames} frames, {late} late, {fetches} tiles of 300 ms, slowest frame thread {slowest_ms:.1} ms");
    assert!(settled && late >= 2, "{frames} frames, {late} late");
    // Every tile takes 300 ms, so a frame that waited for one would take longer.
    assert!(slowest_ms < 200.0, "{slowest_ms} ms");

    let pose = world.pose(VIEW);
    let shot = shoot(&mut world, &mut renderer, pose, SIZE_PX);
    assert_eq!(apart_px(&shot, &expected), 0.0, "the settled frame must equal the picture of a file");
    assert_eq!(last.unwrap(), shot.position_m, "at rest nothing may move");
}

#[test]
fn wrong_heights_are_noticed() {
    // Planted: half of the tiles of the finest level are raised by 5 m.
    let raised: Accident = Box::new(|tile, _| match (tile.level, (tile.x + tile.y) % 2) {
        (0, 0) => Fate::ComesRaised(5.0),
        _ => Fate::Comes,
    });
    let Some((mut world, _)) = bumpy(0, ROOM, raised) else { return };
    let expected = awaited(&world, VIEW);
    let mut last = None;
    settle(&mut world, &mut None, VIEW, |_, shot| last = Some(shot.position_m.clone()));
    let moved = last.unwrap().iter().zip(&expected.position_m).filter(|(a, b)| (**a - **b).length() > 1.0).count();
    assert!(moved > 100, "planted heights were not detected: only {moved} pixels moved");
}

#[test]
fn failures_are_tried_again_and_stood_in_for() {
    // Half of the tiles fail at first; those of one corner of the finest level always fail.
    let accident: Accident = Box::new(|tile, before| {
        let is_lost = tile.level == 0 && tile.x <= 2 && tile.y >= 3;
        let is_unlucky = before == 0 && random(i64::from(tile.x + 97 * tile.level), i64::from(tile.y)) < 0.5;
        if is_lost || is_unlucky { Fate::Fails } else { Fate::Comes }
    });
    let Some((mut world, _)) = bumpy(1, ROOM, accident) else { return };
    let expected = awaited(&world, VIEW);
    // This is the pose in the world without accidents, since the ground under the camera is one of the tiles that
    // always fail.
    let pose = expected.view.pose;
    let mut renderer = None;
    let start = Instant::now();
    let mut shot = shoot(&mut world, &mut renderer, pose, SIZE_PX);
    while start.elapsed() < Duration::from_secs(20) && (shot.report.tiles_failed == 0 || shot.report.tiles_pending > 0)
    {
        shot = shoot(&mut world, &mut renderer, pose, SIZE_PX);
        assert_eq!(pinholes(&shot), 0);
    }
    println!("{} failed, apart {:.2} px", shot.report.tiles_failed, apart_px(&shot, &expected));
    assert!(shot.report.tiles_failed > 0 && shot.report.tiles_pending == 0 && shot.report.late);
    // Parents replace failed tiles, so the picture is near the truth, but does not equal it.
    let apart = apart_px(&shot, &expected);
    assert!(apart > 0.0, "{apart}");
    let off = (0..shot.depth_m.len()).filter(|&i| !shot.is_sky(i) && !expected.is_sky(i));
    let far = off.filter(|&i| (shot.position_m[i] - expected.position_m[i]).length() > 200.0).count();
    assert!(far < 100, "{far} pixels are far from their position");
}

#[test]
fn memory_keeps_its_cap() {
    // Room for five of about forty tiles.
    let room = 5 * TILE_BYTES;
    let Some((mut world, _)) = bumpy(1, room, smooth()) else { return };
    let mut renderer = None;
    let mut missed = 0;
    for view in [VIEW, "3000,2000,+100,200,-10,60", "0,0,+2000,90,-40,50", "-9000,-9000,+50,45,-2,40"] {
        let pose = world.pose(view);
        for _ in 0..12 {
            let shot = shoot(&mut world, &mut renderer, pose, SIZE_PX);
            let counts = world.surfaces.terrain.tile_counts();
            assert!(counts.gpu_bytes <= room && counts.cache_bytes <= room, "{counts:?}");
            assert_eq!(pinholes(&shot), 0);
            missed += shot.report.tiles_missing;
        }
    }
    assert!(missed > 0, "missing room for tiles was not counted");
}

#[test]
fn a_view_that_turns_away_takes_its_requests_back() {
    // The delay is longer than frames take on a busy machine.
    let Some((mut world, store)) = bumpy(300, ROOM, smooth()) else { return };
    let mut renderer = None;
    for turn in 0..10 {
        let pose = world.pose(&format!("{},{},+100,{},-10,30", -9000 + 2000 * turn, 5000 - 1000 * turn, 97 * turn));
        shoot(&mut world, &mut renderer, pose, SIZE_PX);
    }
    let cancelled = world.surfaces.terrain.tile_counts().cancelled;
    println!("{cancelled} cancelled, {} fetched", store.fetches.load(std::sync::atomic::Ordering::Relaxed));
    assert!(cancelled > 0);
}

#[test]
fn an_exaggerated_land_is_that_much_higher() {
    let Some((world, _)) = bumpy(0, ROOM, smooth()) else { return };
    let store = Arc::clone(world.surfaces.terrain.store());
    let address = TileAddress { level: 1, x: 1, y: 1 };
    let load = |factor: f64| Altered::exaggerated(Arc::clone(&store), factor).load(address).unwrap();
    let (plain, twice) = (load(1.0), load(2.0));
    // The lowest bit of a height marks no-data; twice the height must have the same mark.
    let is_twice = |a: &LoadedTile, b: &LoadedTile| {
        let heights = a.tile.samples.iter().zip(&b.tile.samples);
        let patches = a.patches.patches().iter().zip(b.patches.patches());
        b.statistics.error_m == 2.0 * a.statistics.error_m
            && b.statistics.corner_errors_m == a.statistics.corner_errors_m.map(|error_m| 2.0 * error_m)
            && heights
                .into_iter()
                .all(|(a, b)| (b - 2.0 * a).abs() <= 1e-6 * a.abs() && a.to_bits() & 1 == b.to_bits() & 1)
            && patches.into_iter().all(|(a, b)| b.mesh_error_m == 2.0 * a.mesh_error_m)
    };
    assert!(is_twice(&plain, &twice));
    assert!(!is_twice(&plain, &plain) && !is_twice(&plain, &load(2.01)), "planted");
}

#[test]
fn a_rounded_land_is_within_the_error() {
    const ERROR_M: f64 = 0.75;
    let Some((world, _)) = bumpy(0, ROOM, smooth()) else { return };
    let store = Arc::clone(world.surfaces.terrain.store());
    let address = TileAddress { level: 1, x: 1, y: 1 };
    let load = |error_m: f64| Altered::rounded(Arc::clone(&store), error_m).load(address).unwrap();
    let (plain, rounded) = (load(0.0), load(ERROR_M));
    let is_within = |a: &LoadedTile, b: &LoadedTile, error_m: f32| {
        let mut heights = a.tile.samples.iter().zip(&b.tile.samples);
        (b.statistics.error_m - a.statistics.error_m - error_m).abs() < 1e-4
            && heights.all(|(a, b)| (b - a).abs() <= 1.0001 * error_m && a.to_bits() & 1 == b.to_bits() & 1)
    };
    assert!(is_within(&plain, &rounded, ERROR_M as f32));
    assert!(!is_within(&plain, &rounded, 0.5 * ERROR_M as f32), "planted: a smaller error");
    // Heights are multiples of one step, so a tile has few different ones.
    let steps = |tile: &LoadedTile| {
        let of = |height_m: &f32| (height_m / (2.0 * ERROR_M as f32)).round() as i64;
        tile.tile.samples.iter().map(of).collect::<std::collections::BTreeSet<_>>().len()
    };
    let different = |tile: &LoadedTile| {
        tile.tile.samples.iter().map(|height_m| height_m.to_bits()).collect::<std::collections::BTreeSet<_>>().len()
    };
    // The lowest bit of a height marks no-data.
    assert!(different(&rounded) <= 2 * steps(&rounded) && different(&plain) > 4 * steps(&plain));
}

fn tile(seed: u32) -> Arc<LoadedTile> {
    use hachure::pyramid::surface::statistics::{PatchPage, TileStatistics, Voids};
    use hachure::pyramid::tile::Tile;
    let samples = vec![seed as f32; (TILE_STRIDE * TILE_STRIDE) as usize];
    let statistics =
        TileStatistics { min_m: 0.0, max_m: 1.0, error_m: 0.0, corner_errors_m: [0.0; 4], voids: Voids::None };
    let patches = PatchPage::new(vec![PatchPage::NOTHING; 256]);
    Arc::new(LoadedTile::new(Tile { samples }, statistics, patches))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn the_cache_never_grows_beyond_its_cap(most in 1_u64..28, uses in prop::collection::vec((0_u32..60, any::<bool>()), 1..120)) {
        let mut cache = TileCache::new(most * TILE_BYTES);
        for (x, inserts) in &uses {
            cache.begin_pass();
            let address = TileAddress { level: 0, x: *x, y: 0 };
            if *inserts {
                cache.insert(address, tile(*x));
                // The newest tile is never evicted, unless there is room for nothing else.
                prop_assert!(cache.peek(address).is_some());
            } else if let Some(found) = cache.get(address) {
                prop_assert_eq!(found.tile.samples[0], *x as f32);
            }
            prop_assert!(cache.bytes() <= most.max(LEAST as u64) * TILE_BYTES);
        }
    }
}

#[test]
fn a_tile_used_in_this_pass_outlives_those_of_earlier_passes() {
    let at = |x| TileAddress { level: 0, x, y: 0 };
    let mut cache = TileCache::new(0);
    cache.insert(at(0), tile(0));
    for x in 1..100 {
        // All passes may be of one frame: one that waits for its tiles.
        cache.begin_pass();
        assert!(cache.get(at(0)).is_some(), "evicted by tile {x}");
        cache.insert(at(x), tile(x));
    }
}

#[test]
fn what_a_view_needs_has_no_gap_and_keeps_the_bound() {
    let Some((world, _)) = bumpy(0, ROOM, smooth()) else { return };
    let store = Arc::clone(world.surfaces.terrain.store());
    let mut known = std::collections::HashMap::new();
    for (level, size) in store.levels().iter().enumerate() {
        for (x, y) in (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| (x, y))) {
            let address = TileAddress { level: level as u32, x, y };
            known.insert(address, Arc::clone(&store).load(address).unwrap().statistics);
        }
    }
    let land = Land { store: &*store, grid_projection: world.surfaces.terrain.grid_projection() };
    let mut checked = 0;
    for i in 0..60 {
        let [u, v, w] = [0, 1, 2].map(|k| random(i, k));
        let view = format!(
            "{},{},+{},{},{},50",
            26000.0 * (u - 0.5),
            24000.0 * (v - 0.5),
            2000.0 * w * w + 2.0,
            360.0 * u,
            -60.0 * v
        );
        let pose = world.pose(&view);
        let view = View::whole(pose, pose, SIZE_PX);
        let rule = |error_px| LevelRule {
            camera_m: pose.position_m,
            frusta: vec![view.frustum()],
            focal_px: view.focal_px(),
            error_px,
            earth_curvature: Default::default(),
            margin_m: 0.0,
        };
        let list = |error_px| needed(&land, &mut TileBounds::default(), |tile| known.get(&tile), &rule(error_px), 0.0);
        let tiles = list(0.5);
        let chosen: std::collections::HashSet<TileAddress> = tiles.iter().map(|tile| tile.address).collect();
        assert_eq!(chosen.len(), tiles.len(), "the list contains a tile twice");
        let mut too_coarse = |chosen: &std::collections::HashSet<TileAddress>| {
            let mut found = 0;
            for j in 0..400 {
                // A point of the land in view, and the finest tile there.
                let (column, row) = (random(i, 3 * j + 10) * 1400.0, random(i, 3 * j + 11) * 1289.0);
                let place = world.surfaces.terrain.grid_projection().world_from_grid(glam::DVec2::new(column, row));
                let Some(height_m) = world.surfaces.terrain.height_m(place) else { continue };
                let from_eye: DVec3 = place.extend(height_m) - pose.position_m;
                let clip = [pose.right, pose.up, pose.forward].map(|axis| axis.dot(from_eye));
                let seen = clip[2] > 0.0
                    && clip[0].abs() / clip[2] < 80.0 / view.focal_px()
                    && clip[1].abs() / clip[2] < 45.0 / view.focal_px();
                if !seen {
                    continue;
                }
                let at = |level: u32| {
                    hachure::pyramid::surface::tile_height::tile_at(store.levels(), level, column, row).unwrap()
                };
                let level = (0..store.levels().len() as u32).find(|level| chosen.contains(&at(*level))).unwrap();
                let pixel_m = from_eye.length() / view.focal_px();
                let error_px = f64::from(known[&at(level)].error_m) / pixel_m;
                found += usize::from(level > 0 && error_px > 0.5);
                checked += 1;
            }
            found
        };
        assert_eq!(too_coarse(&chosen), 0, "{pose:?}");
        for tile in &tiles {
            let TileAddress { level, x, y } = tile.address;
            let parent = TileAddress { level: level + 1, x: x / 2, y: y / 2 };
            assert!(level as usize == store.levels().len() - 1 || chosen.contains(&parent), "{tile:?} has no parent");
            assert!(tile.urgency > 0.0);
        }
        if i == 7 {
            // Planted: tiles for fifty times the error exceed the bound.
            let coarse = list(25.0).iter().map(|tile| tile.address).collect();
            assert!(too_coarse(&coarse) > 0);
        }
    }
    println!("{checked} points");
    assert!(checked > 500, "{checked}");
}
