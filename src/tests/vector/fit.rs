//! Tests that curves are within the tolerance of the polyline, and the polyline within it of the curves, by brute
//! force.

use std::f64::consts::TAU;

use hachure::vector::fit::fit;
use kurbo::{BezPath, ParamCurve, PathEl, PathSeg, Point, Vec2};

use crate::tests::vector::{farthest, random};

/// Returns lines to fit: name, points, and whether the line is closed.
fn lines() -> Vec<(String, Vec<Point>, bool)> {
    let mut lines = Vec::new();
    for seed in 0..12 {
        let mut r = random(seed);
        let mut next = |most: f64| r.next().unwrap() * most;
        // Sums of sines with uneven steps.
        let waves: Vec<[f64; 3]> =
            (0..4).map(|k| [next(20.0) / f64::from(k + 1), next(TAU), next(0.08) * f64::from(k + 1)]).collect();
        let mut x = next(100.0);
        let smooth: Vec<Point> = (0..80)
            .map(|_| {
                x += 0.1 + next(6.0);
                Point::new(x, waves.iter().map(|[size, phase, rate]| size * (x * rate + phase).sin()).sum())
            })
            .collect();
        lines.push((format!("smooth {seed}"), smooth, false));
        // Random walks, with steps from almost 0 to long.
        let (mut at, mut heading) = (Point::new(next(500.0), next(500.0)), next(TAU));
        let walk: Vec<Point> = (0..60)
            .map(|_| {
                heading += next(1.6) - 0.8;
                at += Vec2::from_angle(heading) * (next(1.0) * next(1.0) * 12.0);
                at
            })
            .collect();
        lines.push((format!("walk {seed}"), walk, false));
        let noise: Vec<Point> = (0..50).map(|_| Point::new(next(40.0), next(40.0))).collect();
        lines.push((format!("noise {seed}"), noise.clone(), false));
        lines.push((format!("closed noise {seed}"), noise, true));
        let size = 0.5 + next(120.0);
        let wobble = next(0.4);
        let count = 3 + seed as usize * 8;
        let around = |i: usize| Vec2::from_angle(TAU * i as f64 / count as f64);
        let blob: Vec<Point> = (0..count)
            .map(|i| {
                Point::new(300.0, 200.0)
                    + around(i) * (size * (1.0 + wobble * (5.0 * TAU * i as f64 / count as f64).sin()))
            })
            .collect();
        lines.push((format!("loop of {count}"), blob, true));
        let teeth = 0.1 + next(15.0);
        let zigzag: Vec<Point> = (0..30).map(|i| Point::new(f64::from(i) * teeth, f64::from(i % 2) * teeth)).collect();
        lines.push((format!("zigzag of {teeth:.2}"), zigzag, false));
    }
    let line = |points: &[(f64, f64)]| points.iter().map(|at| Point::from(*at)).collect::<Vec<_>>();
    lines.extend([
        ("two points".to_owned(), line(&[(1.0, 2.0), (300.5, -7.0)]), false),
        ("two near points".to_owned(), line(&[(1.0, 2.0), (1.01, 2.0)]), false),
        ("two points around".to_owned(), line(&[(1.0, 2.0), (30.0, 20.0)]), true),
        ("one place twice".to_owned(), line(&[(5.0, 5.0), (5.0, 5.0)]), false),
        ("to and fro".to_owned(), line(&[(0.0, 0.0), (50.0, 0.0), (0.0, 0.0)]), false),
        ("hairpin".to_owned(), line(&[(0.0, 0.0), (50.0, 0.0), (50.0, 0.3), (0.0, 0.3)]), false),
        (
            "doubled".to_owned(),
            line(&[(0.0, 0.0), (0.0, 0.0), (10.0, 5.0), (10.0, 5.0), (10.0, 5.0), (20.0, 0.0), (20.0, 0.0)]),
            false,
        ),
        ("nearly doubled".to_owned(), line(&[(0.0, 0.0), (9.0, 5.0), (9.02, 5.01), (9.0, 5.03), (20.0, 0.0)]), false),
        ("triangle".to_owned(), line(&[(0.0, 0.0), (80.0, 0.0), (40.0, 60.0)]), true),
        ("straight".to_owned(), (0..40).map(|i| Point::new(f64::from(i) * 3.0, f64::from(i))).collect(), false),
        (
            "spiral".to_owned(),
            (0..400)
                .map(|i| Point::new(200.0, 200.0) + Vec2::from_angle(f64::from(i) * 0.1) * (0.5 * f64::from(i)))
                .collect(),
            false,
        ),
        (
            "in a ring that ends at its beginning".to_owned(),
            line(&[(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 0.0)]),
            true,
        ),
    ]);
    lines
}

/// Returns points along segments, at most a fifth of the tolerance apart, which makes the measured distance at most
/// half a hundredth of the tolerance too large.
fn along(segments: impl Iterator<Item = PathSeg>, tolerance: f64) -> Vec<Point> {
    segments
        .flat_map(|segment| {
            let cubic = segment.to_cubic();
            let legs = [cubic.p1 - cubic.p0, cubic.p2 - cubic.p1, cubic.p3 - cubic.p2].map(Vec2::hypot);
            let fastest = 3.0 * legs.into_iter().fold(0.0, f64::max);
            let steps = (5.0 * fastest / tolerance).ceil().max(2.0) as usize;
            (0..=steps).map(move |i| segment.eval(i as f64 / steps as f64))
        })
        .collect()
}

/// Returns the largest distance between a path and a polyline in either direction, or infinity if it is much more than
/// allowed.
fn error(path: &BezPath, points: &[Point], is_closed: bool, tolerance: f64) -> f64 {
    let mut polyline = points.to_vec();
    if is_closed {
        polyline.push(points[0]);
    }
    let sides = polyline.windows(2).map(|pair| PathSeg::Line(kurbo::Line::new(pair[0], pair[1])));
    let (curve, dense) = (along(path.segments(), tolerance), along(sides, tolerance));
    let reach = 1.5 * tolerance;
    farthest(&curve, &dense, reach).max(farthest(&dense, &curve, reach))
}

#[test]
fn curves_are_within_the_tolerance_both_ways() {
    for tolerance in [0.1, 0.25, 2.0] {
        let mut worst: f64 = 0.0;
        for (name, points, is_closed) in lines() {
            let path = fit(&points, is_closed, tolerance);
            let error = error(&path, &points, is_closed, tolerance);
            assert!(error <= tolerance, "{name}: {error} of {tolerance}");
            worst = worst.max(error);
            assert!(path.is_finite(), "{name}");
            let starts = path.elements().iter().filter(|element| matches!(element, PathEl::MoveTo(_))).count();
            assert_eq!(starts, 1, "{name}: one path for each stroke");
            assert_eq!(path.elements().last() == Some(&PathEl::ClosePath), is_closed, "{name}");
            assert!(path.segments().count() >= 1, "{name}");
            // The path must begin and end where the stroke does.
            let first = path.segments().next().unwrap().start();
            let last = path.segments().last().unwrap().end();
            assert_eq!(
                (first, last),
                (points[0], if is_closed { points[0] } else { points[points.len() - 1] }),
                "{name}"
            );
        }
        println!("tolerance {tolerance}: {worst:.4} at most, {:.2} of it", worst / tolerance);
        assert!(worst > 0.4 * tolerance, "the largest error is only {worst}, so the tolerance was not used");
    }
}

#[test]
fn a_curve_that_is_off_is_noticed() {
    let (tolerance, mut shifted, mut cut) = (0.25, 0, 0);
    let all: Vec<_> = lines().into_iter().filter(|(name, ..)| name.starts_with("smooth")).collect();
    for (_, points, is_closed) in &all {
        let path = fit(points, *is_closed, tolerance);
        // Planted: the whole path moved, then its last segment missing.
        let moved = kurbo::Affine::translate((0.0, 1.2 * tolerance)) * path.clone();
        shifted += usize::from(error(&moved, points, *is_closed, tolerance) > tolerance);
        let mut short = path.clone();
        short.truncate(path.elements().len() - 1);
        cut += usize::from(error(&short, points, *is_closed, tolerance) > tolerance);
    }
    assert_eq!((shifted, cut), (all.len(), all.len()));
}

/// Returns the sharpest turn where segments meet, in radians.
fn kink(path: &BezPath) -> f64 {
    let segments: Vec<PathSeg> = path.segments().collect();
    let legs = |segment: &PathSeg| match segment {
        PathSeg::Cubic(cubic) => [cubic.p1 - cubic.p0, cubic.p3 - cubic.p2],
        other => [other.end() - other.start(); 2],
    };
    let turn = |pair: &[PathSeg]| {
        let [into, out] = [legs(&pair[0])[1], legs(&pair[1])[0]];
        into.cross(out).atan2(into.dot(out)).abs()
    };
    segments.windows(2).map(turn).fold(0.0, f64::max)
}

#[test]
fn smooth_lines_are_few_curves_without_kinks() {
    for (count, radius) in [(64, 100.0), (200, 100.0), (40, 20.0)] {
        let circle: Vec<Point> = (0..count)
            .map(|i| Point::ORIGIN + Vec2::from_angle(TAU * f64::from(i) / f64::from(count)) * radius)
            .collect();
        let path = fit(&circle, true, 0.25);
        let mut around: Vec<PathSeg> = path.segments().collect();
        around.push(around[0]);
        let seam = BezPath::from_path_segments(around.into_iter());
        println!("circle of {count} points: {} segments, {:.1e} rad", path.segments().count(), kink(&seam));
        assert!(path.segments().count() <= 6);
        assert!(kink(&seam) < 1e-6, "{}", kink(&seam));
        // Planted: the polyline itself.
        let mut sides = BezPath::new();
        sides.move_to(circle[0]);
        circle[1..].iter().for_each(|point| sides.line_to(*point));
        assert!(kink(&sides) > 1e-2 && sides.segments().count() > 20);
    }
    let (mut segments, mut points, mut kinks) = (0, 0, 0);
    for (name, line, is_closed) in lines() {
        if name.starts_with("smooth") {
            let path = fit(&line, is_closed, 0.25);
            segments += path.segments().count();
            points += line.len();
            kinks += usize::from(kink(&path) > 0.2);
        }
    }
    println!("smooth lines: {segments} segments for {points} points, {kinks} with a kink");
    assert!(3 * segments < points);
}

#[test]
fn nothing_is_made_of_what_is_no_line() {
    assert!(fit(&[], false, 0.25).is_empty());
    let nowhere = Point::new(f64::NAN, 1.0);
    assert!(fit(&[nowhere], false, 0.25).is_empty());
    let path = fit(&[Point::new(1.0, 1.0), nowhere, Point::new(9.0, 1.0)], false, 0.25);
    assert_eq!(path.to_svg(), "M1,1 L9,1");
    assert_eq!(fit(&[Point::new(1.0, 1.0); 5], false, 0.25).to_svg(), "M1,1 L1,1");
}
