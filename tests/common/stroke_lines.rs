//! Strokes as places on the picture, and how well places cover each other.

use std::collections::HashMap;

use glam::DVec2;
use hachure::lines::strokes::points::Point;

/// Shorter strokes are not drawn: the style's.
const SHORTEST_PX: f64 = 4.0;
/// A line covers a contour, and a contour bears a line, within this.
pub const NEAR_PX: f64 = 2.0;

fn px(point: &Point) -> DVec2 {
    DVec2::new(point.px[0].into(), point.px[1].into())
}

/// Places along the strokes that are long enough to be drawn, a quarter of a pixel apart, within the picture.
pub fn along_strokes(points: &[Point], size_px: [u32; 2]) -> Vec<DVec2> {
    let mut lengths_px: HashMap<u32, f64> = HashMap::new();
    let pairs = || points.windows(2).filter(|pair| pair[0].chain == pair[1].chain);
    for pair in pairs() {
        *lengths_px.entry(pair[0].chain).or_default() += px(&pair[0]).distance(px(&pair[1]));
    }
    let mut along = Vec::new();
    for pair in pairs().filter(|pair| lengths_px[&pair[0].chain] >= SHORTEST_PX) {
        let (a, b) = (px(&pair[0]), px(&pair[1]));
        let steps = ((b - a).length() * 4.0).ceil().max(1.0) as usize;
        along.extend((0..=steps).map(|step| a.lerp(b, step as f64 / steps as f64)));
    }
    let size = DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
    along.retain(|px| px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all());
    along
}

/// The part of `places` that has one of `others` within [`NEAR_PX`].
pub fn covered(places: &[DVec2], others: &[DVec2]) -> f64 {
    let cell = |px: DVec2| ((px.x / NEAR_PX).floor() as i64, (px.y / NEAR_PX).floor() as i64);
    let mut cells: HashMap<(i64, i64), Vec<DVec2>> = HashMap::new();
    for other in others {
        cells.entry(cell(*other)).or_default().push(*other);
    }
    let is_near = |px: &&DVec2| {
        let (x, y) = cell(**px);
        (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy))).any(|cell| {
            cells.get(&cell).is_some_and(|others| others.iter().any(|other| other.distance(**px) <= NEAR_PX))
        })
    };
    places.iter().filter(is_near).count() as f64 / places.len().max(1) as f64
}
