//! The procedural continent: its levels agree with one another, its cut-outs with the whole, and its paths stay above
//! the ground.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use hachure::pyramid::store::{ContinentStore, Ground, derive};
use hachure::pyramid::surface::tile_height::{height_in_tile, tile_at};
use hachure::pyramid::{BakeOptions, Pyramid, TileAddress, TileStore, bake};
use hachure::scene::path::CameraPath;
use hachure::scene::{Scene, World};
use hachure::source::continent::{BASE_SAMPLES, Continent, Exemplar, SIZE_SAMPLES};
use hachure::source::{Silent, Window, procedural};

use crate::tests::common::{between_runs, full};

/// Opens the continent as it ships, with its cache kept between runs.
fn store(size: u32) -> ContinentStore {
    ContinentStore::open(1, size, 10.0, Some(&between_runs("built-in-land")), &Silent).unwrap()
}

/// Returns the whole continent, which tests share.
fn whole() -> Arc<ContinentStore> {
    static WHOLE: OnceLock<Arc<ContinentStore>> = OnceLock::new();
    Arc::clone(WHOLE.get_or_init(|| Arc::new(store(SIZE_SAMPLES))))
}

/// Returns land that is quick to generate: a mountain range across the middle. In the fast tier, its exemplar is
/// interpolated between a quarter of the samples along a side.
fn land() -> &'static Continent {
    static LAND: OnceLock<Continent> = OnceLock::new();
    LAND.get_or_init(|| {
        let (size, finer): (usize, usize) = if full() { (1536, 1) } else { (385, 4) };
        let grown = procedural::generate_sized(3, size as u32, 12.0 * finer as f64, &Silent);
        let grown_m = |column: usize, row: usize| grown.heights_m[row.min(size - 1) * size + column.min(size - 1)];
        let between = |from: f32, to: f32, at: usize| from + (to - from) * (at % finer) as f32 / finer as f32;
        let exemplar = (0..1536 * 1536).map(|i| {
            let (x, y) = (i % 1536, i / 1536);
            let line_m = |row: usize| between(grown_m(x / finer, row), grown_m(x / finer + 1, row), x);
            between(line_m(y / finer), line_m(y / finer + 1), y)
        });
        let exemplar: Vec<f32> = exemplar.collect();
        let side = BASE_SAMPLES as usize;
        let base = (0..side * side).map(|i| {
            let (x, y) = ((i % side) as f32, (i / side) as f32);
            let range = (-((x - y) / 60.0).powi(2)).exp();
            300.0 + 2500.0 * range * (1.0 + 0.3 * (0.31 * x).sin() * (0.27 * y).cos())
        });
        Continent::new(3, base.collect(), Exemplar::new(1536, &exemplar))
    })
}

fn rms(values: impl Iterator<Item = f32>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += f64::from(value).powi(2);
        count += 1.0;
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Returns how far a level is from the averages of the finer one, relative to the level's own small relief. The level
/// is shifted by `shift` samples.
fn unlike(land: &Continent, level: u32, x: u32, y: u32, shift: u32) -> f64 {
    let side = 200;
    let fine = land.heights_m(level - 1, Window { x: 2 * x, y: 2 * y, width: 2 * side, height: 2 * side });
    let coarse = land.heights_m(level, Window { x: x + shift, y, width: side, height: side });
    let at = |column: u32, row: u32| fine[(row * 2 * side + column) as usize];
    let difference = (0..side * side).map(|i| {
        let (column, row) = (2 * (i % side), 2 * (i / side));
        let mean = at(column, row) + at(column + 1, row) + at(column, row + 1) + at(column + 1, row + 1);
        coarse[i as usize] - 0.25 * mean
    });
    let steps = (0..side * (side - 1)).map(|i| coarse[(i + side) as usize] - coarse[i as usize]);
    rms(difference) / rms(steps)
}

#[test]
fn a_level_is_near_the_average_of_the_finer_one() {
    for level in 1..=7_u32 {
        let middle = (SIZE_SAMPLES / 2) >> level;
        let far = (SIZE_SAMPLES >> level) - 210;
        let places = [(middle, middle), (middle - 90, middle + 40), (far, far)];
        let places = if full() { &places[..] } else { &places[level as usize % 3..][..1] };
        for &(x, y) in places {
            let (here, planted) = (unlike(land(), level, x, y, 0), unlike(land(), level, x, y, 1));
            println!("level {level} at {x} {y}: {here:.4} of a step; shifted by a sample {planted:.3}");
            assert!(
                here < 0.08,
                "level {level} at {x} {y}: differs from the average of the finer level by {here} of a step"
            );
            assert!(planted > 0.3, "a level shifted by one sample must differ by more than 0.3: {planted}");
        }
    }
}

#[test]
fn a_place_has_one_height_from_every_window() {
    let end = SIZE_SAMPLES - 300;
    for (x, y) in [(163_000, 163_100), (0, 0), (end, end), (end, 7)] {
        let whole = land().heights_m(0, Window { x, y, width: 300, height: 290 });
        let part = land().heights_m(0, Window { x: x + 101, y: y + 37, width: 57, height: 91 });
        for (i, height) in part.iter().enumerate() {
            let (column, row) = (i % 57 + 101, i / 57 + 37);
            assert_eq!(
                height.to_bits(),
                whole[row * 300 + column].to_bits(),
                "the height at column {column}, row {row} depends on the window"
            );
        }
        // Precision holds far from the origin too: neighbours differ, and only a little.
        let steps: Vec<f32> = whole.windows(2).map(|pair| (pair[0] - pair[1]).abs()).collect();
        let still = steps.iter().filter(|&&step| step == 0.0).count();
        assert!(still < steps.len() / 50, "{still} of {} neighbours have equal heights", steps.len());
    }
}

#[test]
fn a_cut_is_the_same_land() {
    // All land is cut alike, and the continent as it ships takes long to grow.
    let open = |size: u32| match full() {
        true => store(size),
        false => ContinentStore::over(land().clone(), 3, size, 10.0).unwrap(),
    };
    let whole = open(SIZE_SAMPLES);
    let cut = open(2048);
    assert_eq!((cut.levels()[0].width, whole.levels()[0].width), (2048, SIZE_SAMPLES));
    for level in 0..cut.levels().len() as u32 {
        let first = ((SIZE_SAMPLES - 2048) / 2) >> level;
        let window = Window { x: 3, y: 5, width: 200, height: 100 };
        let moved = Window { x: window.x + first, y: window.y + first, ..window };
        assert_eq!(cut.heights_m(level, window), whole.heights_m(level, moved));
    }
    let [x0, step, _, y0, _, _] = whole.georeference().crs_from_grid;
    assert_eq!((x0, step, y0), (-1_638_395.0, 10.0, 1_638_395.0));
    assert_eq!(
        open(1000).levels()[0].width,
        1000,
        "the continent is larger than requested, though its levels allow the size"
    );
}

#[test]
fn tiles_are_quick_and_fit_their_neighbours() {
    let store = whole();
    let mut slowest = 0.0_f64;
    for (level, size) in (0..).zip(store.levels().to_vec()) {
        let (x, y) = (size.tiles_x() / 2, size.tiles_y() / 2);
        let start = Instant::now();
        let tile = store.clone().load(TileAddress { level, x, y }).unwrap();
        let spent_ms = start.elapsed().as_secs_f64() * 1e3;
        slowest = slowest.max(spent_ms);
        println!("level {level}: {spent_ms:.1} ms, error {:.2} m", tile.statistics.error_m);
        let found = [tile.statistics.min_m + tile.statistics.error_m, tile.statistics.max_m - tile.statistics.error_m];
        assert!(found[0] >= store.range_m()[0] && found[1] <= store.range_m()[1], "{found:?} {:?}", store.range_m());
        if x + 1 < size.tiles_x() {
            let east = store.clone().load(TileAddress { level, x: x + 1, y }).unwrap();
            for row in 0..260 {
                for border in 0..4 {
                    assert_eq!(tile.tile.samples[row * 260 + 256 + border], east.tile.samples[row * 260 + border]);
                }
            }
        }
    }
    let beyond = TileAddress { level: 0, x: store.levels()[0].tiles_x(), y: 0 };
    assert!(!store.has_tile(beyond) && store.clone().load(beyond).is_err());
    // The bound leaves a factor of ten for a busy machine.
    assert!(slowest < 300.0, "the slowest tile took {slowest} ms");
}

#[test]
fn estimates_hold_against_a_bake() {
    let folder = tempfile::tempdir().unwrap();
    let store = Arc::new(store(1024));
    let out = folder.path().join("cut.tif");
    bake(&store.grid(0), &out, &BakeOptions::default(), &Silent).unwrap();
    let pyramid = Arc::new(Pyramid::open(&out).unwrap());
    let (mut safe, mut count) = (0, 0);
    for (level, size) in (1..).zip(&store.levels()[1..]) {
        for i in 0..size.tiles_x() * size.tiles_y() {
            let address = TileAddress { level, x: i % size.tiles_x(), y: i / size.tiles_x() };
            let estimate = store.clone().load(address).unwrap();
            let measured = pyramid.clone().load(address).unwrap();
            println!("{address:?}: {} for {}", estimate.statistics.error_m, measured.statistics.error_m);
            for (estimate, measured) in estimate.patches.patches().iter().zip(measured.patches.patches()) {
                count += 1;
                safe += i32::from(estimate.mesh_error_m >= measured.mesh_error_m);
            }
            let ratio = estimate.statistics.error_m / measured.statistics.error_m;
            assert!(
                (0.9..8.0).contains(&ratio),
                "{address:?}: the estimate is {ratio} times the measured error, expected 0.9 to 8"
            );
        }
    }
    assert!(safe * 100 >= count * 95, "only {safe} of {count} patches have an estimate that is not too small");
}

#[test]
fn coarse_tiles_know_of_the_relief_that_they_do_not_show() {
    let store = whole();
    let ground = Ground::new(Arc::clone(&store) as Arc<dyn TileStore>);
    let level = 8;
    let middle = f64::from(SIZE_SAMPLES) / 2.0;
    let address = tile_at(store.levels(), level, middle, middle).unwrap();
    let loaded = Arc::clone(&store).load(address).unwrap();
    let mut worst_m = 0.0_f64;
    for i in 0..24 {
        // Ridges and valleys around points 40 km apart; each point has 8 × 8 samples, because a single one would miss
        // summits.
        let (x, y) = (middle + 4000.0 * f64::from(i % 5 - 2), middle + 4000.0 * f64::from(i / 5 - 2));
        for k in 0..64 {
            let (column, row) = (x + 60.0 * f64::from(k % 8), y + 60.0 * f64::from(k / 8));
            let coarse_m = height_in_tile(store.levels(), address, &loaded.tile, column, row).unwrap();
            worst_m = worst_m.max((ground.height_m(column, row).unwrap() - coarse_m).abs());
        }
    }
    let estimate_m = f64::from(derive(store.levels(), address, loaded.tile.clone()).statistics.error_m);
    let error_m = f64::from(loaded.statistics.error_m);
    println!("lost {worst_m:.0} m, bound {error_m:.0} m, estimate from the samples {estimate_m:.0} m");
    assert!(worst_m <= error_m && worst_m > 150.0);
    // Planted error: an estimate from the samples alone is too small.
    assert!(estimate_m < worst_m);
}

#[test]
fn the_valley_flight_stays_above_the_ground_and_inside() {
    let store = store(2048);
    let grid = store.grid(0);
    let path = CameraPath::read(Path::new("terrain/paths/valley.csv")).unwrap();
    assert_eq!(path.duration_s(), 60.0);
    let half = (f64::from(grid.width) - 1.0) / 2.0;
    let (mut lowest, mut last) = (f64::INFINITY, None);
    for camera in path.frames(20.0) {
        let at = camera.position_m;
        assert!(!camera.height_above_ground && at.x.abs() < 9_500.0 && at.y.abs() < 9_500.0, "{at}");
        let (column, row) = ((half + at.x / 10.0) as usize, (half - at.y / 10.0) as usize);
        for i in 0..9 {
            let ground = grid.heights_m[(row + i / 3) * grid.width as usize + column + i % 3];
            lowest = lowest.min(at.z - f64::from(ground));
        }
        if let Some(last) = last {
            let speed = (at - last) as glam::DVec3;
            assert!((280.0..330.0).contains(&(speed.truncate().length() * 20.0)), "{}", speed.length() * 20.0);
        }
        last = Some(at);
    }
    println!("the lowest point is {lowest:.0} m above the ground");
    assert!(lowest > 60.0, "the flight comes within {lowest} m of the ground");
}

#[test]
fn the_teleport_jumps_every_five_seconds() {
    let path = CameraPath::read(Path::new("terrain/paths/teleport.csv")).unwrap();
    assert_eq!(path.duration_s(), 60.0);
    for jump in 1..12 {
        let time_s = 5.0 * f64::from(jump);
        let (before, after) = (path.sample(time_s - 1e-6), path.sample(time_s));
        let jumped_m = before.position_m.distance(after.position_m);
        assert!((4e5..1.6e6).contains(&jumped_m), "{jumped_m}");
        assert!(
            before.position_m.distance(path.sample(time_s - 0.1).position_m) < 500.0,
            "the camera swings before a jump"
        );
        assert!(after.position_m.abs().max_element() < 1.6e6);
    }
}

#[test]
fn scenes_say_continent() {
    let world = |text: &str| Scene::parse(Path::new("x.toml"), &format!("[world]\n{text}\n")).map(|scene| scene.world);
    let whole = World::Continent { seed: 1, size_samples: SIZE_SAMPLES, spacing_m: 10.0 };
    assert_eq!(world("continent = {}").unwrap(), whole);
    assert_eq!(Scene::read(Path::new("terrain/continent.toml")).unwrap().world, whole);
    let small = World::Continent { seed: 1, size_samples: 2048, spacing_m: 10.0 };
    assert_eq!(Scene::read(Path::new("terrain/continent_small.toml")).unwrap().world, small);
    assert!(matches!(world("dem = [\"a.tif\", \"b.tif\"]").unwrap(), World::Files(files) if files.len() == 2));
    for wrong in
        ["continent = { size_samples = 5 }", "continent = { spacing_m = 0 }", "dem = []", "continent = {}\ndem = \"a\""]
    {
        let message = world(wrong).unwrap_err().to_string();
        assert!(message.starts_with("x.toml") && !message.contains('\n'), "{message}");
    }
}
