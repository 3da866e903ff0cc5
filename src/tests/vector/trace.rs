//! Tests that tracing ink returns the lines that it was drawn with.

use hachure::lines::strokes::polylines::Polyline;
use hachure::vector::trace::{InkPicture, dots, lines};

/// Returns ink from a function that returns the signed distance in pixels from the border of a mark, positive inside.
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

/// Returns a bar through the middle of a picture, rotated by `turn_deg` from the horizontal, and the distance from its
/// axis.
fn bar(turn_deg: f32, width_px: f32, ink: f32) -> (InkPicture, impl Fn([f32; 2]) -> f32) {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let away = move |x: f32, y: f32| (x - 100.3) * sin - (y - 99.8) * cos;
    let along = move |x: f32, y: f32| (x - 100.3) * cos + (y - 99.8) * sin;
    let mut picture = picture([200, 200], |x, y| (0.5 * width_px - away(x, y).abs()).min(70.0 - along(x, y).abs()));
    picture.ink.iter_mut().for_each(|own| *own *= ink);
    (picture, move |px: [f32; 2]| away(px[0], px[1]).abs())
}

#[test]
fn a_bar_is_one_line_in_its_middle() {
    for turn_deg in (0..180).step_by(7).map(|turn| turn as f32) {
        for (width_px, ink) in [(1.0, 1.0), (2.0, 1.0), (3.5, 1.0), (6.0, 1.0), (1.5, 0.3), (3.0, 0.5)] {
            let (picture, away) = bar(turn_deg, width_px, ink);
            let mut found = lines(&picture);
            found.sort_by(|a, b| length(b).total_cmp(&length(a)));
            let [line, rest @ ..] = found.as_slice() else { panic!("{turn_deg} {width_px} {ink}: no line found") };
            let name = format!("{turn_deg} degrees, {width_px} px, ink {ink}");
            assert!(rest.iter().map(length).sum::<f32>() < 1.0, "{name}: {} more lines", rest.len());
            assert!((length(line) - 140.0 + width_px).abs() < 5.0, "{name}: {}", length(line));
            let inner = line.points.iter().skip(3).rev().skip(3);
            let off = inner.map(|at| away(at.px)).fold(0.0, f32::max);
            assert!(off < 0.45, "{name}: {off} px from its middle");
            let drawn = 2.0 * line.points[line.points.len() / 2].half_width_px / (width_px * ink);
            assert!((drawn - 1.0).abs() < 0.15, "{name}: {drawn} times as wide");
        }
    }
}

#[test]
fn lines_that_cross_go_on() {
    let straight = |x: f32, y: f32, turn_deg: f32| {
        let (sin, cos) = f32::to_radians(turn_deg).sin_cos();
        1.25 - ((x - 100.0) * sin - (y - 100.0) * cos).abs()
    };
    let crossed = picture([200, 200], |x, y| straight(x, y, 20.0).max(straight(x, y, 80.0)));
    let lengths: Vec<f32> = lines(&crossed).iter().map(length).collect();
    assert_eq!(lengths.iter().filter(|length| **length > 190.0).count(), 2, "{lengths:?}");
    // Planted: lines that end where they meet.
    let cut = picture([200, 200], |x, y| straight(x, y, 20.0).max(if x < 100.0 { -1.0 } else { straight(x, y, 80.0) }));
    assert_eq!(lines(&cut).iter().filter(|line| length(line) > 190.0).count(), 1);
}

#[test]
fn a_ring_is_closed_and_dots_are_dots() {
    let ring = lines(&picture([100, 100], |x, y| 1.5 - ((x - 50.0).hypot(y - 50.0) - 30.0).abs()));
    assert!(ring.len() == 1 && ring[0].is_closed, "{}", ring.len());
    assert!(ring[0].points.iter().all(|at| ((at.px[0] - 50.0).hypot(at.px[1] - 50.0) - 30.0).abs() < 0.3));
    let far = |x: f32, y: f32| (x.rem_euclid(12.0) - 6.0).hypot(y.rem_euclid(12.0) - 6.0);
    let found = dots(&picture([120, 120], |x, y| 2.5 - far(x, y)));
    assert_eq!(found.len(), 100);
    let is_right = |line: &Polyline| {
        line.points.iter().all(|at| (at.half_width_px - 2.5).abs() < 0.1 && far(at.px[0], at.px[1]) < 0.2)
    };
    assert!(found.iter().all(is_right));
    // Planted: larger dots.
    assert!(!dots(&picture([120, 120], |x, y| 3.0 - far(x, y))).iter().all(is_right));
}
