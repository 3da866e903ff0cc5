//! Ink becomes the lines that it was drawn by.

use hachure::lines::strokes::polylines::Polyline;
use hachure::vector::trace::{InkPicture, lines};

/// Ink of a function that tells how far a place is from the border of a mark, inside above 0, in pixels.
fn picture(size_px: [u32; 2], inside_px: impl Fn(f32, f32) -> f32) -> InkPicture {
    let [width, height] = size_px;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x as f32 + 0.5, y as f32 + 0.5)));
    InkPicture { size_px, ink: places.map(|(x, y)| (inside_px(x, y) + 0.5).clamp(0.0, 1.0)).collect() }
}

fn length(line: &Polyline) -> f32 {
    let step = |pair: &[_]| {
        let [a, b]: [hachure::lines::strokes::polylines::PolylinePoint; 2] = [pair[0], pair[1]];
        (a.px[0] - b.px[0]).hypot(a.px[1] - b.px[1])
    };
    line.points.windows(2).map(step).sum()
}

/// A bar through the middle of a picture, `turn_deg` from the horizontal.
fn bar(turn_deg: f32, width_px: f32, ink: f32) -> (InkPicture, impl Fn([f32; 2]) -> f32) {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let away = move |x: f32, y: f32| (x - 100.3) * sin - (y - 99.8) * cos;
    let along = move |x: f32, y: f32| (x - 100.3) * cos + (y - 99.8) * sin;
    let mut picture = picture([200, 200], |x, y| {
        (0.5 * width_px - away(x, y).abs()).min(70.0 - along(x, y).abs())
    });
    picture.ink.iter_mut().for_each(|own| *own *= ink);
    (picture, move |px: [f32; 2]| away(px[0], px[1]).abs())
}

#[test]
fn a_bar_is_one_line_in_its_middle() {
    for turn_deg in (0..180).step_by(7).map(|turn| turn as f32) {
        for (width_px, ink) in [(1.0, 1.0), (2.0, 1.0), (3.5, 1.0), (6.0, 1.0), (1.5, 0.3), (3.0, 0.5)] {
            let (picture, away) = bar(turn_deg, width_px, ink);
            let found = lines(&picture);
            let lengths: Vec<f32> = found.iter().map(length).collect();
            let off = found[0].points.iter().skip(4).rev().skip(4).map(|at| away(at.px)).fold(0.0, f32::max);
            let middle = &found[0].points[found[0].points.len() / 2];
            let drawn = 2.0 * middle.half_width_px / (width_px * ink);
            if found.len() != 1 || off > 0.3 || (lengths[0] - 140.0 + width_px).abs() > 3.0 || (drawn - 1.0).abs() > 0.15 {
                println!("{turn_deg} {width_px} {ink}: {lengths:?} {off} {drawn}");
            }
        }
    }
}
