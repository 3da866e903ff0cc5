//! Water that a scene gives as polygons or as a mask: the shore is where the file says, on any ground, and a faulty
//! file gives an error of one line.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::disallowed_methods, reason = "files go to temporary folders")]

use crate::tests::common;

use std::path::PathBuf;
use std::sync::Arc;

use common::draw::{draw, floats, north_west, places_m, still};
use common::{World, full, grid_of, quantile};
use glam::{DVec2, DVec3};
use hachure::frame::{Light, Renderer};
use hachure::scene::{Scene, WaterFiles};
use hachure::source::GeoKeys;
use hachure::source::georeference::{Crs, Georeference};
use hachure::style::Style;
use hachure::surface::water::WATER;
use hachure::world::given_water::GivenWater;

const SIZE_PX: [u32; 2] = [480, 270];
/// The smallest allowed error of the mesh that matters, in pixels: the finest tiles are drawn, as with an error of 0, but
/// no patch is divided that is exact.
const FINEST_PX: f64 = 1.0 / 64.0;
const SAMPLES: u32 = 513;
const SPACING_M: f64 = 30.0;
const RADIUS_M: f64 = 1500.0;
/// Centre of the lake in world coordinates.
const MIDDLE_M: DVec2 = DVec2::new(400.0, -300.0);
/// Projected coordinates of the world's origin.
const ORIGIN_M: DVec2 = DVec2::new(500_000.0, 5_200_000.0);
/// Views as maps at two scales, and an oblique view.
const CAMERAS: [&str; 3] = ["430,-330,8000,0,-90,45", "430,-330,20000,0,-90,45", "300,-5200,+1800,3,-22,50"];

/// Returns the georeference of the test's worlds.
fn place() -> Georeference {
    let half_m = 0.5 * f64::from(SAMPLES - 1) * SPACING_M;
    let corner = ORIGIN_M + DVec2::new(-half_m, half_m);
    let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32632".to_owned() };
    let crs_from_grid = [corner.x, SPACING_M, 0.0, corner.y, 0.0, -SPACING_M];
    Georeference { crs_from_grid, crs, geokeys: GeoKeys::default() }
}

/// Returns the height of ground that slopes to the south and is level nowhere.
fn slope_m(x_m: f64, y_m: f64) -> f64 {
    800.0 + 0.1 * y_m + 0.03 * x_m
}

fn circle(middle_m: DVec2, radius_m: f64) -> Vec<[f64; 2]> {
    let at = |i: u32| {
        let angle = f64::from(i) / 360.0 * std::f64::consts::TAU;
        (ORIGIN_M + middle_m + radius_m * DVec2::from_angle(angle)).to_array()
    };
    (0..=360).map(at).collect()
}

/// Returns the GeoJSON of polygons; each list is an outer ring with its holes.
fn geojson(crs: &str, polygons: &[Vec<Vec<[f64; 2]>>]) -> String {
    let crs = if crs.is_empty() {
        String::new()
    } else {
        format!("\"crs\":{{\"type\":\"name\",\"properties\":{{\"name\":\"{crs}\"}}}},")
    };
    format!("{{{crs}\"type\":\"MultiPolygon\",\"coordinates\":{polygons:?}}}")
}

struct Scratch(tempfile::TempDir);

impl Scratch {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn load(&self, name: &str, text: &str) -> Result<Option<GivenWater>, String> {
        load(WaterFiles::default().with(&self.write(name, text)))
    }
}

fn load(files: WaterFiles) -> Result<Option<GivenWater>, String> {
    GivenWater::load(&files, &place(), [SAMPLES; 2]).map_err(|error| {
        let error = error.to_string();
        assert!(!error.contains('\n') && error.chars().count() < 300, "{error}");
        error
    })
}

/// A pixel of the land: its position, its size on the ground, and its distance from the shore, positive in water.
struct Pixel {
    place_m: DVec3,
    pixel_m: f64,
    water_m: f64,
}

fn pixels(world: &mut World, camera: &str) -> Vec<Pixel> {
    let text = "name = \"water\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n[water]\nshore_px = 1\nlines = 3\n";
    let style = Style::parse("water", text).unwrap();
    let pose = world.pose(camera);
    let view = still(pose, SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let light = Light { haze_m: 1e9, ..north_west() };
    for _ in 0..2 {
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &light);
    }
    // A view that is known to be dry has no picture of water.
    let water = renderer.target(&WATER).map(|water| floats::<1>(&world.gpu, water));
    let water = water.unwrap_or_else(|| vec![[0.0]; SIZE_PX[0] as usize * SIZE_PX[1] as usize]);
    let places = places_m(&world.gpu, &renderer, pose.position_m);
    let pixel = |(place_m, [water_m]): (Option<DVec3>, [f32; 1])| {
        let place_m = place_m?;
        let pixel_m = place_m.distance(pose.position_m) / view.focal_px();
        Some(Pixel { place_m, pixel_m, water_m: water_m.into() })
    };
    places.into_iter().zip(water).filter_map(pixel).collect()
}

/// Returns the 95th percentile of the distance between the drawn shore and a circle, in pixels.
fn shore_px(pixels: &[Pixel], middle_m: DVec2, radius_m: f64) -> f64 {
    let near = pixels.iter().filter(|pixel| pixel.water_m != 0.0 && pixel.water_m.abs() < 0.7 * pixel.pixel_m);
    let error = |pixel: &Pixel| {
        let true_m = radius_m - pixel.place_m.truncate().distance(middle_m);
        (true_m - pixel.water_m).abs() / pixel.pixel_m
    };
    let mut errors: Vec<f64> = near.map(error).collect();
    assert!(errors.len() > 60, "{}", errors.len());
    quantile(&mut errors, 0.95)
}

fn is_water(pixels: &[Pixel], at_m: DVec2) -> bool {
    let nearest = pixels.iter().min_by(|a, b| {
        let [a, b] = [a, b].map(|pixel| pixel.place_m.truncate().distance(at_m));
        a.total_cmp(&b)
    });
    nearest.unwrap().water_m > 0.0
}

#[test]
fn a_round_lake_on_a_slope_has_its_shore() {
    let Some(mut world) = World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, slope_m), FINEST_PX) else { return };
    let scratch = Scratch::new();
    let lake = geojson("urn:ogc:def:crs:EPSG::32632", &[vec![circle(MIDDLE_M, RADIUS_M)]]);
    assert!(
        pixels(&mut world, CAMERAS[0]).iter().all(|pixel| pixel.water_m <= 0.0),
        "water is found in the heights alone"
    );
    let water = scratch.load("lake.geojson", &lake).unwrap().map(Arc::new);
    let mut world = World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, slope_m), FINEST_PX).unwrap();
    world.surfaces.set_given_water(water);
    // The fast tier leaves out the smaller map.
    for camera in CAMERAS.into_iter().step_by(if full() { 1 } else { 2 }) {
        let pixels = pixels(&mut world, camera);
        let pixel_m = pixels.iter().map(|pixel| pixel.pixel_m).fold(f64::INFINITY, f64::min);
        let error = shore_px(&pixels, MIDDLE_M, RADIUS_M);
        println!("{camera}: {pixel_m:.0} m per pixel, 95 % of the shore within {error:.2} px");
        assert!(error < 1.0, "{camera}: the shore is off by {error} px");
        // Planted errors: a lake that is shifted by two pixels, or by two samples, and a larger one.
        let aside_m = 2.0 * pixel_m.max(SPACING_M);
        assert!(shore_px(&pixels, MIDDLE_M + DVec2::new(aside_m, 0.0), RADIUS_M) > 1.0);
        assert!(shore_px(&pixels, MIDDLE_M, RADIUS_M + aside_m) > 1.0);
    }
}

#[test]
fn holes_are_land_and_narrow_water_is_there() {
    let Some(mut world) = World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, slope_m), FINEST_PX) else { return };
    let scratch = Scratch::new();
    // A lake with an island, a lake that overlaps it, and a river four samples wide.
    let river = [[-6000.0, 2000.0], [6000.0, 2500.0], [6000.0, 2620.0], [-6000.0, 2120.0]];
    let river = river.map(|at| (ORIGIN_M + DVec2::from_array(at)).to_array()).to_vec();
    let lake = vec![circle(MIDDLE_M, RADIUS_M), circle(MIDDLE_M, 600.0)];
    let other = vec![circle(MIDDLE_M + DVec2::new(1400.0, 0.0), 500.0)];
    let text = geojson("EPSG:32632", &[lake, other, vec![river]]);
    world.surfaces.set_given_water(scratch.load("all.geojson", &text).unwrap().map(Arc::new));
    let pixels = pixels(&mut world, "0,0,16000,0,-90,45");
    assert!(is_water(&pixels, MIDDLE_M + DVec2::new(0.0, 1000.0)));
    assert!(!is_water(&pixels, MIDDLE_M), "the island is water");
    assert!(is_water(&pixels, MIDDLE_M + DVec2::new(1300.0, 0.0)), "land where two polygons overlap");
    assert!(is_water(&pixels, MIDDLE_M + DVec2::new(1750.0, 0.0)));
    for x_m in [-5000.0, -1000.0, 4000.0] {
        let middle_m = 2310.0 + x_m / 24.0;
        assert!(is_water(&pixels, DVec2::new(x_m, middle_m)), "no river at x = {x_m} m");
        // Planted errors: points next to the river.
        assert!(
            !is_water(&pixels, DVec2::new(x_m, middle_m + 300.0))
                && !is_water(&pixels, DVec2::new(x_m, middle_m - 300.0))
        );
    }
}

/// Compares a polygon in metres with the same polygon in longitudes and latitudes.
#[test]
fn degrees_and_metres_give_the_same_water() {
    let scratch = Scratch::new();
    let metres = circle(MIDDLE_M, RADIUS_M + 7.0);
    let from = proj4rs::Proj::from_proj_string("+proj=utm +zone=32 +datum=WGS84 +units=m").unwrap();
    let to = proj4rs::Proj::from_proj_string("+proj=longlat +datum=WGS84").unwrap();
    let degrees = |[x, y]: &[f64; 2]| {
        let mut at = (*x, *y, 0.0);
        proj4rs::transform::transform(&from, &to, &mut at).unwrap();
        [at.0.to_degrees(), at.1.to_degrees()]
    };
    let turned: Vec<[f64; 2]> = metres.iter().map(degrees).collect();
    let by_metres = scratch.load("m.geojson", &geojson("EPSG:32632", &[vec![metres]])).unwrap().unwrap();
    let by_degrees = scratch.load("d.json", &geojson("", &[vec![turned.clone()]])).unwrap().unwrap();
    let differ = |a: &GivenWater, b: &GivenWater| {
        a.words.len().abs_diff(b.words.len()) + a.words.iter().zip(&b.words).filter(|(a, b)| a != b).count()
    };
    assert!(differ(&by_metres, &by_degrees) < 8, "the water maps differ in {} words", differ(&by_metres, &by_degrees));
    // Planted error: a lake 100 m farther east.
    let aside: Vec<[f64; 2]> = turned.iter().map(|[x, y]| [x + 100.0 / 76_000.0, *y]).collect();
    let aside = scratch.load("a.json", &geojson("", &[vec![aside]])).unwrap().unwrap();
    assert!(differ(&by_metres, &aside) > 100);
}

#[test]
fn polygons_may_go_around_the_earth() {
    let folder = tempfile::tempdir().unwrap();
    let degrees = Crs::Geographic {
        radians_per_unit: 1f64.to_radians(),
        semi_major_axis_m: 6_378_137.0,
        inverse_flattening: 298.257_223_563,
        name: "EPSG:4326".to_owned(),
    };
    let mercator = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:3857".to_owned() };
    let ring = |west: f64, east: f64| vec![[west, -60.0], [east, -60.0], [east, 60.0], [west, 60.0], [west, -60.0]];
    let grids =
        [(&degrees, 138.0, 0.01), (&degrees, 179.7, 0.01), (&mercator, 1.5e7, 1000.0), (&mercator, 2.001e7, 1000.0)];
    for (crs, west, step) in grids {
        let crs_from_grid = [west, step, 0.0, 10.0 * step, 0.0, -step];
        let place = Georeference { crs_from_grid, crs: crs.clone(), geokeys: GeoKeys::default() };
        let water = |west: f64, east: f64| {
            let path = folder.path().join("water.geojson");
            std::fs::write(&path, geojson("", &[vec![ring(west, east)]])).unwrap();
            let water = GivenWater::load(&WaterFiles::default().with(&path), &place, [64, 64]).unwrap();
            water.map_or(0, |water| {
                // The cells of the finest level.
                let [begin, _, _, columns, rows] = water.words[4..9] else { unreachable!() };
                let cells = water.words[begin as usize..][..(columns * rows / 4) as usize].iter();
                cells.flat_map(|word| word.to_le_bytes()).filter(|cell| *cell == 255).count()
            })
        };
        let name = format!("{crs:?} at {west}");
        for (from, to) in [(-180.0, 180.0), (-179.9999, 179.9999), (0.0, 360.0)] {
            assert!(water(from, to) >= 64 * 64, "{name}: {from} to {to}");
        }
        assert_eq!(water(-10.0, 10.0), 0, "{name}: planted, elsewhere");
    }
}

#[test]
fn a_mask_adds_to_what_heights_show_or_stands_for_it() {
    // A lake that is visible in the heights, in the north-east.
    let bowl_m = |x_m: f64, y_m: f64| 500.0 + (0.15 * ((x_m - 3500.0).hypot(y_m - 3500.0) - 1500.0)).max(0.0);
    let scratch = Scratch::new();
    // A mask stretched over the DEM, with 1 for water in a disc in the south-west.
    let mut bytes = Vec::new();
    for i in 0..SAMPLES * SAMPLES {
        let [column, row] = [i % SAMPLES, i / SAMPLES].map(|at| f64::from(at) - 256.0);
        bytes.push(u8::from((column + 120.0).hypot(row - 120.0) < 40.0));
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SAMPLES, SAMPLES);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    let path = scratch.write("mask.png", file);
    let seen = |only_given: bool| {
        let mut world = World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, bowl_m), FINEST_PX)?;
        let files = WaterFiles { only_given, ..WaterFiles::default().with(&path) };
        world.surfaces.set_given_water(load(files).unwrap().map(Arc::new));
        let pixels = pixels(&mut world, "0,0,20000,0,-90,45");
        let middle_m = DVec2::new(-120.0, -120.0) * SPACING_M;
        let shore = pixels.iter().filter(|pixel| pixel.place_m.x < 0.0);
        let shore: Vec<Pixel> = shore.map(|pixel| Pixel { ..*pixel }).collect();
        let error = shore_px(&shore, middle_m, 40.0 * SPACING_M);
        Some(([middle_m, DVec2::splat(3500.0)].map(|at_m| is_water(&pixels, at_m)), error))
    };
    let Some((both, error)) = seen(false) else { return };
    println!("95 % of the shore of a mask within {error:.2} px");
    assert!(
        both == [true, true] && error < 1.0,
        "water in the mask and in the heights {both:?}, error of the shore {error} px"
    );
    assert_eq!(seen(true).unwrap().0, [true, false], "level land is water despite only_given");
}

#[test]
fn invalid_files_give_an_error_of_one_line() {
    let scratch = Scratch::new();
    let square = |low: f64, high: f64| vec![vec![vec![[low, low], [high, low], [high, high], [low, low]]]];
    for (name, text, expected) in [
        (
            "empty.geojson",
            "{\"type\":\"FeatureCollection\",\"features\":[]}".to_owned(),
            "empty.geojson: GeoJSON without polygons; --water needs polygons",
        ),
        ("broken.geojson", "{\"type\":".to_owned(), "broken.geojson: it is not GeoJSON"),
        (
            "crs.geojson",
            geojson("EPSG:1", &square(0.0, 1.0)),
            "crs.geojson: its coordinate reference system EPSG:1 is unknown",
        ),
        (
            "nan.geojson",
            geojson("", &[vec![vec![[0.0, 0.0], [f64::NAN, 1.0], [1.0, 1.0]]]]),
            "nan.geojson: it is not GeoJSON",
        ),
        ("mask.tif", "no tiff".to_owned(), "mask.tif"),
    ] {
        let error = scratch.load(name, &text).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let missing = load(WaterFiles::default().with(&scratch.0.path().join("none.geojson"))).unwrap_err();
    assert!(missing.contains("none.geojson"), "{missing}");
    // A polygon outside the world gives a warning, and no water.
    assert_eq!(scratch.load("outside.geojson", &geojson("EPSG:32632", &square(0.0, 1000.0))), Ok(None));
    // Heights without a coordinate reference system.
    let files = WaterFiles::default().with(&scratch.write("there.geojson", geojson("", &square(8.0, 9.0))));
    let nowhere = Georeference { crs: Crs::Local, ..place() };
    let error = GivenWater::load(&files, &nowhere, [SAMPLES; 2]).unwrap_err().to_string();
    assert!(error.contains("there.geojson: cannot be projected onto the world"), "{error}");
}

#[test]
fn scenes_name_files() {
    let scene = |water: &str| {
        let text = format!("[world]\nprocedural = {{ seed = 1 }}\n[water]\n{water}");
        Scene::parse("land/water.toml".as_ref(), &text).map_err(|error| error.to_string())
    };
    let water = scene("polygons = \"lakes.geojson\"\nmask = \"m.tif\"\nonly_given = true\n").unwrap().water;
    assert_eq!(water.polygons, Some("land/lakes.geojson".into()));
    assert_eq!((water.mask, water.only_given), (Some("land/m.tif".into()), true));
    for (wrong, expected) in [
        ("mask = \"\"\n", "water.mask: it is empty"),
        ("polygons = \"https://x/y.geojson\"\n", "water.polygons: it must be a local file"),
        ("only_given = true\n", "water.only_given: it needs water.mask or water.polygons"),
    ] {
        let error = scene(wrong).unwrap_err();
        assert!(error.contains(expected) && error.starts_with("land/water.toml:"), "{error}");
    }
}
