//! Every preset draws the same on a second Vulkan driver: SwiftShader, which shares no code with Mesa. Its description
//! is where `HACHURE_SECOND_DRIVER` says, or where `.ci/setup test` puts it.
//!
//! Two drivers round differently, and a line that is chained from another pixel on is another line. So the bounds are
//! on the share of pixels that differ clearly, by the kind of drawing: above what was measured, and below what a
//! drawing that is moved by three pixels has.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use hachure::file::png::{Picture, read_rgba8};
use hachure::measure::image_compare::{Tolerance, compare};
use hachure::style::{self, Style};

const SIZE: &str = "128x72";
/// Beyond this a pixel is another one, of 255.
const CHANNEL_DIFFERENCE: u8 = 48;

/// The share of pixels that may differ. Measured: 0.0026 at most without strokes and marks, 0.01 with those of a pen.
/// Of broad strokes one link that is chosen otherwise moves a whole brush: those have bounds of their own.
fn outlier_share(name: &str, style: &Style) -> f64 {
    match name {
        "dry-ink" => 0.05,
        "charcoal" | "brush" => 0.03,
        // Crowded lines are thinned to pale ones, of which few pixels are clear.
        "pencil-lines" => 0.0125,
        "pencil" => 0.05,
        "wash" => 0.03,
        _ if style.strokes.is_some() || style.hatching.is_some() => 0.02,
        _ => 0.006,
    }
}

fn second_driver() -> Option<PathBuf> {
    let kept = || Path::new(env!("CARGO_MANIFEST_DIR")).join("target/second-driver/vk_swiftshader_icd.json");
    let path = std::env::var_os("HACHURE_SECOND_DRIVER").map_or_else(kept, PathBuf::from);
    if path.is_file() {
        return Some(path);
    }
    println!("skipped: there is no second Vulkan driver at {}", path.display());
    None
}

/// The picture of a world in a style, on the driver of the environment or on another one.
fn drawn(folder: &Path, (world, style): (&str, &str), driver: Option<&Path>, camera: &[&str]) -> Picture {
    let path = folder.join(format!("{world}-{style}-{}.png", if driver.is_some() { "second" } else { "first" }));
    let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
    command
        .args(["render", world, "--size", SIZE, "--style", style, "-o"])
        .arg(&path)
        .args(camera)
        .current_dir(folder)
        .env("HACHURE_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("second-driver"))
        // Else Mesa speaks in between.
        .env("XDG_RUNTIME_DIR", folder);
    if let Some(driver) = driver {
        command.env("VK_DRIVER_FILES", driver).env("VK_ICD_FILENAMES", driver);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{style}: {}", String::from_utf8_lossy(&output.stderr));
    read_rgba8(&path).unwrap()
}

/// The same, moved to the right by three pixels: what a wrong projection would draw.
fn moved(picture: &Picture) -> Picture {
    let bytes = 4 * picture.width as usize;
    let mut rgba = picture.rgba.clone();
    for row in rgba.chunks_exact_mut(bytes) {
        row.rotate_right(12);
    }
    Picture { rgba, ..picture.clone() }
}

#[test]
fn every_preset_draws_the_same_on_a_second_driver() {
    let Some(second) = second_driver() else { return };
    if hachure::gpu::Gpu::open(&hachure::gpu::device::AdapterWish::Best).is_err() {
        println!("skipped: there is no first Vulkan driver");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // The land is grown once.
    let first = drawn(folder.path(), ("hut", "plain"), None, &[]);
    let mut all: Vec<(&str, &str)> = style::names().into_iter().map(|name| ("hut", name)).collect();
    all.extend([("forest", "ink"), ("forest", "pencil")]);
    let count = all.len();
    let all = Mutex::new(all);
    let found = Mutex::new(Vec::new());
    let work = || {
        loop {
            let Some((world, name)) = all.lock().unwrap().pop() else { return };
            let style = Style::load(name).unwrap();
            // Trees are many edges: where one lies on a pixel's middle, drivers may take either side.
            let outlier_share = outlier_share(name, &style) * if world == "forest" { 3.0 } else { 1.0 };
            let tolerance = Tolerance { channel_difference: CHANNEL_DIFFERENCE, outlier_share };
            let first = drawn(folder.path(), (world, name), None, &[]);
            let second = drawn(folder.path(), (world, name), Some(&second), &[]);
            let comparison = compare(&first, &second, tolerance).unwrap();
            let planted = compare(&first, &moved(&second), tolerance).unwrap();
            found.lock().unwrap().push((format!("{world}, {name}"), comparison, planted));
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    let found = found.into_inner().unwrap();
    assert_eq!(found.len(), count);
    for (name, comparison, planted) in &found {
        println!("{name}: {comparison}; moved by three pixels: {}", planted.outliers);
    }
    for (name, comparison, planted) in &found {
        assert!(comparison.passes(), "{name}: {comparison}");
        assert!(!planted.passes(), "{name}: a picture that is moved by three pixels passes: {planted}");
    }
    // And these are two drivers: not one of them twice.
    assert!(found.iter().any(|(_, comparison, _)| comparison.worst_difference > 0), "both drivers are one");
    assert_eq!([first.width, first.height], [128, 72]);
}
