//! Fits Bézier curves to polylines, within a tolerance.
//!
//! A stroke is split at its corners. Between two corners a cubic spline is laid through its points (Bessel's tangents:
//! the parabola through a point and its two neighbours), because kurbo's fit requires a smooth source. The spline is
//! then approximated by few cubics, found greedily from the beginning, each as long as possible: kurbo makes a cubic
//! with the tangents at both ends, and the area and moment, of the source (Levien 2021, *Fitting cubic Bézier curves*,
//! and 2023, *Simplifying Bézier paths*). Where two cubics meet, both have the tangent of the spline, so there is no
//! kink.
//!
//! kurbo's estimate of the error is not a bound, and does not refer to the polyline. So the distance between each cubic
//! and its stretch of the polyline is measured here in both directions, and the cubic is accepted only within the
//! tolerance. A stretch between two neighbouring points without such a cubic becomes a straight line, which has no
//! error.

use std::ops::Range;

use kurbo::simplify::SimplifyBezPath;
use kurbo::{BezPath, CubicBez, ParamCurve, ParamCurveArclen, ParamCurveFit, Point, Vec2};

/// Cosine of the turn from which a point is a corner (60°).
const CORNER_COSINE: f64 = 0.5;
/// Least distance between points of the spline, as a fraction of the tolerance. The direction between closer points is
/// dominated by rounding.
const SAME_PART: f64 = 0.25;
/// Distance between points at which the error is measured, as a fraction of the tolerance. Between two of them the
/// error cannot grow by more than half of this distance, for which [`MEASURED_PART`] leaves room.
const STEP_PART: f64 = 0.2;
/// Largest ratio of the length of a curve to that of its stretch. A curve that runs back and forth may be near the
/// polyline, but other programs draw it badly.
const LONGER: f64 = 1.1;
/// Shortest arm of a curve, as a fraction of its chord.
const SHORT_ARM: f64 = 0.05;
/// Largest measured error, as a fraction of the tolerance.
const MEASURED_PART: f64 = 0.9;

/// Returns a path whose distance from the polyline is at most `tolerance` (in the points' unit), measured in both
/// directions. The path begins and ends where the polyline does; a closed one ends with a closing element. Points that
/// are not finite are skipped. A single point gives a line of zero length, no points an empty path.
pub(crate) fn fit(points: &[Point], is_closed: bool, tolerance: f64) -> BezPath {
    let mut all: Vec<Point> = points.iter().copied().filter(|point| point.is_finite()).collect();
    all.dedup();
    let mut path = BezPath::new();
    let Some(&first) = all.first() else { return path };
    if is_closed && all.last() != Some(&first) {
        all.push(first);
    }
    path.move_to(first);
    let kept = thin_out(&all, SAME_PART * tolerance);
    if kept.len() < 2 || all.len() < 3 {
        path.line_to(all[all.len() - 1]);
    } else {
        let stretch = Stretch { all: &all, kept: &kept, tolerance };
        let corners: Vec<usize> = (0..kept.len()).filter(|&i| stretch.is_corner(i)).collect();
        let seam = if is_closed { stretch.seam() } else { None };
        for ends in corners.windows(2) {
            stretch.smooth(ends[0], ends[1], seam, &mut path);
        }
    }
    if is_closed {
        path.close_path();
    }
    path
}

/// Returns the indices of points that are at least `apart` from the one before; the first and the last are included.
fn thin_out(all: &[Point], apart: f64) -> Vec<usize> {
    let mut kept = vec![0];
    for i in 1..all.len() {
        if all[i].distance(all[kept[kept.len() - 1]]) >= apart {
            kept.push(i);
        }
    }
    let last = all.len() - 1;
    if kept[kept.len() - 1] != last {
        // The last point replaces a point that is too close to it.
        if kept.len() > 1 {
            kept.pop();
        }
        kept.push(last);
    }
    kept
}

/// A polyline that is being fitted.
struct Stretch<'a> {
    /// All points of the polyline.
    all: &'a [Point],
    /// Indices of the points that the spline goes through.
    kept: &'a [usize],
    tolerance: f64,
}

impl Stretch<'_> {
    fn at(&self, i: usize) -> Point {
        self.all[self.kept[i]]
    }

    /// Returns the unit vector from the kept point `i` to the next, and the distance.
    fn step(&self, i: usize) -> (Vec2, f64) {
        let way = self.at(i + 1) - self.at(i);
        let length = way.hypot().max(f64::MIN_POSITIVE);
        (way / length, length)
    }

    /// Returns whether the line is split at the kept point `i`; it always is at its ends.
    fn is_corner(&self, i: usize) -> bool {
        let last = self.kept.len() - 1;
        i == 0 || i == last || self.step(i - 1).0.dot(self.step(i).0) < CORNER_COSINE
    }

    /// Returns the tangent where a loop begins and ends, if there is no corner.
    fn seam(&self) -> Option<Vec2> {
        let last = self.kept.len() - 2;
        let is_smooth = last > 1 && self.step(last).0.dot(self.step(0).0) >= CORNER_COSINE;
        is_smooth.then(|| self.bessel(last, 0))
    }

    /// Returns Bessel's tangent between two steps.
    fn bessel(&self, before: usize, after: usize) -> Vec2 {
        let ((into, into_length), (out, out_length)) = (self.step(before), self.step(after));
        unit(into * out_length + out * into_length, out)
    }

    /// Appends curves for the kept points from `first` to `last`, between which there is no corner. `seam` is the
    /// tangent at both ends of a loop.
    fn smooth(&self, first: usize, last: usize, seam: Option<Vec2>, path: &mut BezPath) {
        let tangents = self.tangents(first, last, seam);
        let mut spline = BezPath::new();
        spline.move_to(self.at(first));
        for i in first..last {
            let handle = self.step(i).1 / 3.0;
            let (a, b) = (self.at(i), self.at(i + 1));
            spline.curve_to(a + tangents[i - first] * handle, b - tangents[i + 1 - first] * handle, b);
        }
        let source = SimplifyBezPath::new(&spline);
        let steps = (last - first) as f64;
        let try_to = |from: usize, to: usize| -> Option<CubicBez> {
            let range = (from - first) as f64 / steps..(to - first) as f64 / steps;
            if turns_sharply(&source, &range) {
                return None;
            }
            let (mut cubic, _) = kurbo::fit_to_cubic(&source, range, self.tolerance)?;
            // Exact end points, so that the path has no gaps.
            (cubic.p0, cubic.p3) = (self.at(from), self.at(to));
            // Other programs draw an arm of zero length as a cusp, so arms as long as those of the spline replace it.
            let chord = cubic.p0.distance(cubic.p3);
            if (cubic.p1 - cubic.p0).hypot().min((cubic.p3 - cubic.p2).hypot()) < SHORT_ARM * chord {
                cubic.p1 = cubic.p0 + tangents[from - first] * (chord / 3.0);
                cubic.p2 = cubic.p3 - tangents[to - first] * (chord / 3.0);
            }
            let polyline = &self.all[self.kept[from]..=self.kept[to]];
            is_near(cubic, polyline, self.tolerance).then_some(cubic)
        };
        let mut from = first;
        while from < last {
            // The search doubles the distance, then bisects. It finds the farthest point that a cubic reaches, provided
            // that all closer points are reached.
            let mut found = None;
            let mut reached = from;
            let mut failed = last + 1;
            let mut reach = 1;
            while reached < last && failed > reached + 1 {
                let to = if failed > last { (from + reach).min(last) } else { usize::midpoint(reached, failed) };
                match try_to(from, to) {
                    Some(cubic) => (found, reached, reach) = (Some(cubic), to, reach * 2),
                    None => failed = to,
                }
            }
            match found {
                Some(cubic) => path.curve_to(cubic.p1, cubic.p2, cubic.p3),
                None => {
                    // Points that the spline skips are still points of the polyline.
                    reached = from + 1;
                    self.all[self.kept[from] + 1..=self.kept[reached]].iter().for_each(|point| path.line_to(*point));
                }
            }
            from = reached;
        }
    }

    /// Returns the unit tangents at the kept points from `first` to `last`.
    fn tangents(&self, first: usize, last: usize, seam: Option<Vec2>) -> Vec<Vec2> {
        let mut tangents: Vec<Vec2> = Vec::with_capacity(last - first + 1);
        tangents.push(self.step(first).0);
        tangents.extend((first + 1..last).map(|i| self.bessel(i - 1, i)));
        tangents.push(self.step(last - 1).0);
        let end = tangents.len() - 1;
        if end > 1 {
            // The parabola with the tangent of the neighbour.
            tangents[0] = unit(2.0 * tangents[0] - tangents[1], tangents[0]);
            tangents[end] = unit(2.0 * tangents[end] - tangents[end - 1], tangents[end]);
        }
        if let Some(seam) = seam {
            if first == 0 {
                tangents[0] = seam;
            }
            if last + 1 == self.kept.len() {
                tangents[end] = seam;
            }
        }
        tangents
    }
}

/// Returns whether kurbo would measure by arc length, to 1e-9. It does so where the tangent turns by more than a fifth
/// between two of its sample points. On a candidate with long arms that search does not end (kurbo 0.13), and a single
/// cubic is rarely near enough to such a turn anyway.
fn turns_sharply(source: &impl ParamCurveFit, range: &Range<f64>) -> bool {
    // The numbers of kurbo, with a small reserve.
    const PLACES: usize = 21;
    const SHARP: f64 = 0.195;
    let tangent = |i: usize| {
        let t = range.start + i as f64 * (range.end - range.start) / PLACES as f64;
        source.sample_pt_tangent(t, 1.0).tangent
    };
    (0..PLACES).any(|i| {
        let (a, b) = (tangent(i), tangent(i + 1));
        b.cross(a).abs() > SHARP * b.dot(a).abs()
    })
}

fn unit(vector: Vec2, otherwise: Vec2) -> Vec2 {
    let length = vector.hypot();
    if length > 1e-6 { vector / length } else { otherwise }
}

/// Returns whether a cubic and a polyline are within `tolerance` of each other everywhere. Both are walked along
/// together, so a distance may be overestimated, but never underestimated.
fn is_near(cubic: CubicBez, polyline: &[Point], tolerance: f64) -> bool {
    let step = STEP_PART * tolerance;
    let limit = MEASURED_PART * tolerance;
    let length = cubic.arclen(0.1 * step);
    let own: f64 = polyline.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    if !length.is_finite() || length > LONGER * own + 0.5 * tolerance {
        return false;
    }
    // The derivative of a cubic is at most three times the longest leg of its control polygon.
    let legs = [cubic.p1 - cubic.p0, cubic.p2 - cubic.p1, cubic.p3 - cubic.p2].map(Vec2::hypot);
    let count = (3.0 * legs.into_iter().fold(0.0, f64::max) / step).ceil().max(2.0) as usize;
    let curve: Vec<Point> = (0..=count).map(|i| cubic.eval(i as f64 / count as f64)).collect();
    let dense: Vec<Point> = polyline
        .windows(2)
        .flat_map(|pair| {
            let parts = (pair[0].distance(pair[1]) / step).ceil().max(1.0) as usize;
            (0..parts).map(move |part| pair[0].lerp(pair[1], part as f64 / parts as f64))
        })
        .collect();
    walks_along(&curve, polyline, limit) && walks_along(&dense, &curve, limit)
}

/// Number of segments ahead in which a closer one is searched.
const AHEAD: usize = 6;

/// Returns whether each of `places` is within `limit` of a segment of `line`, in order.
fn walks_along(places: &[Point], line: &[Point], limit: f64) -> bool {
    let last = line.len() - 2;
    let mut segment = 0;
    places.iter().all(|&place| {
        let mut nearest = squared_distance(place, line[segment], line[segment + 1]);
        let mut ahead = segment;
        while ahead < last && ahead < segment + AHEAD {
            ahead += 1;
            let distance = squared_distance(place, line[ahead], line[ahead + 1]);
            if distance < nearest {
                (nearest, segment) = (distance, ahead);
            }
        }
        nearest <= limit * limit
    })
}

/// Returns the squared distance from a point to the segment from `a` to `b`.
fn squared_distance(place: Point, a: Point, b: Point) -> f64 {
    let way = b - a;
    let squared = way.hypot2();
    let t = if squared > 0.0 { ((place - a).dot(way) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (place - (a + way * t)).hypot2()
}
