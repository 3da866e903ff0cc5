//! Anti-aliasing with more than one sample per pixel: within one picture, and over successive frames.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

mod flight;
mod pair;
mod rest;
mod samples;
mod still_strokes;

use common::draw::{halves, north_west};
use common::{World, full, grid_of, rough_height_m};
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::picture::{Band, PictureRequest, render};
use hachure::scene::view::Pose;
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [192, 108];
const VIEW: &str = "-300,-2500,+350,20,-14,60";

/// Returns the size of pictures that are only compared with each other. In the fast tier it is half of [`SIZE_PX`].
fn small_px() -> [u32; 2] {
    if full() { SIZE_PX } else { SIZE_PX.map(|side| side / 2) }
}

fn rough() -> Option<World> {
    World::new(grid_of(257, 257, 30.0, rough_height_m), 1.0)
}

/// The same land with triangles that are as fine for a small picture as for a large one.
fn fine_rough() -> Option<World> {
    World::new(grid_of(257, 257, 30.0, rough_height_m), 0.25)
}

/// Returns the picture of the last frame.
fn picture(world: &World, renderer: &Renderer) -> Vec<[f64; 4]> {
    halves(&world.gpu, renderer.target(&PICTURE).unwrap())
}

/// Renders the picture with `samples` samples per pixel.
fn supersampled(
    world: &mut World,
    renderer: &mut Option<Renderer>,
    style: &Style,
    pose: Pose,
    size_px: [u32; 2],
    samples: u32,
) -> Vec<[f64; 4]> {
    let request = PictureRequest { samples, ..PictureRequest::still(pose, size_px, style, north_west()) };
    let mut texels = Vec::new();
    let take = |band: Band| {
        texels.extend(band.picture.into_iter().map(|texel| texel.map(f64::from)));
        Ok::<_, ()>(())
    };
    render(&world.gpu, renderer, &mut world.surfaces, &request, take).unwrap();
    texels
}

/// Returns the root mean square difference.
fn apart(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let squared: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).powi(2)).sum();
    (squared / (4 * a.len()) as f64).sqrt()
}

/// Returns the mean squared difference in brightness between neighbouring pixels, horizontally and vertically.
fn sharpness(picture: &[[f64; 4]], width: usize) -> f64 {
    let step = |pixel: usize| {
        let [across, down] = [1, width].map(|step| picture[pixel + step][1] - picture[pixel][1]);
        across * across + down * down
    };
    let pixels = picture.len() - width;
    (0..pixels).filter(|pixel| pixel % width + 1 < width).map(step).sum::<f64>() / pixels as f64
}
