//! Tests that a drawing stays readable in the distance, and that the costs of styles stay in proportion.
//!
//! Where many samples fall into a pixel, unfiltered LSA contours turn ridges into black areas. The density filter and
//! lines that pale with distance keep the paper light in every part of the picture.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::convert::Infallible;

use common::World;
use hachure::frame::Renderer;
use hachure::gpu::recorder::Submits;
use hachure::gpu::timer::FRAME;
use hachure::picture::{self, PictureRequest};
use hachure::scene::Scene;
use hachure::scene::view::View;
use hachure::style::{Style, preset_text};

/// Two views of `docs/guide/pictures.md`, and their DEM files.
const VIEWS: [(&str, &str); 2] = [
    ("dem/geotiff/mt_rainier_90m.tif", "0,-46700,5000,0,-6.5,38"),
    ("dem/geotiff/N46E008_alps.tif", "3000,-46000,4700,-6,-7.5,38"),
];
const SIZE_PX: [u32; 2] = [1440, 640];
/// Side of the areas over which ink is averaged, in pixels.
const AREA_PX: usize = 64;

/// Returns the picture as grey values of 0 to 1, encoded in sRGB.
fn grey(world: &mut World, style: &Style, camera: &str) -> Vec<f64> {
    let light = Scene::default().light(world.surfaces.terrain.extent_m());
    let request = PictureRequest::still(world.pose(camera), SIZE_PX, style, light);
    let mut grey = Vec::new();
    let taken = picture::render(&world.gpu, &mut None, &mut world.surfaces, &request, |band| {
        let bytes = picture::srgb8(&band.picture);
        grey.extend(bytes.chunks_exact(4).map(|texel| {
            (0.2126 * f64::from(texel[0]) + 0.7152 * f64::from(texel[1]) + 0.0722 * f64::from(texel[2])) / 255.0
        }));
        Ok::<_, Infallible>(())
    });
    taken.unwrap();
    grey
}

/// Returns the largest mean ink of any 64 × 64 pixels: 0 is paper, 1 is black.
fn max_ink(grey: &[f64]) -> f64 {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mut sorted = grey.to_vec();
    let paper = common::quantile(&mut sorted, 0.99);
    // Summed-area table of ink.
    let mut sums = vec![0.0; (width + 1) * (height + 1)];
    for y in 0..height {
        for x in 0..width {
            let ink = (1.0 - grey[y * width + x] / paper).max(0.0);
            sums[(y + 1) * (width + 1) + x + 1] =
                ink + sums[y * (width + 1) + x + 1] + sums[(y + 1) * (width + 1) + x] - sums[y * (width + 1) + x];
        }
    }
    let at = |x: usize, y: usize| sums[y * (width + 1) + x];
    let mut most = 0.0_f64;
    for y in 0..=height - AREA_PX {
        for x in 0..=width - AREA_PX {
            let sum = at(x + AREA_PX, y + AREA_PX) - at(x, y + AREA_PX) - at(x + AREA_PX, y) + at(x, y);
            most = most.max(sum / (AREA_PX * AREA_PX) as f64);
        }
    }
    most
}

#[test]
fn no_part_of_a_drawing_is_mush() {
    for (file, camera) in VIEWS {
        let Some(mut world) = World::real(file, 1.0) else { continue };
        let ink = Style::load("lsa").unwrap();
        let drawn = grey(&mut world, &ink, camera);
        let (most, darkest) = (max_ink(&drawn), drawn.iter().copied().fold(1.0, f64::min));
        println!("{file}: most ink {most:.3}, darkest pixel {darkest:.3}");
        assert!(most <= 0.35, "{file}: mean ink {most}");
        // The ink itself is 0.07, and some near line has nearly all of it. The nearest contours are at least 10 km
        // away, where haze has paled them a little.
        assert!(darkest < 0.25, "{file}: darkest pixel {darkest}");

        // Planted error: no filter, no cap of crowded lines, no fading with distance.
        let text = preset_text("lsa").unwrap();
        let raw = [("density = 2.0", "density = 0.0"), ("crowd = 0.09\n", ""), ("faintest = 0.12", "faintest = 1.0")]
            .into_iter()
            .fold(text.to_owned(), |text, (from, to)| {
                assert!(text.contains(from), "{from}");
                text.replace(from, to)
            });
        let raw = grey(&mut world, &Style::parse("raw", &raw).unwrap(), camera);
        let most = max_ink(&raw);
        println!("{file}: without filter and distance {most:.3}");
        assert!(most > 0.35, "{file}: an unfiltered drawing was not detected: most ink {most}");
    }
}

/// Returns the shortest time of each pass of each style over a few runs, in milliseconds. The styles take turns.
fn quickest_ms(world: &mut World, styles: &[Style], camera: &str, size_px: [u32; 2]) -> Vec<Vec<(String, f64)>> {
    let pose = world.pose(camera);
    let view = View::whole(pose, pose, size_px);
    let light = Scene::default().light(world.surfaces.terrain.extent_m());
    let mut frames: Vec<_> = styles.iter().map(|_| Renderer::new(&world.gpu).unwrap()).collect();
    frames.iter_mut().for_each(|renderer| renderer.set_submits(Submits::Timed));
    let mut quickest: Vec<Vec<(String, f64)>> = vec![Vec::new(); styles.len()];
    for _ in 0..6 {
        for ((frame, style), quickest) in frames.iter_mut().zip(styles).zip(&mut quickest) {
            frame.render(&world.gpu, &mut world.surfaces, &view, style, &light).unwrap();
            world.gpu.wait();
            for time in frame.take_times().unwrap_or_default() {
                match quickest.iter_mut().find(|(name, _)| *name == time.name) {
                    Some((_, ms)) => *ms = ms.min(time.gpu_ms),
                    None => quickest.push((time.name, time.gpu_ms)),
                }
            }
        }
    }
    quickest
}

#[test]
fn costs_stay_in_proportion() {
    let grid = common::grid_of(513, 513, 20.0, common::rough_height_m);
    let Some(mut world) = World::new(grid, 1.0) else { return };
    let styles = ["plain", "lsa", "sobel"].map(|name| Style::load(name).unwrap());
    let size_px = if common::full() { [1280, 720] } else { [640, 360] };
    let times = quickest_ms(&mut world, &styles, "0,-4500,+400,0,-8,50", size_px);
    let of = |style: usize, pass: &str| times[style].iter().find(|(name, _)| name == pass).unwrap().1;
    let lines = of(1, "lines/lsa") / of(2, "lines/sobel");
    let whole = of(1, FRAME) / of(0, FRAME);
    println!("lsa takes {lines:.2} times as long as sobel, an ink frame {whole:.2} times a plain one");
    assert!(lines <= 6.0, "lsa against sobel: {lines}");
    // The cap of crowded lines takes a fifth of a plain frame, on land with many lines; and a plain frame, which writes
    // half of the bytes that it wrote when the bound was 2, has become cheaper than the lines have.
    assert!(whole <= 2.4, "ink against plain: {whole}");
    // Control: if times were attributed to the wrong styles, every ratio would be 1. The clock of a fast GPU is too
    // coarse for this.
    if world.gpu.adapter.get_info().device_type == wgpu::DeviceType::Cpu {
        assert!(lines > 1.05 && whole > 1.02, "{times:?}");
    }
}
