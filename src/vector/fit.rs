//! Polylines → Bézier curves that stay within a tolerance of them.
//!
//! A stroke is cut at its corners. Between two corners a cubic spline is laid through its points (Bessel's tangents:
//! the parabola through a point and its two neighbours), because kurbo's fit wants a smooth source; what it fits is
//! fitted by as few cubics as can be found by going greedily from the beginning, each as far as it reaches: kurbo makes
//! a cubic with the tangents at both ends, and the area and moment, of the source (Levien 2021, *Fitting cubic Bézier
//! curves*, and 2023, *Simplifying Bézier paths*). Where two cubics meet both have the spline's tangent, so there is no
//! kink.
//!
//! kurbo's own estimate of the error is no bound, and says nothing about the polyline. So each cubic is measured here
//! against the stretch of the polyline that it stands for, both ways, and taken only if it holds. A stretch without
//! points between that has no such cubic is a line, which has no error.

use std::ops::Range;

use kurbo::simplify::SimplifyBezPath;
use kurbo::{BezPath, CubicBez, ParamCurve, ParamCurveArclen, ParamCurveFit, Point, Vec2};

/// A sharper turn than this is a corner.
const CORNER_COSINE: f64 = 0.5;
/// Points nearer to each other than this part of the tolerance say more about rounding than about direction.
const SAME_PART: f64 = 0.25;
/// Of the tolerance: between places at which it is measured. Between two of them the distance cannot grow by more than
/// half of it; that is what [`MEASURED_PART`] leaves.
const STEP_PART: f64 = 0.2;
/// A curve is at most so much longer than its stretch: one that runs to and fro may be near, and programs draw it
/// badly.
const LONGER: f64 = 1.1;
/// Arms of a curve are at least this part of its chord.
const SHORT_ARM: f64 = 0.05;
/// What is measured may be this part of the tolerance.
const MEASURED_PART: f64 = 0.9;

/// One path that stays within `tolerance` (in the points' unit) of the polyline, and the polyline within it of the
/// path. It begins and ends where the polyline does; a closed one ends with a closing element. Points that are not
/// finite are passed over; one point alone is a line of no length, no point an empty path.
pub fn fit(points: &[Point], is_closed: bool, tolerance: f64) -> BezPath {
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

/// The numbers of points that are at least `apart` from the one before, the first and the last among them.
fn thin_out(all: &[Point], apart: f64) -> Vec<usize> {
    let mut kept = vec![0];
    for i in 1..all.len() {
        if all[i].distance(all[kept[kept.len() - 1]]) >= apart {
            kept.push(i);
        }
    }
    let last = all.len() - 1;
    if kept[kept.len() - 1] != last {
        // The end stands for what is too near to it.
        if kept.len() > 1 {
            kept.pop();
        }
        kept.push(last);
    }
    kept
}

/// A polyline.
struct Stretch<'a> {
    /// Every point.
    all: &'a [Point],
    /// Those that the spline goes through.
    kept: &'a [usize],
    tolerance: f64,
}

impl Stretch<'_> {
    fn at(&self, i: usize) -> Point {
        self.all[self.kept[i]]
    }

    /// Unit, from a kept point to the next, and how far.
    fn step(&self, i: usize) -> (Vec2, f64) {
        let way = self.at(i + 1) - self.at(i);
        let length = way.hypot().max(f64::MIN_POSITIVE);
        (way / length, length)
    }

    /// Whether the line is cut at the kept point `i`: at its ends it always is.
    fn is_corner(&self, i: usize) -> bool {
        let last = self.kept.len() - 1;
        i == 0 || i == last || self.step(i - 1).0.dot(self.step(i).0) < CORNER_COSINE
    }

    /// The tangent where a loop begins and ends, if there is no corner.
    fn seam(&self) -> Option<Vec2> {
        let last = self.kept.len() - 2;
        let is_smooth = last > 1 && self.step(last).0.dot(self.step(0).0) >= CORNER_COSINE;
        is_smooth.then(|| self.bessel(last, 0))
    }

    /// The tangent between two steps.
    fn bessel(&self, before: usize, after: usize) -> Vec2 {
        let ((into, into_length), (out, out_length)) = (self.step(before), self.step(after));
        unit(into * out_length + out * into_length, out)
    }

    /// Appends curves for the kept points from `first` to `last`, between which there is no corner. `seam` is
    /// the tangent at both ends of a loop.
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
            // To the bit, so that the path has no gaps.
            (cubic.p0, cubic.p3) = (self.at(from), self.at(to));
            // An arm of no length is a cusp to programs: arms as long as a spline's instead.
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
            // Twice as far each time, then halves: the farthest point that a cubic reaches, if nearer ones are reached.
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
                    // Points that were passed over for their nearness are points all the same.
                    reached = from + 1;
                    self.all[self.kept[from] + 1..=self.kept[reached]].iter().for_each(|point| path.line_to(*point));
                }
            }
            from = reached;
        }
    }

    /// Unit tangents at the kept points from `first` to `last`.
    fn tangents(&self, first: usize, last: usize, seam: Option<Vec2>) -> Vec<Vec2> {
        let mut tangents: Vec<Vec2> = Vec::with_capacity(last - first + 1);
        tangents.push(self.step(first).0);
        tangents.extend((first + 1..last).map(|i| self.bessel(i - 1, i)));
        tangents.push(self.step(last - 1).0);
        let end = tangents.len() - 1;
        if end > 1 {
            // The parabola that has the neighbour's tangent.
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

/// Whether kurbo would measure by arc length, to 1e-9: it does where the tangent turns by more than a fifth between two
/// of the places that it looks at. On a candidate with long arms that search does not end (kurbo 0.13), and one cubic
/// for such a turn is rarely near enough anyway.
fn turns_sharply(source: &impl ParamCurveFit, range: &Range<f64>) -> bool {
    // kurbo's numbers, with some room.
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

/// Whether a cubic is within `tolerance` of a polyline everywhere, and the polyline of the cubic. Both are walked along
/// together, so a distance may be taken for larger than it is, and never for smaller.
fn is_near(cubic: CubicBez, polyline: &[Point], tolerance: f64) -> bool {
    let step = STEP_PART * tolerance;
    let limit = MEASURED_PART * tolerance;
    let length = cubic.arclen(0.1 * step);
    let own: f64 = polyline.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    if !length.is_finite() || length > LONGER * own + 0.5 * tolerance {
        return false;
    }
    // Its derivative is no longer than three times the longest leg of its control polygon.
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

/// How many segments a walk looks ahead for one that is nearer.
const AHEAD: usize = 6;

/// Whether each of `places` is within `limit` of a segment of `line`, in order.
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

/// From a place to the segment between two points, squared.
fn squared_distance(place: Point, a: Point, b: Point) -> f64 {
    let way = b - a;
    let squared = way.hypot2();
    let t = if squared > 0.0 { ((place - a).dot(way) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (place - (a + way * t)).hypot2()
}
