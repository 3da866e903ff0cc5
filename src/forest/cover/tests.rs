#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "tests damage their scratch files, and say what they skip"
)]

use std::path::PathBuf;

use geotiff_writer::GeoTiffBuilder;
use glam::{DVec2, Vec2Swizzles};
use ndarray::Array2;
use png::{BitDepth, ColorType};
use proj4rs::Proj;

use super::scratch::{Dem, Scratch, builder};
use super::*;
use crate::source::georeference::Crs;
use crate::source::open_reader;
use crate::tests::common::full;

const WGS84: &str = "+proj=longlat +ellps=WGS84 +no_defs";
const UTM_10: &str = "+proj=utm +zone=10 +ellps=WGS84 +units=m +no_defs";

fn mask(path: PathBuf) -> CoverFiles {
    CoverFiles { mask: Some(path), ..CoverFiles::default() }
}

fn canopy(path: PathBuf) -> CoverFiles {
    CoverFiles { canopy_height: Some(path), ..CoverFiles::default() }
}

/// A land cover with the classes 41, 42, 43, whose densities are 1, 0.5, 0.25.
fn land(path: PathBuf) -> CoverFiles {
    let class = |class, density| CoverClass { class, density, shares: vec![1.0] };
    let classes = vec![class(41, 1.0), class(42, 0.5), class(43, 0.25)];
    CoverFiles { land_cover: Some(path), classes, ..CoverFiles::default() }
}

/// A pattern of the three classes that no exchange of axes maps to itself; `by` is the size of its fields.
fn class_of(at: DVec2, by: f64) -> u8 {
    let (x, y) = ((at.x / by).floor() as i64, (at.y / (1.4 * by)).floor() as i64);
    41 + ((x + 2 * (y / 2) + (x / 3) * y).rem_euclid(3)) as u8
}

/// Transforms a position between reference systems.
fn projected(from: &Proj, to: &Proj, at: DVec2, is_degrees: [bool; 2]) -> DVec2 {
    let at = if is_degrees[0] { at * 1f64.to_radians() } else { at };
    let mut point = (at.x, at.y, 0.0);
    proj4rs::transform::transform(from, to, &mut point).unwrap();
    let at = DVec2::new(point.0, point.1);
    if is_degrees[1] { at * 1f64.to_degrees() } else { at }
}

/// Returns the number of cells with a wrong class, and of cells that have a single class and could be checked.
fn mistakes(cover: &Cover, class: impl Fn(DVec2) -> u8) -> (usize, usize) {
    let [low, high] = [cover.low_m, cover.high_m].map(DVec2::from_array);
    let cell = (high - low) / DVec2::from_array(cover.size.map(f64::from));
    assert!((cell.x / cell.y - 1.0).abs() < 1e-9, "cells are squares");
    let (mut wrong, mut sure) = (0, 0);
    for (texel, number) in cover.texels.iter().zip(0..) {
        let middle =
            low + cell * (DVec2::new(f64::from(number % cover.size[0]), f64::from(number / cover.size[0])) + 0.5);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
            .map(|by| middle + 0.499 * cell * DVec2::from_array(by));
        let wanted = class(middle);
        if corners.iter().all(|corner| class(*corner) == wanted) {
            sure += 1;
            wrong += usize::from(texel[1] != wanted - 40 || texel[0] != [255, 128, 64][usize::from(wanted - 41)]);
        }
    }
    (wrong, sure)
}

/// Asserts that classes are in the right places, and that a shift by a cell or exchanged axes would be noticed.
fn assert_position(cover: &Cover, class: impl Fn(DVec2) -> u8) {
    let (wrong, sure) = mistakes(cover, &class);
    assert!(wrong == 0 && 10 * sure > 3 * cover.texels.len(), "{wrong} of {sure} of {}", cover.texels.len());
    let cell_m = (cover.high_m[0] - cover.low_m[0]) / f64::from(cover.size[0]);
    for by in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
        assert!(mistakes(cover, |at| class(at + cell_m * by)).0 > sure / 2000, "{by}");
    }
    assert!(mistakes(cover, |at| class(at.yx())).0 > sure / 5, "exchanged");
    assert!(mistakes(cover, |at| class(DVec2::new(at.x, -at.y))).0 > sure / 5, "upside down");
}

#[test]
fn classes_of_the_same_system_lie_where_they_should() {
    let (dem, scratch) = (Dem::utm(), Scratch::new());
    let mapping = dem.mapping();
    let origin = mapping.origin_crs();
    // A finer raster, a coarser one, and one on another lattice; all are wider than the world.
    for spacing in [5.0, 20.0, 33.0] {
        let size = [(2600.0 / spacing) as usize, (2300.0 / spacing) as usize];
        let corner = [599_713.0, 5_200_311.0];
        let path = scratch
            .tiff(builder(size, 32610), corner, [spacing; 2], size, |x, y| class_of(DVec2::new(x, y) - origin, 230.0));
        let cover = dem.load(&land(path)).unwrap();
        // With samples larger than cells, the class is that of the sample around the position.
        let sample = |at: DVec2| {
            let corner = DVec2::from_array(corner) - origin;
            ((at - corner) / spacing).floor() * spacing + 0.5 * spacing + corner
        };
        assert_position(&cover, |at| class_of(sample(at), 230.0));
        let cell_m = (cover.high_m[0] - cover.low_m[0]) / f64::from(cover.size[0]);
        assert!((cell_m - spacing).abs() < 1e-9, "as fine as needed: {cell_m}");
        assert!(cover.low_m[0] <= -1000.0 && cover.low_m[0] > -1000.0 - spacing && cover.high_m[1] >= 800.0);
        // Corners of cells are corners of samples.
        let off = (cover.low_m[0] + origin.x - corner[0]) / spacing;
        assert!((off - off.round()).abs() < 1e-6, "{off}");
    }
}

#[test]
fn classes_of_another_system_lie_where_they_should() {
    let scratch = Scratch::new();
    let [degrees, utm] = [WGS84, UTM_10].map(|text| Proj::from_proj_string(text).unwrap());

    let dem = Dem::utm();
    let mapping = dem.mapping();
    let place = |at: DVec2| projected(&utm, &degrees, mapping.crs_from_world(at), [false, true]);
    let middle = place(DVec2::ZERO);
    let size = [420, 420];
    let path = scratch.tiff(builder(size, 4326), [middle.x - 0.02, middle.y + 0.015], [1e-4, 7e-5], size, |x, y| {
        class_of(DVec2::new(x, y) - middle, 3e-3)
    });
    let cover = dem.load(&land(path)).unwrap();
    assert!(cover.size[0] > 200 && cover.size[0] < 300, "{:?}", cover.size);
    assert_position(&cover, |at| class_of(place(at) - middle, 3e-3));

    let dem = Dem::geographic();
    let mapping = dem.mapping();
    let place = |at: DVec2| projected(&degrees, &utm, mapping.crs_from_world(at), [true, false]);
    let middle = place(DVec2::ZERO);
    let size = [300, 260];
    let path = scratch.tiff(builder(size, 32610), [middle.x - 1500.0, middle.y + 1300.0], [10.0; 2], size, |x, y| {
        class_of(DVec2::new(x, y) - middle, 230.0)
    });
    let cover = dem.load(&land(path)).unwrap();
    assert_position(&cover, |at| class_of(place(at) - middle, 230.0));
    // Planted: grid north of the raster is another direction.
    assert!(mistakes(&cover, |at| class_of(at, 230.0)).0 > 0);
}

#[test]
fn a_real_world_has_its_classes_where_they_should_be() {
    let default_folder = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("HACHURE_TEST_DATA").map_or_else(default_folder, PathBuf::from);
    let path = folder.join("dem/geotiff/N46E008_alps.tif");
    if !path.is_file() {
        println!("skipped: {} is not there", path.display());
        return;
    }
    let reader = open_reader(&path).unwrap();
    let dem = Dem(reader.georeference().clone(), reader.size());
    let mapping = dem.mapping();
    let [degrees, utm] =
        [WGS84, "+proj=utm +zone=32 +ellps=WGS84 +units=m +no_defs"].map(|text| Proj::from_proj_string(text).unwrap());
    let place = |at: DVec2| projected(&degrees, &utm, mapping.crs_from_world(at), [true, false]);
    let middle = place(DVec2::ZERO);
    let (scratch, size) = (Scratch::new(), [300, 434]);
    let corner = [middle.x - 45_000.0, middle.y + 65_000.0];
    let path = scratch
        .tiff(builder(size, 32632), corner, [300.0; 2], size, |x, y| class_of(DVec2::new(x, y) - middle, 2300.0));
    let cover = dem.load(&land(path)).unwrap();
    assert_position(&cover, |at| class_of(place(at) - middle, 2300.0));
}

#[test]
fn densities_are_means_and_classes_those_with_most_trees() {
    let (dem, scratch) = (Dem::utm(), Scratch::new());
    // With 8000 samples along a side, a cell has two. A quarter of each cell is 42, a quarter 43, and the rest
    // unlisted. In the fast tier the raster is a strip of the world.
    let size = [8000, if full() { 6400 } else { 640 }];
    let class = |x: f64, y: f64| match [x, y].map(|at| (at * 4.0).floor() as i64 & 1) {
        [0, 0] => 42_u8,
        [1, 0] => 43,
        _ => 7,
    };
    let tiled = builder(size, 32610).tile_size(256, 256);
    let path = scratch.tiff(tiled, [600_000.0, 5_200_000.0], [0.25; 2], size, class);
    let cover = dem.load(&land(path.clone())).unwrap();
    assert!(cover.size[0] <= MAX_CELLS && cover.size[0] > 3900, "{:?}", cover.size);
    let mean = cover.texels.iter().map(|texel| f64::from(texel[0])).sum::<f64>() / cover.texels.len() as f64;
    assert!((mean / 255.0 - 0.1875).abs() < 0.004, "{mean}");
    assert!(cover.texels.iter().filter(|texel| texel[1] == 2).count() > cover.texels.len() * 9 / 10);
    // Planted: a single sample read for each cell.
    assert!(cover.texels.iter().filter(|texel| [0, 64, 128].contains(&texel[0])).count() < cover.texels.len() / 10);
}

#[test]
fn unlisted_classes_are_reported_with_their_count() {
    let (dem, scratch) = (Dem::utm(), Scratch::new());
    let size = [100, 80];
    let class = |x: f64, y: f64| {
        if x < 600_200.0 {
            11
        } else if y > 5_199_900.0 {
            12
        } else {
            41_i16
        }
    };
    let path = scratch.tiff(builder(size, 32610), [600_000.0, 5_200_000.0], [20.0; 2], size, class);
    let files = land(path.clone());
    let ground = Dem::utm();
    let ground = Ground::new(&ground.0, ground.1).unwrap();
    let raster = AlignedRaster::by_place(&path, open_values(&path, Holds::Classes).unwrap().reader, &ground).unwrap();
    let grid = Grid::over(&ground, std::iter::once(&raster)).unwrap();
    let numbers = files.classes.iter().zip(1..).map(|(class, number)| (class.class, number)).collect();
    let question = Question::Class { classes: &files.classes, numbers };
    let tally = resample(&raster, &grid, |values, tally| question.answer(values, tally), |_, _| {}).unwrap();
    let line = unlisted_line(&path, &tally, raster.samples_per_point(&grid)).unwrap();
    assert!(line.ends_with("class (samples): 11 (800), 12 (450)"), "{line}");
    // Unlisted classes have no trees, the others do.
    let cover = dem.load(&files).unwrap();
    assert_eq!(cover.at([-900.0, 0.0]), Some([0, 0, 0, 255]));
    assert_eq!(cover.at([0.0, 0.0]), Some([255, 1, 0, 255]));
    // Planted: all classes are listed.
    assert_eq!(unlisted_line(&path, &Tally::default(), 1.0), None);
    let many = Tally { unlisted: (0..1000).map(|class| (class, 1)).collect(), ..Tally::default() };
    let line = unlisted_line(&path, &many, 1.0).unwrap();
    assert!(line.ends_with("23 (1) and 976 more"), "{line}");
}

#[test]
fn a_picture_is_stretched_over_the_world() {
    let (dem, scratch) = (Dem::utm(), Scratch::new());
    // White in the north-western quarter, grey in the north-eastern one.
    let shade = |i: u32| match (i % 8 < 4, i / 8 < 3) {
        (true, true) => 255_u8,
        (false, true) => 102,
        _ => 0,
    };
    let bytes: Vec<u8> = (0..48).map(shade).collect();
    let shades = |cover: &Cover| {
        [[-500.0, 400.0], [500.0, 400.0], [-500.0, -400.0], [500.0, -400.0]].map(|at| cover.at(at).unwrap()[0])
    };
    let path = scratch.png(ColorType::Grayscale, BitDepth::Eight, [8, 6], &bytes);
    let cover = dem.load(&mask(path.clone())).unwrap();
    assert_eq!(shades(&cover), [255, 102, 0, 0]);
    assert!(cover.low_m[0] <= -1000.0 && cover.high_m[1] >= 800.0 && cover.at([0.0, 2000.0]).is_none());
    // Half of the 8 columns covers half of the world.
    let row: Vec<u8> = (-99..100).map(|x| cover.at([f64::from(x) * 10.0, 700.0]).unwrap()[0]).collect();
    let edge = row.iter().position(|shade| *shade == 102).unwrap() as f64 * 10.0 - 990.0;
    assert!(edge.abs() <= 20.0 && row[0] == 255 && row[198] == 102, "{edge}");
    // A world without a location, one whose rows run north, 16 bits, and a TIFF without a location.
    assert_eq!(shades(&Dem::local().load(&mask(path.clone())).unwrap()), [255, 102, 0, 0]);
    let mut south_up = Dem::utm();
    south_up.0.crs_from_grid[5] = 20.0;
    assert_eq!(shades(&south_up.load(&mask(path)).unwrap()), [255, 102, 0, 0]);
    let bytes: Vec<u8> = (0..48).flat_map(|i| (u16::from(shade(i)) * 257).to_be_bytes()).collect();
    let path = scratch.png(ColorType::Grayscale, BitDepth::Sixteen, [8, 6], &bytes);
    assert_eq!(shades(&dem.load(&mask(path)).unwrap()), [255, 102, 0, 0]);
    let path = scratch.path("bare.tif");
    let samples = Array2::from_shape_fn((6, 8), |(row, column)| shade((row * 8 + column) as u32));
    GeoTiffBuilder::new(8, 6).write_2d(&path, samples.view()).unwrap();
    assert_eq!(shades(&dem.load(&mask(path.clone())).unwrap()), [255, 102, 0, 0]);
    // A mask of zeros and ones means none and all.
    let ones = samples.mapv(|shade| u8::from(shade > 0));
    GeoTiffBuilder::new(8, 6).write_2d(&path, ones.view()).unwrap();
    assert_eq!(shades(&dem.load(&mask(path)).unwrap()), [255, 255, 0, 0]);
}

#[test]
fn canopies_are_as_tall_as_their_raster_says() {
    let (dem, scratch) = (Dem::utm(), Scratch::new());
    let size = [90, 80];
    let height_m = |x: f64, _: f64| ((x - 600_000.0) / 20.0).floor() as f32 - 0.5;
    let path = scratch.tiff(builder(size, 32610).nodata("29.5"), [600_000.0, 5_200_000.0], [20.0; 2], size, height_m);
    let cover = dem.load(&canopy(path.clone())).unwrap();
    let at = |column: i32| cover.at([f64::from(column) * 20.0 - 1000.0 + 10.0, 3.0]);
    assert_eq!([at(1), at(2)], [Some([0, 0, 0, 255]); 2], "0.5 and 1.5 m are no trees");
    assert_eq!(at(3), Some([255, 0, 10, 255]));
    assert_eq!(at(20), Some([255, 0, 78, 255]));
    assert_eq!(at(30), Some([0, 0, 0, 255]), "no data");
    assert_eq!(at(80), Some([255, 0, 255, 255]), "the tallest that can be stored");
    assert_eq!(at(95), None, "outside the raster");

    // Together with a uniform mask of one half.
    let bytes = [128_u8; 16];
    let files = CoverFiles {
        mask: Some(scratch.png(ColorType::Grayscale, BitDepth::Eight, [4, 4], &bytes)),
        canopy_height: Some(path.clone()),
        ..CoverFiles::default()
    };
    let both = dem.load(&files).unwrap();
    assert_eq!(both.at([-600.0 + 10.0, 3.0]), Some([128, 0, 78, 255]));
    assert_eq!((both.at([-970.0, 3.0]).unwrap()[0], both.at([890.0, 3.0])), (0, None));
    assert_eq!(Cover::load(&CoverFiles::default(), &dem.0, dem.1).unwrap(), None);
}

#[test]
fn a_raster_that_cannot_be_aligned_is_named() {
    let (dem, scratch) = (Dem::utm(), Scratch::new());
    let size = [100, 80];
    let (corner, step) = ([600_000.0, 5_200_000.0], [20.0; 2]);
    let is = |result: Result<Cover, String>, words: &str| {
        let error = result.unwrap_err();
        assert!(error.contains(words), "{error}\n{words}");
    };
    let path = scratch.tiff(GeoTiffBuilder::new(100, 80), corner, step, size, |_, _| 41_u8);
    for files in [land(path.clone()), canopy(path.clone()), mask(path)] {
        is(dem.load(&files), "raster.tif: has no coordinate reference system");
    }
    let path = scratch.path("bare.tif");
    GeoTiffBuilder::new(8, 6).write_2d(&path, Array2::<u8>::zeros((6, 8)).view()).unwrap();
    is(dem.load(&land(path)), "bare.tif: has no coordinate reference system");
    let path = scratch.tiff(builder(size, 1), corner, step, size, |_, _| 41_u8);
    is(dem.load(&land(path)), "raster.tif: its coordinate reference system EPSG:1 is unknown");
    let path = scratch.tiff(builder(size, 32611), [1e6, 2e6], step, size, |_, _| 41_u8);
    is(dem.load(&land(path)), "raster.tif: does not overlap the world");
    let path = scratch.tiff(builder(size, 32610), corner, step, size, |_, _| 41.5_f32);
    is(dem.load(&land(path)), "raster.tif: has the value 41.5, but a class must be a whole number");
    let path = scratch.tiff(builder(size, 32610), corner, step, size, |_, _| 41_u8);
    is(Dem::local().load(&land(path.clone())), "raster.tif: cannot be aligned with the world, which has no coordinate");
    // Planted: the same file works with another world.
    assert!(dem.load(&land(path.clone())).is_ok());
    let mut own = Dem::utm();
    own.0.crs = Crs::Projected { metres_per_unit: 1.0, name: "a farm's own".into() };
    is(
        own.load(&land(path.clone())),
        "raster.tif: cannot be aligned with the world: no transformation is known from a farm's own",
    );

    let whole = std::fs::read(&path).unwrap();
    for part in [0, 3, 100, whole.len() / 2, whole.len() - 400] {
        std::fs::write(&path, &whole[..part]).unwrap();
        is(dem.load(&land(path.clone())), "raster.tif: ");
    }
    is(dem.load(&land(scratch.path("none.tif"))), "none.tif: cannot be opened");
    is(dem.load(&mask(scratch.0.path().into())), "is a folder, not a file");
    let path = scratch.png(ColorType::Rgb, BitDepth::Eight, [2, 2], &[0; 12]);
    is(dem.load(&mask(path.clone())), "mask.png: holds a picture in colours, not shades of grey");
    let path = scratch.png(
        ColorType::Grayscale,
        BitDepth::Eight,
        [64, 64],
        &(0..4096).map(|i| (i * i / 7) as u8).collect::<Vec<_>>(),
    );
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    is(dem.load(&mask(path)), "mask.png: is damaged");
}
