//! Points along strokes in the picture, and how well two sets of points cover each other.

use std::collections::HashMap;

use bytemuck::Pod;
use glam::DVec2;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::buffer::BufferKind;
use hachure::gpu::readback::read_buffer;
use hachure::lines::strokes::points::Point;

/// The style's limit: shorter strokes are not drawn.
const SHORTEST_PX: f64 = 4.0;
/// A line covers a contour, and a contour supports a line, within this distance.
pub const NEAR_PX: f64 = 2.0;

fn px(point: &Point) -> DVec2 {
    DVec2::new(point.px[0].into(), point.px[1].into())
}

/// Returns points along the strokes that are long enough to be drawn, a quarter of a pixel apart, within the picture.
pub fn along_strokes(points: &[Point], size_px: [u32; 2]) -> Vec<DVec2> {
    along_chains(points, size_px).into_iter().map(|(px, _)| px).collect()
}

/// Returns the same points, each with its chain.
fn along_chains(points: &[Point], size_px: [u32; 2]) -> Vec<(DVec2, u32)> {
    let mut lengths_px: HashMap<u32, f64> = HashMap::new();
    let pairs = || points.windows(2).filter(|pair| pair[0].chain == pair[1].chain);
    for pair in pairs() {
        *lengths_px.entry(pair[0].chain).or_default() += px(&pair[0]).distance(px(&pair[1]));
    }
    let mut along = Vec::new();
    for pair in pairs().filter(|pair| lengths_px[&pair[0].chain] >= SHORTEST_PX) {
        let (a, b) = (px(&pair[0]), px(&pair[1]));
        let steps = ((b - a).length() * 4.0).ceil().max(1.0) as usize;
        along.extend((0..=steps).map(|step| (a.lerp(b, step as f64 / steps as f64), pair[0].chain)));
    }
    let size = DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
    along.retain(|(px, _)| px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all());
    along
}

/// Sorts points into squares of `side_px`, for searches of neighbours.
fn by_square<T: Copy>(places: &[T], side_px: f64, px: impl Fn(T) -> DVec2) -> HashMap<(i64, i64), Vec<T>> {
    let mut squares: HashMap<(i64, i64), Vec<T>> = HashMap::new();
    for place in places {
        squares.entry(square(px(*place), side_px)).or_default().push(*place);
    }
    squares
}

fn square(px: DVec2, side_px: f64) -> (i64, i64) {
    ((px.x / side_px).floor() as i64, (px.y / side_px).floor() as i64)
}

fn around((x, y): (i64, i64)) -> impl Iterator<Item = (i64, i64)> {
    (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
}

/// Returns the fraction of `places` that has one of `others` within [`NEAR_PX`].
pub fn covered(places: &[DVec2], others: &[DVec2]) -> f64 {
    let missed = missed(places, others, NEAR_PX).len();
    1.0 - missed as f64 / places.len().max(1) as f64
}

/// Returns those of `places` that have none of `others` within a distance.
pub fn missed(places: &[DVec2], others: &[DVec2], within_px: f64) -> Vec<DVec2> {
    let squares = by_square(others, within_px, |px| px);
    let is_near = |px: &&DVec2| {
        around(square(**px, within_px))
            .any(|at| squares.get(&at).is_some_and(|others| others.iter().any(|o| o.distance(**px) <= within_px)))
    };
    places.iter().filter(|px| !is_near(px)).copied().collect()
}

/// Returns the fraction of the strokes' length that has another stroke within a distance.
pub fn doubled(points: &[Point], size_px: [u32; 2], within_px: f64) -> f64 {
    let along = along_chains(points, size_px);
    let squares = by_square(&along, within_px, |(px, _)| px);
    let has_other = |(px, chain): &&(DVec2, u32)| {
        let is_other = |(at, other): &(DVec2, u32)| other != chain && at.distance(*px) <= within_px;
        around(square(*px, within_px)).any(|at| squares.get(&at).is_some_and(|others| others.iter().any(is_other)))
    };
    along.iter().filter(has_other).count() as f64 / along.len().max(1) as f64
}

/// Reads the first `count` records of a buffer of the strokes.
pub fn strokes_left<T: Pod>(gpu: &Gpu, renderer: &Renderer, kind: &BufferKind, count: usize) -> Vec<T> {
    read_buffer(gpu, &renderer.strokes().unwrap().buffer(kind).unwrap().raw, count).unwrap()
}
