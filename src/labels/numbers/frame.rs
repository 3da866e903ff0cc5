//! The centre line of a number: a straight line or an arc of a circle, and coordinates along it and across it.

use glam::DVec2;

/// A curved number is divided into quadrilaterals, each of which turns by at most this angle, in radians.
const QUAD_TURN: f64 = 0.2;
/// Arcs with a smaller curvature, in radians per pixel, are straight.
const STRAIGHT: f64 = 1e-9;

/// A line through `centre` whose direction is `along` there and turns by `bend` per pixel.
///
/// Local coordinates are (u, v): u is the distance along the line from `centre`, and v is the distance to its right,
/// which is below a text that runs along the line. y of the page goes down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub centre: DVec2,
    /// Unit direction of the line at its centre.
    pub along: DVec2,
    /// Curvature, in radians per pixel, clockwise; 0 for a straight line.
    pub bend: f64,
}

/// A convex quadrilateral.
pub(super) type Quad = [DVec2; 4];

impl Frame {
    /// Returns the direction of the line at a distance from the centre.
    pub(super) fn direction(&self, u: f64) -> DVec2 {
        if self.bend == 0.0 { self.along } else { self.along.rotate(DVec2::from_angle(self.bend * u)) }
    }

    /// Returns the point of the page at local coordinates.
    pub(super) fn point(&self, u: f64, v: f64) -> DVec2 {
        let along = self.along;
        let on_line = if self.bend.abs() < STRAIGHT {
            u * along
        } else {
            let turn = self.bend * u;
            (turn.sin() * along + (1.0 - turn.cos()) * along.perp()) / self.bend
        };
        self.centre + on_line + v * self.direction(u).perp()
    }

    /// Returns the local coordinates of a point of the page.
    pub(super) fn local(&self, point: DVec2) -> DVec2 {
        let [x, y] = [(point - self.centre).dot(self.along), self.along.perp_dot(point - self.centre)];
        if self.bend.abs() < STRAIGHT {
            return DVec2::new(x, y);
        }
        let radius = 1.0 / self.bend;
        let [side, across] = [radius.signum(), radius - y];
        DVec2::new((side * x).atan2(side * across) * radius, radius - side * x.hypot(across))
    }

    /// Returns the same line in the opposite direction.
    pub(super) fn reversed(&self) -> Self {
        Self { along: -self.along, bend: -self.bend, ..*self }
    }

    /// Returns quadrilaterals that cover the strip of a length and a height around the line.
    pub(super) fn quads(&self, length_px: f64, height_px: f64) -> Vec<Quad> {
        let count = ((self.bend * length_px).abs() / QUAD_TURN).ceil().clamp(1.0, 64.0);
        let v = 0.5 * height_px;
        let quad = |i: usize| {
            let [from, to] = [i, i + 1].map(|i| length_px * (i as f64 / count - 0.5));
            [self.point(from, -v), self.point(to, -v), self.point(to, v), self.point(from, v)]
        };
        (0..count as usize).map(quad).collect()
    }
}

/// Returns whether two convex quadrilaterals overlap (separating axes; Gottschalk and others 1996).
pub(super) fn overlap(a: &Quad, b: &Quad) -> bool {
    let separates = |own: &Quad, other: &Quad| {
        (0..4).any(|i| {
            let axis = (own[(i + 1) % 4] - own[i]).perp();
            let [own, other] = [own, other].map(|quad| extent(quad, axis));
            own[1] < other[0] || other[1] < own[0]
        })
    };
    !separates(a, b) && !separates(b, a)
}

fn extent(quad: &Quad, axis: DVec2) -> [f64; 2] {
    let along = quad.map(|corner| corner.dot(axis));
    [along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// Returns the bounding box of quadrilaterals.
pub(super) fn bounds(quads: &[Quad]) -> [DVec2; 2] {
    let corners = || quads.iter().flatten().copied();
    [corners().fold(DVec2::INFINITY, DVec2::min), corners().fold(DVec2::NEG_INFINITY, DVec2::max)]
}

/// Returns the smallest distance from the axis u at which a segment in local coordinates passes through the strip
/// |u| ≤ `half.x`, |v| ≤ `half.y`, or `None` if it misses the strip (clipping after Liang and Barsky 1984).
pub(super) fn pass(a: DVec2, b: DVec2, half: DVec2) -> Option<f64> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let way = b - a;
    for (start, step, limit) in [(a.x, way.x, half.x), (a.y, way.y, half.y)] {
        if step == 0.0 {
            if start.abs() > limit {
                return None;
            }
            continue;
        }
        let [first, second] = [(-limit - start) / step, (limit - start) / step];
        from = from.max(first.min(second));
        to = to.min(first.max(second));
    }
    if from > to {
        return None;
    }
    let [begin, end] = [a.y + from * way.y, a.y + to * way.y];
    Some(if begin * end <= 0.0 { 0.0 } else { begin.abs().min(end.abs()) })
}
