//! The tones of hatched maps tell the form of the land: they follow a shaded relief with light from several directions.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{draw, halves, north_west, places_m, still};
use common::{World, full, grid_of, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::style::Style;

/// Side of the squares whose mean tones are compared.
const BLOCK_PX: usize = 12;
/// Azimuths of the lights in degrees, and their weights: as in the shaded relief of many atlases, mostly from the
/// north-west.
const LIGHTS: [(f64, f64); 4] = [(225.0, 0.15), (270.0, 0.25), (315.0, 0.4), (360.0, 0.2)];

/// Returns the side of the picture in pixels, and a camera above it. The fast tier draws the middle, with pixels of the
/// same size.
fn from_above() -> (u32, &'static str) {
    if full() { (480, "0,0,90000,0,-90,30") } else { (240, "0,0,90000,0,-90,15.26136") }
}

/// Returns the brightness of land with this gradient.
fn shaded(gradient: DVec2) -> f64 {
    let normal = DVec3::new(-gradient.x, -gradient.y, 1.0).normalize();
    let light = |(azimuth_deg, weight): (f64, f64)| {
        let azimuth = azimuth_deg.to_radians();
        let to_light = DVec3::new(azimuth.sin(), azimuth.cos(), 1.0) / 2.0_f64.sqrt();
        weight * normal.dot(to_light).max(0.0)
    };
    LIGHTS.map(light).iter().sum()
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let mean = pairs.iter().fold(DVec2::ZERO, |sum, pair| sum + DVec2::new(pair.0, pair.1)) / count;
    let (mut across, mut own) = (0.0, DVec2::ZERO);
    for pair in pairs {
        let off = DVec2::new(pair.0, pair.1) - mean;
        across += off.x * off.y;
        own += off * off;
    }
    across / (own.x * own.y).sqrt()
}

/// Returns the mean over each block.
fn blocks(values: &[f64]) -> Vec<f64> {
    let side = from_above().0 as usize;
    let block = |x: usize, y: usize| {
        let rows = (0..BLOCK_PX).map(|row| &values[(y + row) * side + x..][..BLOCK_PX]);
        rows.flatten().sum::<f64>() / (BLOCK_PX * BLOCK_PX) as f64
    };
    let starts = || (BLOCK_PX..side - 2 * BLOCK_PX).step_by(BLOCK_PX);
    starts().flat_map(|y| starts().map(move |x| (x, y))).map(|(x, y)| block(x, y)).collect()
}

#[test]
fn hatched_maps_follow_shaded_relief() {
    let samples = if full() { 1025 } else { 513 };
    let Some(mut world) = World::new(grid_of(samples, samples, 60.0, rough_height_m), 1.0) else { return };
    let (side_px, camera) = from_above();
    let pose = world.pose(camera);
    let view = still(pose, [side_px; 2]);
    let mut relief = Vec::new();
    let mut compared = |name: &str, has_values_of_maps: bool| {
        // Terraces of this land are as level as lakes.
        let mut style = Style::load(name).unwrap().without(&["water"]);
        if !has_values_of_maps {
            style.on_maps.clear();
        }
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let style = style.for_map(100.0).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
        if relief.is_empty() {
            // The form at the scale of the picture: differences over three pixels.
            let places = places_m(&world.gpu, &renderer, pose.position_m);
            let pixel_m = 90_000.0 / view.focal_px();
            let gradient = |at: DVec3| {
                let reach_m = 1.5 * pixel_m;
                let rise = |step: DVec2| {
                    rough_height_m(at.x + step.x, at.y + step.y) - rough_height_m(at.x - step.x, at.y - step.y)
                };
                DVec2::new(rise(DVec2::X * reach_m), rise(DVec2::Y * reach_m)) / (2.0 * reach_m)
            };
            relief = places.into_iter().map(|at| at.map_or(1.0, |at| shaded(gradient(at)))).collect();
        }
        let picture = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
        let tones: Vec<f64> = picture.iter().map(|texel| texel[1]).collect();
        let pairs: Vec<(f64, f64)> = blocks(&relief).into_iter().zip(blocks(&tones)).collect();
        correlation(&pairs)
    };
    for (name, least) in [
        ("engraving", 0.8),
        ("hachures", 0.7),
        // These are drawn in the long tier.
        ("crosshatch", 0.8),
        ("woodcut", 0.7),
        ("rock", 0.7),
        ("pencil", 0.8),
        ("charcoal", 0.8),
        ("stipple", 0.8),
    ]
    .into_iter()
    .take(if full() { 8 } else { 2 })
    {
        let found = compared(name, true);
        // Planted: the shadows, crests and rows of other views.
        let planted = compared(name, false);
        println!("{name}: {found:.2}; with the values of other views {planted:.2}");
        assert!(found > least && planted < found - 0.05, "{name}: {found}, with the values of other views {planted}");
    }
}
