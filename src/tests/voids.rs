//! Tests filling of no-data holes: how exact it is, where it does not happen, and that nothing else changes.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::path::Path;
use std::sync::Arc;

use common::{grid_of, random, real_data};
use hachure::pyramid::bake::{BakeWork, bake_reader};
use hachure::pyramid::store::{Cancel, open_local_cog_with};
use hachure::pyramid::tile::is_void;
use hachure::pyramid::{self, BakeOptions, Pyramid, TileAddress, TileStore};
use hachure::source::mosaic::{MosaicReader, member_options};
use hachure::source::reader::GridReader;
use hachure::source::voids::{Filled, FilledSamples, filled};
use hachure::source::{HeightGrid, HeightReader, OpenOptions, Silent, VoidMode, Window, open_reader_with, read_all};

const SPACING_M: f64 = 30.0;

/// Height of hills and valleys of 2 to 4 km, with 900 m between the lowest and the highest point.
fn hills_m(x_m: f64, y_m: f64) -> f64 {
    let [x, y] = [x_m / 1000.0, y_m / 1000.0];
    900.0 + 260.0 * (2.1 * x + 0.7 * (1.3 * y).sin()).sin() + 180.0 * (1.7 * y - 0.6 * x).cos() + 30.0 * x
}

fn hills(width: u32, height: u32) -> HeightGrid {
    grid_of(width, height, SPACING_M, hills_m)
}

/// Returns the land with no-data where `is_void` returns true.
fn punched(grid: &HeightGrid, is_void: impl Fn(i64, i64) -> bool) -> HeightGrid {
    let mut grid = grid.clone();
    for (i, height_m) in grid.heights_m.iter_mut().enumerate() {
        let i = i as i64;
        if is_void(i % i64::from(grid.width), i / i64::from(grid.width)) {
            *height_m = f32::NAN;
        }
    }
    grid
}

fn reader(grid: &HeightGrid) -> Box<dyn HeightReader> {
    filled(Box::new(GridReader::new(grid.clone(), "a grid".into())))
}

fn whole(grid: &HeightGrid) -> Window {
    Window { x: 0, y: 0, width: grid.width, height: grid.height }
}

fn fill(grid: &HeightGrid) -> (Vec<f32>, FilledSamples) {
    let reader = reader(grid);
    reader.filled().unwrap().read_counted(whole(grid)).unwrap()
}

fn voids(heights_m: &[f32]) -> u64 {
    heights_m.iter().filter(|height| height.is_nan()).count() as u64
}

fn bits(heights_m: &[f32]) -> Vec<u32> {
    heights_m.iter().map(|height| height.to_bits()).collect()
}

/// Predicates for no-data in a disc, in a winding band, and in speckles.
fn disc(radius: i64) -> impl Fn(i64, i64) -> bool {
    move |x, y| (x - 150).pow(2) + (y - 150).pow(2) <= radius * radius
}

fn band(x: i64, y: i64) -> bool {
    (60..240).contains(&x) && (y - 150 - (40.0 * (x as f64 / 25.0).sin()) as i64).abs() <= 9
}

fn speckles(x: i64, y: i64) -> bool {
    x.min(y) > 1 && x.max(y) < 298 && random(x / 2, y / 3) < 0.08
}

/// Returns the largest error of filled samples, as a share of the relief.
fn largest_error(grid: &HeightGrid, holes: &HeightGrid, heights_m: &[f32]) -> f64 {
    let all = || grid.heights_m.iter();
    let relief_m = all().fold(f32::MIN, |a, b| a.max(*b)) - all().fold(f32::MAX, |a, b| a.min(*b));
    let errors = all().zip(&holes.heights_m).zip(heights_m).filter(|((_, hole), _)| hole.is_nan());
    errors.map(|((truth, _), found)| f64::from((truth - found).abs() / relief_m)).fold(0.0, f64::max)
}

/// Returns the largest change of the slope angle from one step to the next, in radians: across the rims of holes, and
/// anywhere in the true land.
fn turns_rad(grid: &HeightGrid, holes: &HeightGrid, heights_m: &[f32]) -> [f64; 2] {
    let width = grid.width as usize;
    let turn = |heights_m: &[f32], at: [usize; 3]| {
        let [a, b, c] = at.map(|i| f64::from(heights_m[i]));
        (((c - b) / SPACING_M).atan() - ((b - a) / SPACING_M).atan()).abs()
    };
    let mut largest = [0.0f64; 2];
    for i in width..heights_m.len() - width {
        for step in [1, width] {
            let at = [i - step, i, i + step];
            let there = at.iter().filter(|&&i| holes.heights_m[i].is_nan()).count();
            let row_ends = step == 1 && (i % width == 0 || i % width == width - 1);
            if !row_ends {
                largest[1] = largest[1].max(turn(&grid.heights_m, at));
                if there == 1 || there == 2 {
                    largest[0] = largest[0].max(turn(heights_m, at));
                }
            }
        }
    }
    largest
}

#[test]
fn smooth_land_is_restored_with_its_slopes() {
    let grid = hills(301, 301);
    let cases: [(&str, HeightGrid, f64); 5] = [
        ("speckles", punched(&grid, speckles), 0.001),
        ("a disc of 8", punched(&grid, disc(8)), 0.003),
        ("a disc of 16", punched(&grid, disc(16)), 0.01),
        ("a disc of 31", punched(&grid, disc(31)), 0.06),
        ("a band of 19", punched(&grid, band), 0.03),
    ];
    for (name, holes, most) in cases {
        let (heights_m, counts) = fill(&holes);
        assert_eq!(
            (voids(&heights_m), counts),
            (0, FilledSamples { voids: voids(&holes.heights_m), spikes: 0 }),
            "{name}"
        );
        let kept = holes.heights_m.iter().zip(&heights_m).filter(|(hole, _)| !hole.is_nan());
        assert!(kept.clone().all(|(a, b)| a.to_bits() == b.to_bits()), "{name}: measured heights must not change");
        let error = largest_error(&grid, &holes, &heights_m);
        let [rim, land] = turns_rad(&grid, &holes, &heights_m);
        println!(
            "{name}: error {:.2} % of the relief, bend at the rim {:.2} of the land's largest",
            100.0 * error,
            rim / land
        );
        assert!(error < most, "{name}: {error}");
        assert!(rim < 1.75 * land, "{name}: {rim} {land}");

        // Planted: holes filled with the mean of all heights.
        let mean_m = heights_m.iter().sum::<f32>() / heights_m.len() as f32;
        let lid: Vec<f32> = holes.heights_m.iter().map(|it| if it.is_nan() { mean_m } else { *it }).collect();
        assert!(largest_error(&grid, &holes, &lid) > most, "{name}: {}", largest_error(&grid, &holes, &lid));
        assert!(turns_rad(&grid, &holes, &lid)[0] > 1.75 * land, "{name}");
    }
}

/// Control: a membrane meets heights but not slopes, so the same holes filled by Laplace's equation have a crease.
#[test]
fn a_membrane_would_be_found_to_crease() {
    let grid = hills(301, 301);
    let holes = punched(&grid, disc(16));
    let (mut heights_m, _) = fill(&holes);
    let inside: Vec<usize> = (0..heights_m.len()).filter(|&i| holes.heights_m[i].is_nan()).collect();
    for _ in 0..3000 {
        for &i in &inside {
            heights_m[i] = (heights_m[i - 1] + heights_m[i + 1] + heights_m[i - 301] + heights_m[i + 301]) / 4.0;
        }
    }
    let [rim, land] = turns_rad(&grid, &holes, &heights_m);
    println!("a membrane: bend at the rim {:.2} of the land's largest", rim / land);
    assert!(rim > 1.75 * land, "{rim} {land}");
}

/// Returns rough land with holes of all kinds: speckles, lakes, holes at the border, and one that is too wide to fill.
fn ragged() -> HeightGrid {
    let grid = grid_of(640, 560, SPACING_M, |x_m, y_m| {
        hills_m(x_m, y_m) + 40.0 * random((x_m / SPACING_M) as i64, (y_m / SPACING_M) as i64)
    });
    let blob = |x: i64, y: i64| {
        let near = |i: i64, j: i64| {
            let (u, v) = (random(i, j), random(j + 900, i));
            let (cx, cy) = (40.0 * (i as f64 + u), 40.0 * (j as f64 + v));
            let radius = 22.0 * random(i + 77, j) - 6.0;
            (x as f64 - cx).hypot(y as f64 - cy) < radius
        };
        (-1..2).any(|i| (-1..2).any(|j| near(x / 40 + i, y / 40 + j)))
    };
    punched(&grid, |x, y| blob(x, y) || random(x, y) < 0.01 || (x - 420).abs() < 40 && (y - 300).abs() < 35)
}

#[test]
fn windows_of_any_size_agree() {
    let grid = ragged();
    let (expected_m, counts) = fill(&grid);
    let left = voids(&expected_m);
    assert!(counts.voids > 20_000 && left > 5000, "{counts:?} {left}");
    let reader = reader(&grid);
    let sizes: &[[u32; 2]] = if common::full() {
        &[[640, 1], [97, 83], [256, 256], [1, 1], [90, 560]]
    } else {
        &[[640, 1], [256, 256], [1, 1]]
    };
    // Single samples and rows are many, so only one in this many is read.
    let steps = if common::full() { [1997, 61] } else { [9973, 183] };
    for &[width, height] in sizes {
        let mut sum = FilledSamples::default();
        for y in (0..grid.height).step_by(height as usize) {
            for x in (0..grid.width).step_by(width as usize) {
                if width.min(height) == 1 && (x * 31 + y) % steps[usize::from(height != width)] != 0 {
                    continue;
                }
                let window = Window { x, y, width: width.min(grid.width - x), height: height.min(grid.height - y) };
                let (found_m, found) = reader.filled().unwrap().read_counted(window).unwrap();
                sum.voids += found.voids;
                sum.spikes += found.spikes;
                for (i, found_m) in found_m.iter().enumerate() {
                    let (column, row) = (x + i as u32 % window.width, y + i as u32 / window.width);
                    let expected_m = expected_m[(row * grid.width + column) as usize];
                    assert_eq!(found_m.to_bits(), expected_m.to_bits(), "{width} × {height}: {column}, {row}");
                }
            }
        }
        assert!(width.min(height) == 1 || sum == counts, "{sum:?}");
    }
}

#[test]
fn what_is_large_or_open_stays_a_hole() {
    let grid = hills(420, 420);
    let within = |x: i64, y: i64, width: i64, height: i64| {
        move |column: i64, row: i64| (x..x + width).contains(&column) && (y..y + height).contains(&row)
    };
    let left = |holes: &HeightGrid| voids(&fill(holes).0);
    for (name, square, stays) in [
        ("the widest", within(100, 100, 64, 64), false),
        ("too wide", within(100, 100, 65, 65), true),
        ("a band of the largest extent", within(50, 100, 256, 20), false),
        ("too long", within(50, 100, 257, 20), true),
        ("one sample on the border", within(0, 77, 1, 1), true),
        ("one sample inside the border", within(1, 77, 1, 1), false),
        ("the last row", within(70, 419, 9, 1), true),
    ] {
        let holes = punched(&grid, square);
        let expected = if stays { voids(&holes.heights_m) } else { 0 };
        assert_eq!(left(&holes), expected, "{name}");
    }
    // A rotated raster with a no-data collar, and a lake inside: only the lake is filled.
    let collar = |x: i64, y: i64| (x - 210).abs() + (y - 210).abs() > 200;
    let lake = |x: i64, y: i64| (x - 190).pow(2) + (y - 230).pow(2) < 200;
    let both = punched(&grid, |x, y| collar(x, y) || lake(x, y));
    let only = punched(&grid, collar);
    assert_eq!(left(&both), voids(&only.heights_m));
    assert!(fill(&both).0.iter().zip(&only.heights_m).all(|(a, b)| a.is_nan() == b.is_nan()));
}

#[test]
fn spikes_go_and_summits_stay() {
    // A cone of 45 degrees with its summit next to no-data, a cliff of 200 m along no-data, and level land.
    let land = |x_m: f64, y_m: f64| {
        let cone = 900.0 - (x_m + 1500.0).hypot(y_m);
        let cliff = if x_m > 1500.0 { 200.0 } else { 0.0 };
        cone.max(cliff)
    };
    let grid = grid_of(201, 201, SPACING_M, land);
    let is_hole = |x: i64, y: i64| (53..56).contains(&x) && (99..102).contains(&y) || x == 148 && y % 9 == 3 && y < 190;
    let holes = punched(&grid, |x, y| is_hole(x, y) && y > 0);
    assert_eq!(fill(&holes).1.spikes, 0, "the summit and the cliff must not count as spikes");
    // A summit that is a hole is filled beyond all samples, and the statistics say so.
    let no_summit = punched(&grid, |x, y| (48..53).contains(&x) && (98..103).contains(&y));
    let found = hachure::source::statistics(&*reader(&no_summit), Path::new("a.tif"), &Silent).unwrap();
    let highest_m = fill(&no_summit).0.into_iter().fold(f32::NAN, f32::max);
    assert!(highest_m > found.max_m + 5.0, "{highest_m} m, {found:?}");
    assert_eq!(found.filled_m, Some([found.min_m, highest_m]));
    let whole = hachure::source::statistics(&*reader(&grid), Path::new("a.tif"), &Silent).unwrap();
    assert_eq!(whole.filled_m, None);
    let mut spiked = holes.clone();
    let at = |x: usize, y: usize| y * 201 + x;
    // Spikes next to no-data: up, down, and by less than half the spacing; and one far from all no-data.
    for (x, y, over_m) in [(144, 21, 60.0), (145, 40, -60.0), (144, 57, 12.0), (100, 190, 60.0)] {
        spiked.heights_m[at(x, y)] += over_m;
    }
    let (heights_m, counts) = fill(&spiked);
    assert_eq!(counts, FilledSamples { voids: voids(&spiked.heights_m), spikes: 2 });
    assert!(heights_m[at(144, 21)].abs() < 1.0 && heights_m[at(145, 40)].abs() < 1.0, "these spikes must be removed");
    assert_eq!((heights_m[at(144, 57)], heights_m[at(100, 190)]), (12.0, 60.0), "these heights must stay");
    assert_eq!(heights_m[at(50, 100)], spiked.heights_m[at(50, 100)]);
}

fn baked(folder: &Path, name: &str, reader: &dyn HeightReader, chunk_levels: u32) -> Vec<u8> {
    let out = folder.join(name);
    let work = BakeWork { chunk_levels, ..BakeWork::default() };
    bake_reader(reader, &out, &BakeOptions::default(), &work, &Silent).unwrap();
    std::fs::read(out).unwrap()
}

#[test]
fn land_without_voids_is_the_same_and_so_are_holes() {
    let folder = tempfile::tempdir().unwrap();
    let bake = |name, reader: &dyn HeightReader| baked(folder.path(), name, reader, 4);
    let grid = hills(600, 500);
    let bare = GridReader::new(grid.clone(), "a grid".into());
    let before = bake("before.tif", &bare);
    assert!(before == bake("after.tif", &*reader(&grid)), "without holes the bake must not change");
    let tiles = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(tiles("before.tif.tiles").len(), tiles("after.tif.tiles").len());
    let holes = punched(&grid, disc(8));
    assert!(before != bake("holes.tif", &*reader(&holes)), "filled holes must change the bake");

    // By default a reader fills holes; with `holes` it returns the heights in the file.
    let file = folder.path().join("holes.tif");
    bake("holes.tif", &GridReader::new(holes.clone(), "holes".into()));
    let open = |voids| {
        let reader = open_reader_with(&file, &OpenOptions { voids, ..OpenOptions::default() }).unwrap();
        (bits(&read_all(&*reader, &file, &Silent).unwrap().heights_m), reader.identity())
    };
    assert_eq!(open(VoidMode::Holes).0, bits(&holes.heights_m));
    assert_eq!(open(VoidMode::Fill).0, bits(&fill(&holes).0), "a whole file must be filled like windows of it");
    assert_ne!(open(VoidMode::Fill).1, open(VoidMode::Holes).1, "the two modes must have different pyramids");
}

#[test]
fn a_bake_by_windows_is_that_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let grid = HeightGrid { heights_m: fill(&ragged()).0, ..ragged() };
    let whole = baked(folder.path(), "whole.tif", &GridReader::new(grid, "whole".into()), 4);
    let chunks = baked(folder.path(), "chunks.tif", &*reader(&ragged()), 1);
    assert!(whole == chunks);
}

#[test]
fn a_cog_that_is_drawn_as_it_is_shows_what_a_baked_one_shows() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    baked(folder.path(), "holes.tif", &GridReader::new(ragged(), "holes".into()), 4);
    baked(folder.path(), "filled.tif", &*reader(&ragged()), 4);
    std::fs::copy(path("holes.tif"), path("bare.tif")).unwrap();
    let expected: Arc<dyn TileStore> = Arc::new(Pyramid::open(&path("filled.tif")).unwrap());
    let store = |voids| open_local_cog_with(&path("bare.tif"), voids).unwrap().unwrap();
    let load = |store: &Arc<dyn TileStore>, level, x, y| {
        store.clone().fetch(TileAddress { level, x, y }, &Cancel::default()).unwrap()().unwrap().tile.samples
    };
    let (as_filled, as_holes) = (store(VoidMode::Fill), store(VoidMode::Holes));
    let (mut compared, mut holes_differ) = (0, 0);
    // Tiles along a side of the grid; in the fast tier those that are whole.
    let (side, least) = if common::full() { (3, [300_000, 20_000]) } else { (2, [200_000, 13_000]) };
    for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
        let [found, expected, holes] = [&as_filled, &expected, &as_holes].map(|store| load(store, 0, x, y));
        for ((found, expected), holes) in found.iter().zip(&expected).zip(&holes) {
            assert_eq!(is_void(*found), is_void(*expected), "{x} {y}");
            assert!(is_void(*found) || found.to_bits() == expected.to_bits(), "{x} {y}");
            compared += u32::from(!is_void(*found));
            holes_differ += u32::from(is_void(*holes) && !is_void(*found));
        }
    }
    assert!(compared > least[0] && holes_differ > least[1], "{compared} {holes_differ}");
    // An overview is filled from its own samples, on land that is rough by 40 m, so it is only nearly the same.
    let [found, expected] = [&as_filled, &expected].map(|store| load(store, 1, 0, 0));
    let land = |sample: &f32| !is_void(*sample);
    let both: Vec<f32> =
        found.iter().zip(&expected).filter(|(a, b)| land(a) && land(b)).map(|(a, b)| (a - b).abs()).collect();
    let apart = found.iter().zip(&expected).filter(|(a, b)| land(a) != land(b)).count();
    let mean_m = both.iter().sum::<f32>() / both.len() as f32;
    println!("level 1: {apart} of {} samples are land in only one of them; mean difference {mean_m} m", found.len());
    assert!(mean_m < 3.0 && apart < found.len() / 100, "{mean_m} {apart}");
}

#[test]
fn a_void_of_one_file_is_land_in_another() {
    let folder = tempfile::tempdir().unwrap();
    let land = hills(200, 200);
    let holes = punched(&land, |x, y| (20..30).contains(&x) && (20..30).contains(&y));
    let raised = HeightGrid { heights_m: land.heights_m.iter().map(|height| height + 50.0).collect(), ..land.clone() };
    let member =
        |grid: &HeightGrid| Box::new(GridReader::new(grid.clone(), "a member".into())) as Box<dyn HeightReader>;
    let mosaic = filled(Box::new(MosaicReader::new(vec![member(&holes), member(&raised)]).unwrap()));
    let heights_m = mosaic.read(whole(&land)).unwrap();
    assert_eq!(heights_m[25 * 200 + 25], raised.heights_m[25 * 200 + 25]);

    // For drawing, holes of members side by side are filled, but not those of members that overlap.
    let path = |name: &str| folder.path().join(name);
    let mut adjacent = land.clone();
    adjacent.georeference.crs_from_grid[0] += 199.0 * SPACING_M;
    for (name, grid) in [("a.tif", &holes), ("b.tif", &raised), ("c.tif", &adjacent)] {
        pyramid::bake(grid, &path(name), &BakeOptions::default(), &Silent).unwrap();
    }
    let options = OpenOptions { voids: VoidMode::Fill, ..OpenOptions::default() };
    let modes = |names: &[&str]| {
        let files: Vec<_> = names.iter().map(|name| path(name)).collect();
        member_options(&files, &options).iter().map(|options| options.voids).collect::<Vec<_>>()
    };
    assert_eq!(modes(&["a.tif"]), [VoidMode::Fill]);
    assert_eq!(modes(&["a.tif", "c.tif"]), [VoidMode::Fill; 2]);
    assert_eq!(modes(&["a.tif", "b.tif"]), [VoidMode::Holes; 2]);
    assert_eq!(modes(&["a.tif", "nothing.tif"]), [VoidMode::Holes; 2]);
}

/// Tests real holes on real land: the no-data of one DEM is cut out of the land of another, and filled heights are
/// compared with the measured ones.
#[test]
fn real_holes_in_real_land() {
    let (Some(alps), Some(rainier)) =
        (real_data("dem/geotiff/N46E008_alps.tif"), real_data("dem/geotiff/mt_rainier_90m.tif"))
    else {
        return;
    };
    let open =
        |path: &Path| read_all(&*open_reader_with(path, &OpenOptions::default()).unwrap(), path, &Silent).unwrap();
    let (mask, land) = (open(&alps), open(&rainier));
    assert_eq!(mask.heights_m.len(), land.heights_m.len());
    let width = i64::from(land.width);
    let holes = punched(&land, |x, y| mask.heights_m[(y * width + x) as usize].is_nan());
    let (heights_m, counts) = fill(&holes);
    let compared = heights_m.iter().zip(&land.heights_m).zip(&holes.heights_m);
    let compared = compared.filter(|((found, truth), hole)| hole.is_nan() && !found.is_nan() && !truth.is_nan());
    let errors_m: Vec<f64> = compared.map(|((found, truth), _)| f64::from((found - truth).abs())).collect();
    let rms_m = (errors_m.iter().map(|error| error * error).sum::<f64>() / errors_m.len() as f64).sqrt();
    println!("{counts:?}: {rms_m:.1} m root mean square over {} samples", errors_m.len());
    assert!(counts.voids > 90_000 && rms_m < 90.0, "{counts:?} {rms_m}");
    // The land with its own no-data hardly changes: its summits are not taken for spikes.
    let own = fill(&land).1;
    assert!(own.spikes * 100_000 < land.heights_m.len() as u64, "{own:?}");
}

/// Tests what a filled reader reports without reading.
#[test]
fn what_is_known_stays_known() {
    struct Sparse(GridReader<HeightGrid>);
    impl HeightReader for Sparse {
        fn size(&self) -> [u32; 2] {
            self.0.size()
        }
        fn georeference(&self) -> &hachure::source::georeference::Georeference {
            self.0.georeference()
        }
        fn read(&self, window: Window) -> Result<Vec<f32>, hachure::source::SourceError> {
            self.0.read(window)
        }
        fn block(&self) -> [u32; 2] {
            [64, 64]
        }
        fn known_m(&self, _: Window) -> Option<f32> {
            Some(f32::NAN)
        }
        fn identity(&self) -> String {
            "sparse".into()
        }
    }
    let reader = filled(Box::new(Sparse(GridReader::new(hills(300, 300), "a grid".into()))));
    let known = |width| reader.known_m(Window { x: 10, y: 10, width, height: 80 });
    assert!(known(64).is_none(), "a hole of this width may be filled, so nothing is known");
    assert!(known(65).is_some_and(f32::is_nan), "a hole of this width must stay no-data");
    assert!(reader.filled().map(Filled::bare).is_some());
}
