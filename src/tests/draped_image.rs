//! Tests images on the land: they lie where they must, darken and colour tones, and are the same in a frame that streams.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::disallowed_methods, reason = "files go to temporary folders")]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use proj4rs::Proj;
use proj4rs::transform::transform;

use crate::tests::common;

use common::draw::{NOON, draw, halves, normals, places_m, still};
use common::{World, grid_of};
use hachure::frame::{Light, Renderer};
use hachure::imagery::Imagery;
use hachure::imagery::tests::write_png;
use hachure::internals::read;
use hachure::scene::ImageFile;
use hachure::scene::view::View;
use hachure::source::GeoKeys;
use hachure::source::georeference::{Crs, Georeference};
use hachure::style::Style;
use hachure::surface::draped_image::DRAPED_IMAGE;
use hachure::tiles::Terrain;
use hachure::tiles::terrain::{Loading, TerrainOptions};
use hachure::tones::TONE;

const SIZE_PX: [u32; 2] = [240, 160];
const STEP_M: f64 = 25.0;
const SAMPLES: u32 = 201;
/// Projected coordinates of the world's origin, in zone 32 of UTM: 3.4° from its meridian, so that axes of degrees are
/// turned against those of metres.
const ORIGIN_M: DVec2 = DVec2::new(760_000.0, 5_200_000.0);
const CAMERAS: [&str; 2] = ["0,0,3400,0,-90,45", "300,-2400,+700,10,-30,55"];

fn height_m(x_m: f64, y_m: f64) -> f64 {
    600.0 + 120.0 * (x_m / 420.0).sin() * (y_m / 510.0).cos()
}

fn place() -> Georeference {
    let half_m = 0.5 * f64::from(SAMPLES - 1) * STEP_M;
    let corner = ORIGIN_M + DVec2::new(-half_m, half_m);
    let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32632".to_owned() };
    Georeference { crs_from_grid: [corner.x, STEP_M, 0.0, corner.y, 0.0, -STEP_M], crs, geokeys: GeoKeys::default() }
}

fn world(height_m: fn(f64, f64) -> f64) -> Option<World> {
    let mut grid = grid_of(SAMPLES, SAMPLES, STEP_M, height_m);
    grid.georeference = place();
    World::new(grid, 0.5)
}

fn put(world: &mut World, path: &Path) {
    let files = [ImageFile { path: path.to_owned() }];
    let gpu = world.gpu.clone();
    world.surfaces.set_imagery(&gpu, Imagery::open(&files, &place(), [SAMPLES; 2]).unwrap());
}

/// Returns a style of smooth tones with a section `[image]`.
fn style(image: &str) -> Style {
    let text = format!(
        "name = \"image\"\ndescription = \"Image.\"\n[image]\n{image}\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0.0\n"
    );
    Style::parse("image", &text).unwrap()
}

fn clear() -> Light {
    Light { to_sun: DVec3::new(-0.3, 0.2, 0.9).normalize(), haze_m: 1e9, ..NOON }
}

/// Draws a view, and returns the factor of the light in each pixel.
fn factors(world: &mut World, renderer: &mut Renderer, view: &View, style: &Style) -> Vec<f32> {
    draw(&world.gpu, &mut world.surfaces, renderer, view, style, &clear());
    let target = renderer.target(&DRAPED_IMAGE).unwrap();
    let bytes = read(&world.gpu, target, [0, 0], SIZE_PX).unwrap();
    bytes.chunks_exact(8).map(|texel| f32::from_le_bytes([texel[4], texel[5], texel[6], texel[7]])).collect()
}

/// Draws a view, and returns colour and requested tone of each pixel.
fn tones(world: &mut World, view: &View, style: &Style) -> Vec<[f64; 4]> {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, view, style, &clear());
    halves(&world.gpu, renderer.target(&TONE).unwrap())
}

/// A checkerboard in degrees: north-western corner, pixels along a side, and cells in pixels.
struct Board {
    corner_deg: DVec2,
    pixel_deg: f64,
    side: u32,
    cell: u32,
}

const BOARD: Board = Board { corner_deg: DVec2::new(12.38, 46.93), pixel_deg: 8e-5, side: 1000, cell: 35 };

impl Board {
    fn is_white(&self, at_deg: DVec2) -> Option<bool> {
        let pixel = (at_deg - self.corner_deg) * DVec2::new(1.0, -1.0) / self.pixel_deg;
        let is_inside = pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(DVec2::splat(self.side.into())).all();
        let cell = (pixel / f64::from(self.cell)).as_ivec2();
        is_inside.then_some((cell.x + cell.y) % 2 == 1)
    }

    fn write(&self, folder: &Path) -> PathBuf {
        let path = folder.join("board.png");
        write_png(&path, [self.side; 2], |x, y| match (x / self.cell + y / self.cell) % 2 {
            0 => [0, 0, 0, 255],
            _ => [255; 4],
        });
        let first = self.corner_deg + DVec2::new(0.5, -0.5) * self.pixel_deg;
        let sidecar =
            format!("crs = \"EPSG:4326\"\norigin = [{}, {}]\nspacing_degrees = {}\n", first.x, first.y, self.pixel_deg);
        std::fs::write(folder.join("board.png.toml"), sidecar).unwrap();
        path
    }
}

#[test]
fn an_image_in_degrees_lies_where_it_must() {
    let Some(mut world) = world(height_m) else { return };
    let folder = tempfile::tempdir().unwrap();
    put(&mut world, &BOARD.write(folder.path()));
    let style = style("tone = 1.0");
    let from = Proj::from_proj_string("+proj=utm +zone=32 +datum=WGS84").unwrap();
    let to = Proj::from_proj_string("+proj=longlat +datum=WGS84").unwrap();
    let degrees = |world: &World, at_m: DVec2| {
        let grid = world.mapping.grid_from_world(at_m);
        let [x, a, _, y, _, d] = place().crs_from_grid;
        let mut point = (x + a * grid.x, y + d * grid.y, 0.0);
        transform(&from, &to, &mut point).unwrap();
        DVec2::new(point.0.to_degrees(), point.1.to_degrees())
    };
    for camera in CAMERAS {
        let view = still(world.pose(camera), SIZE_PX);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let factors = factors(&mut world, &mut renderer, &view, &style);
        let eye_m = view.pose.position_m;
        let places = places_m(&world.gpu, &renderer, eye_m);
        let normals = normals(&world.gpu, &renderer);
        // Counts pixels on the wrong side of the board that are farther than half a pixel from its edges, if it lies
        // `shift_px` pixels to the east.
        let wrong = |shift_px: f64| {
            let (mut count, mut wrong) = (0, 0);
            for ((factor, place_m), normal) in factors.iter().zip(&places).zip(&normals) {
                let Some(at_m) = place_m else { continue };
                let normal = DVec3::new(normal[0].into(), normal[1].into(), normal[2].into());
                let to_eye = eye_m - *at_m;
                let pixel_m = to_eye.length() / view.focal_px();
                // The footprint of a pixel on slopes that are seen from the side is long.
                let long_m = pixel_m / to_eye.normalize().dot(normal).max(0.05);
                let at_m = at_m.truncate() - DVec2::X * shift_px * pixel_m;
                let whites = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]
                    .map(|by| BOARD.is_white(degrees(&world, at_m + 0.5 * long_m * DVec2::from_array(by))));
                let Some(expected) = whites[0].filter(|_| whites.iter().all(|white| *white == whites[0])) else {
                    continue;
                };
                count += 1;
                wrong += usize::from((*factor > HALF_LIGHT) != expected);
            }
            assert!(count > 10_000, "{camera}: {count}");
            wrong as f64 / f64::from(count)
        };
        println!("{camera}: {:.5} wrong, {:.4} if shifted", wrong(0.0), wrong(1.5));
        assert!(wrong(0.0) < 0.0005, "{camera}: {}", wrong(0.0));
        // Planted: an image that is 1.5 px off.
        assert!(wrong(1.5) > 0.01 && wrong(-1.5) > 0.01, "{camera}");
    }
}

/// The lightness of half of the light, which an edge has between black and white.
const HALF_LIGHT: f32 = 0.735;

/// Returns whether a pixel is in the western half of a view from above, away from the middle; `None` in the middle.
fn is_west(index: usize) -> Option<bool> {
    let x = index as i64 % i64::from(SIZE_PX[0]) - i64::from(SIZE_PX[0]) / 2;
    (x.abs() > 3).then_some(x < 0)
}

fn means(values: &[f64]) -> [f64; 2] {
    [true, false].map(|west| {
        let half: Vec<f64> =
            values.iter().enumerate().filter(|(at, _)| is_west(*at) == Some(west)).map(|(_, value)| *value).collect();
        half.iter().sum::<f64>() / half.len() as f64
    })
}

#[test]
fn a_black_half_darkens_the_tone_and_a_transparent_one_changes_nothing() {
    let Some(mut world) = world(height_m) else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.png");
    let view = still(world.pose(CAMERAS[0]), SIZE_PX);
    let bare = tones(&mut world, &view, &style("tone = 0.4"));
    write_png(&path, [400, 400], |x, _| if x < 200 { [0, 0, 0, 255] } else { [255, 255, 255, 0] });
    put(&mut world, &path);
    let draped = tones(&mut world, &view, &style("tone = 0.4"));
    for (index, (before, after)) in bare.iter().zip(&draped).enumerate() {
        match is_west(index) {
            // Black takes 40 % of the light.
            Some(true) => assert!((after[3] - 0.6 * before[3]).abs() < 2e-3, "{before:?} {after:?}"),
            Some(false) => assert_eq!(before, after),
            None => {}
        }
    }
    // Planted: a weaker image is noticed.
    let weaker = tones(&mut world, &view, &style("tone = 0.38"));
    assert!(
        weaker.iter().zip(&bare).enumerate().any(|(index, (after, before))| {
            is_west(index) == Some(true) && (after[3] - 0.6 * before[3]).abs() > 2e-3
        })
    );
    // Hatching draws the darker tone.
    let hatched = |world: &mut World, tone: f64| {
        let mut style = common::absolute("crosshatch");
        style.image.tone = tone as f32;
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &clear());
        let asked: Vec<f64> = halves(&world.gpu, renderer.target(&TONE).unwrap()).iter().map(|tone| tone[3]).collect();
        let cover = renderer.target(&hachure::tones::balance::MARKS).unwrap();
        let cover: Vec<f64> = read_cover(&world.gpu, cover);
        (means(&asked), means(&cover))
    };
    let (asked, ink) = hatched(&mut world, 0.4);
    let (asked_bare, ink_bare) = hatched(&mut world, 0.0);
    println!("tone {asked:.3?} of {asked_bare:.3?}, ink {ink:.3?} of {ink_bare:.3?}");
    assert!(asked[0] < 0.75 * asked_bare[0] && ink[0] > ink_bare[0] + 0.15, "{asked:?} {ink:?} {ink_bare:?}");
    assert!((ink[1] - ink_bare[1]).abs() < 0.03, "{ink:?} {ink_bare:?}");
    // The ink is as much as the tone asks for.
    assert!((1.0 - ink[0] - asked[0]).abs() < 0.08, "{asked:?} {ink:?}");
}

fn read_cover(gpu: &hachure::gpu::Gpu, target: &hachure::gpu::Target) -> Vec<f64> {
    let bytes = read(gpu, target, [0, 0], SIZE_PX).unwrap();
    let texel_bytes = bytes.len() / (SIZE_PX[0] * SIZE_PX[1]) as usize;
    let value = |texel: &[u8]| match texel_bytes {
        1 => f64::from(texel[0]) / 255.0,
        2 => half::f16::from_le_bytes([texel[0], texel[1]]).to_f64(),
        _ => f32::from_le_bytes([texel[0], texel[1], texel[2], texel[3]]).into(),
    };
    bytes.chunks_exact(texel_bytes).map(value).collect()
}

#[test]
fn hues_colour_tones_and_leave_their_lightness() {
    let Some(mut world) = world(height_m) else { return };
    // Paper shows through where the tone is white, so the light is dim.
    let dim = |image: &str| style(&format!("{image}\n[light]\nexposure = 0.5\n"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.png");
    write_png(&path, [400, 400], |x, _| if x < 200 { [200, 60, 40, 255] } else { [120, 120, 120, 255] });
    let view = still(world.pose(CAMERAS[0]), SIZE_PX);
    let bare = tones(&mut world, &view, &dim("tone = 0.0"));
    put(&mut world, &path);
    let luminance = |[red, green, blue, _]: [f64; 4]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let check = |drawn: &[[f64; 4]]| {
        drawn.iter().zip(&bare).enumerate().all(|(index, (after, before))| {
            let is_red = after[0] > 1.15 * after[2];
            let same = (luminance(*after) - luminance(*before)).abs() < 0.01 && after[3] == before[3];
            is_west(index).is_none_or(|west| west == is_red) && same
        })
    };
    assert!(check(&tones(&mut world, &view, &dim("tone = 0.0\ncolor = 1.0"))));
    // Planted: without colour, without contrast of red and green, and with tone.
    assert!(!check(&tones(&mut world, &view, &dim("tone = 0.0\ncolor = 0.0"))));
    let grey = "tone = 0.0\ncolor = 1.0\ncontrast_red = 0.0\ncontrast_green = 0.0\ncontrast_blue = 0.0";
    assert!(!check(&tones(&mut world, &view, &dim(grey))));
    assert!(!check(&tones(&mut world, &view, &dim("tone = 0.5\ncolor = 1.0"))));
}

#[test]
fn a_frame_that_streams_ends_at_the_picture_of_a_file() {
    let Some(mut world) = world(height_m) else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noise.png");
    write_png(&path, [2400, 2400], |x, y| {
        let value = (255.0 * common::random(i64::from(x / 3), i64::from(y / 5))) as u8;
        [value, 255 - value, 80, 255]
    });
    put(&mut world, &path);
    let style = style("tone = 1.0");
    let view = still(world.pose(CAMERAS[1]), SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let expected = factors(&mut world, &mut renderer, &view, &style);
    let images = world.surfaces.imagery().unwrap();
    let (tiles, bias) = images.in_view();
    println!("{tiles} tiles, {} kB", images.gpu_bytes() / 1000);
    assert!(tiles > 8 && bias == 0.0 && !images.is_late());
    // At least as many slots as tiles, in powers of two, of 260 × 260 texels.
    assert!(images.gpu_bytes() < (2 * tiles as u64 + 16) * 271_000);

    let store = Arc::clone(world.surfaces.terrain.store());
    let options = TerrainOptions { lod_error_px: 0.5, loading: Loading::Stream, ..TerrainOptions::default() };
    world.surfaces = Terrain::new(&world.gpu, store, options).unwrap().into();
    put(&mut world, &path);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let start = Instant::now();
    let mut frames = 0;
    let first = factors(&mut world, &mut renderer, &view, &style);
    // Planted: the first frame has none of the tiles.
    assert!(first != expected && renderer.is_settling());
    loop {
        let prepared = draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &clear());
        frames += 1;
        if !prepared.tiles.late && !renderer.is_settling() {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{frames} frames");
    }
    let last = factors(&mut world, &mut renderer, &view, &style);
    println!("{frames} frames");
    let different = last.iter().zip(&expected).filter(|(a, b)| a != b).count();
    assert_eq!(different, 0);
}

#[test]
fn what_cannot_be_used_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let whole = folder.path().join("whole.png");
    write_png(&whole, [300, 200], |x, y| [x as u8, y as u8, 0, 255]);
    let bytes = std::fs::read(&whole).unwrap();
    let open = |path: &Path| {
        let files = [ImageFile { path: path.to_owned() }];
        Imagery::open(&files, &place(), [SAMPLES; 2]).err().map(|error| error.to_string())
    };
    assert_eq!(open(&whole), None);
    let far = folder.path().join("far.png");
    write_png(&far, [30, 20], |_, _| [255; 4]);
    write("far.png.toml", b"crs = \"EPSG:4326\"\norigin = [-120, 40]\nspacing_degrees = 0.01\n");
    let nowhere = folder.path().join("nowhere.png");
    write_png(&nowhere, [30, 20], |_, _| [255; 4]);
    write("nowhere.pgw", b"10\n0\n0\n-10\n500000\n5200000\n");
    for (path, cause) in [
        (write("cut.png", &bytes[..bytes.len() / 2]), "damaged"),
        (write("text.tif", b"This is no image."), "is not an image"),
        (write("empty.jpg", b""), "is empty"),
        (write("cut.jpg", &[0xff, 0xd8, 0xff, 0xe0, 0, 16, b'J']), "damaged"),
        (write("cut.tif", &[b'I', b'I', 42, 0, 8, 0, 0, 0, 1]), "damaged"),
        (folder.path().join("none.png"), "cannot be opened"),
        (far, "does not overlap the world"),
        (nowhere, "has no coordinate reference system"),
    ] {
        let error = open(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(error.contains(&name) && error.contains(cause) && !error.contains('\n'), "{error}");
        assert!(error.len() < 300, "{error}");
    }
}
