//! Tests that presets draw the same on a second Vulkan driver: SwiftShader, which shares no code with Mesa. In the long
//! tier these are all presets, and otherwise lines, marks with strokes, watercolour, and strokes of a forest.
//! `HACHURE_SECOND_DRIVER` is the path of its description; by default it is where `.ci/setup test` puts it.
//!
//! Two drivers round differently, and a line that is chained from another pixel on is another line. So the bounds are
//! on the share of pixels that differ clearly, by the kind of drawing: above what was measured, and below that of a
//! drawing that is moved by three pixels.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../src/tests/common/mod.rs"]
mod common;

use std::path::{Path, PathBuf};
use std::process::{Child, Command};

use common::draw::{draw, halves, still};
use hachure::file::png::{Picture, read_rgba8, write_rgba8};
use hachure::frame::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::measure::image_compare::{Tolerance, compare};
use hachure::picture::srgb8;
use hachure::style::Style;
use hachure::world::OpenWorld;
use hachure::world::TerrainOptions;

const SIZE_PX: [u32; 2] = [128, 72];
/// Folder into which the drawing process writes its pictures.
const FOLDER: &str = "HACHURE_TEST_PICTURES";
/// A pixel is an outlier if a channel differs by more than this, of 255.
const CHANNEL_DIFFERENCE: u8 = 48;

/// Returns the share of pixels that may differ. Measured: at most 0.0026 without strokes and marks, 0.01 with those of
/// a pen. With broad strokes, a single link that is chosen differently moves a whole brush stroke, so these styles have
/// their own bounds.
fn outlier_share(name: &str, style: &Style) -> f64 {
    match name {
        "dry-ink" => 0.05,
        "charcoal" | "brush" => 0.03,
        // Crowded lines are thinned out to pale ones, few of whose pixels are clear.
        "pencil-lines" => 0.0125,
        "pencil" => 0.05,
        "wash" => 0.03,
        _ if style.strokes().is_some() || style.hatching().is_some() => 0.02,
        _ => 0.006,
    }
}

fn second_driver() -> Option<PathBuf> {
    let kept = || Path::new(env!("CARGO_MANIFEST_DIR")).join("target/second-driver/vk_swiftshader_icd.json");
    let path = std::env::var_os("HACHURE_SECOND_DRIVER").map_or_else(kept, PathBuf::from);
    if path.is_file() {
        return Some(path);
    }
    println!("skipped: no second Vulkan driver at {}", path.display());
    None
}

/// Returns the worlds to draw, each with its styles.
fn drawings() -> [(&'static str, Vec<&'static str>); 2] {
    match common::full() {
        true => [("hut", common::presets()), ("forest", vec!["ink", "pencil"])],
        false => [("hut", vec!["lsa", "crosshatch", "wash"]), ("forest", vec!["ink"])],
    }
}

/// Returns the cache with the land of the built-in scenes, which test programs share.
fn land_cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("built-in-land")
}

fn path(folder: &Path, world: &str, style: &str) -> PathBuf {
    folder.join(format!("{world}-{style}.png"))
}

/// Draws all pictures on the driver that the environment selects. The test below runs it as a process, since a process
/// has one driver. One process draws all presets, since SwiftShader does not cache pipelines between processes.
#[test]
#[ignore = "a part of the test below"]
fn draws_on_the_driver_of_the_environment() {
    let Some(folder) = std::env::var_os(FOLDER).map(PathBuf::from) else { return };
    let gpu = Gpu::open(&AdapterWish::Best).unwrap();
    let mut renderer = Renderer::new(&gpu).unwrap();
    for (name, styles) in drawings() {
        let mut world = OpenWorld::open(&gpu, Some(name), TerrainOptions::default()).unwrap();
        let view = still(world.pose(&world.default_camera()), SIZE_PX);
        let light = world.light();
        for style in styles {
            renderer.forget();
            draw(&gpu, &mut world.surfaces, &mut renderer, &view, &Style::load(style).unwrap(), &light);
            let linear: Vec<[f32; 4]> = halves(&gpu, renderer.target(&PICTURE).unwrap())
                .iter()
                .map(|texel| texel.map(|channel| channel as f32))
                .collect();
            let [width, height] = SIZE_PX;
            write_rgba8(&path(&folder, name, style), width, height, &srgb8(&linear)).unwrap();
        }
    }
}

/// Starts the drawing process, on the default driver or on another one.
fn start(folder: &Path, driver: Option<&Path>) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--ignored", "--exact", "draws_on_the_driver_of_the_environment"])
        .env(FOLDER, folder)
        .env("HACHURE_CACHE", land_cache())
        // Without this folder, Mesa prints a warning.
        .env("XDG_RUNTIME_DIR", folder);
    if let Some(driver) = driver {
        command.env("VK_DRIVER_FILES", driver).env("VK_ICD_FILENAMES", driver);
    }
    command.spawn().unwrap()
}

/// Returns the picture moved to the right by three pixels, as a wrong projection would draw it.
fn moved(picture: &Picture) -> Picture {
    let bytes = 4 * picture.width as usize;
    let mut rgba = picture.rgba.clone();
    for row in rgba.chunks_exact_mut(bytes) {
        row.rotate_right(12);
    }
    Picture { rgba, ..picture.clone() }
}

#[test]
fn presets_draw_the_same_on_a_second_driver() {
    let Some(second) = second_driver() else { return };
    if Gpu::open(&AdapterWish::Best).is_err() {
        println!("skipped: no first Vulkan driver");
        return;
    }
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let children = [start(folders[0].path(), None), start(folders[1].path(), Some(&second))];
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    let mut found = Vec::new();
    for (world, names) in drawings() {
        for name in names {
            let style = Style::load(name).unwrap();
            // Trees have many edges; where an edge crosses the centre of a pixel, drivers may decide differently.
            let outlier_share = outlier_share(name, &style) * if world == "forest" { 3.0 } else { 1.0 };
            let tolerance = Tolerance { channel_difference: CHANNEL_DIFFERENCE, outlier_share };
            let [first, second] =
                [0, 1].map(|driver: usize| read_rgba8(&path(folders[driver].path(), world, name)).unwrap());
            assert_eq!([first.width, first.height], SIZE_PX);
            let comparison = compare(&first, &second, tolerance).unwrap();
            let planted = compare(&first, &moved(&second), tolerance).unwrap();
            found.push((format!("{world}, {name}"), comparison, planted));
        }
    }
    for (name, comparison, planted) in &found {
        println!("{name}: {comparison}; moved by three pixels: {}", planted.outliers);
    }
    for (name, comparison, planted) in &found {
        assert!(comparison.passes(), "{name}: {comparison}");
        assert!(!planted.passes(), "{name}: a planted shift by three pixels was not detected: {planted}");
    }
    // The two drivers must differ, or the same one was used twice.
    assert!(
        found.iter().any(|(_, comparison, _)| comparison.worst_difference > 0),
        "both processes used the same driver"
    );
}
