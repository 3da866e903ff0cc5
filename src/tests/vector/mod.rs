//! Tests of strokes as paths: they are near enough to the drawing, in an order that shortens the pen's way, and in
//! files that other programs read.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;
mod colors;
mod fit;
mod marks;
mod order;
mod svg;
mod trace;

use std::collections::HashMap;

use hachure::lines::strokes::polylines::{EdgeKind, Polyline, PolylinePoint};
use kurbo::Point;

/// Returns pseudorandom numbers in [0, 1), the same in every run.
pub fn random(seed: i64) -> impl Iterator<Item = f64> {
    (0..).map(move |i| common::random(seed, i))
}

/// Returns a stroke of constant width.
pub fn polyline(points: &[Point], kind: EdgeKind, is_closed: bool) -> Polyline {
    let at = |point: &Point| PolylinePoint { px: [point.x as f32, point.y as f32], half_width_px: 1.0, ink: 1.0 };
    Polyline { points: points.iter().map(at).collect(), kind, stroke: 0, is_closed }
}

/// Returns the largest distance of one of `places` from the nearest of `others`; infinity if it exceeds `reach`.
pub fn farthest(places: &[Point], others: &[Point], reach: f64) -> f64 {
    let cell = |place: &Point| ((place.x / reach).floor() as i64, (place.y / reach).floor() as i64);
    let mut cells: HashMap<(i64, i64), Vec<Point>> = HashMap::new();
    others.iter().for_each(|other| cells.entry(cell(other)).or_default().push(*other));
    let nearest = |place: &Point| {
        let (x, y) = cell(place);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let others = around.filter_map(|cell| cells.get(&cell)).flatten();
        others.map(|other| other.distance_squared(*place)).fold(f64::INFINITY, f64::min)
    };
    let farthest = places.iter().map(nearest).fold(0.0, f64::max).sqrt();
    if farthest <= reach { farthest } else { f64::INFINITY }
}
