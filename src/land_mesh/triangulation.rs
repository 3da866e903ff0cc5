//! Triangulates heights greedily: starts with two triangles and inserts, again and again, the point with the largest
//! error into a Delaunay triangulation (Garland and Heckbert 1995, "Fast polygonal approximation of terrains and height
//! fields"; the data structure with half-edges follows Agarwala's `delatin`). A point without land in a triangle over
//! land, or the other way round, counts as an infinite error, so that no triangle covers both.
//!
//! All predicates are exact, because points are whole numbers.

use std::collections::BinaryHeap;

use glam::{I64Vec2, UVec2};

use super::lattice::Lattice;

/// Largest number of triangles.
pub(crate) const MAX_TRIANGLES: usize = 10_000_000;

/// The index that stands for no half-edge.
const NONE: u32 = u32::MAX;

/// The reason why there is no triangulation.
#[derive(Debug, thiserror::Error)]
#[error(
    "more than {MAX_TRIANGLES} triangles would be needed, and {error_m:.3} m were reached; use a larger --mesh-error or \
     --map=EAST,NORTH,WIDTH with less land"
)]
pub(crate) struct TooManyTriangles {
    /// The error that was reached; infinite if the borders of the land were not found yet.
    pub error_m: f64,
}

/// Triangles that cover a lattice.
pub(crate) struct Triangulated {
    /// The corners, as points of the lattice.
    pub points: Vec<UVec2>,
    /// Clockwise if y runs up. Triangles over land have land at all corners, and others at fewer.
    pub triangles: Vec<[u32; 3]>,
    /// Largest distance of a point over land from its triangle, along the vertical, in metres.
    pub error_m: f64,
}

/// Triangulates a lattice with an error of at most `max_error_m`.
///
/// # Errors
/// Fails if more than [`MAX_TRIANGLES`] would be needed.
pub(crate) fn triangulate(lattice: &Lattice, max_error_m: f64) -> Result<Triangulated, TooManyTriangles> {
    triangulate_within(lattice, max_error_m, MAX_TRIANGLES)
}

/// Does the same as [`triangulate`] for another largest number.
pub(super) fn triangulate_within(
    lattice: &Lattice,
    max_error_m: f64,
    max_triangles: usize,
) -> Result<Triangulated, TooManyTriangles> {
    let mut net = Net::new(lattice);
    let error_m = loop {
        match net.worst() {
            Some(worst) if worst.error_m > max_error_m as f32 => {
                if net.triangle_count() > max_triangles {
                    return Err(TooManyTriangles { error_m: worst.error_m.into() });
                }
                net.insert(&worst);
            }
            worst => break worst.map_or(0.0, |worst| f64::from(worst.error_m)),
        }
    };
    let triangles = net.corners.chunks_exact(3).map(|own| [own[0], own[1], own[2]]).collect();
    Ok(Triangulated { points: net.points, triangles, error_m })
}

/// The worst point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    error_m: f32,
    triangle: u32,
    /// Number of the triangle's last change; another number means that this candidate is outdated.
    change: u32,
    point: UVec2,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.error_m.total_cmp(&other.error_m).then(other.triangle.cmp(&self.triangle))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A Delaunay triangulation. Half-edge `3 t + i` runs from corner `i` of triangle `t` to the next one.
struct Net<'a> {
    lattice: &'a Lattice,
    points: Vec<UVec2>,
    /// For each half-edge, the point from which it starts.
    corners: Vec<u32>,
    /// For each half-edge, the one on its other side, or [`NONE`].
    twins: Vec<u32>,
    /// For each triangle, the number of its changes.
    changes: Vec<u32>,
    queue: BinaryHeap<Candidate>,
    /// Triangles without a candidate of their current form.
    pending: Vec<u32>,
}

impl<'a> Net<'a> {
    fn new(lattice: &'a Lattice) -> Self {
        let last = lattice.last();
        let points = vec![UVec2::ZERO, UVec2::new(last.x, 0), UVec2::new(0, last.y), last];
        let mut net = Self {
            lattice,
            points,
            corners: Vec::new(),
            twins: Vec::new(),
            changes: Vec::new(),
            queue: BinaryHeap::new(),
            pending: Vec::new(),
        };
        let first = net.put([3, 0, 2], [NONE; 3], None);
        net.put([0, 3, 1], [first, NONE, NONE], None);
        net.find_candidates();
        net
    }

    fn triangle_count(&self) -> usize {
        self.changes.len()
    }

    /// Removes and returns the worst candidate, if any triangle has one.
    fn worst(&mut self) -> Option<Candidate> {
        loop {
            let worst = self.queue.pop()?;
            if self.changes[worst.triangle as usize] == worst.change {
                return Some(worst);
            }
        }
    }

    /// Inserts the point of a candidate.
    fn insert(&mut self, candidate: &Candidate) {
        let point = self.points.len() as u32;
        self.points.push(candidate.point);
        let first = candidate.triangle * 3;
        let [a, b, c] = [0, 1, 2].map(|i| self.corners[(first + i) as usize]);
        let at = candidate.point.as_i64vec2();
        let [pa, pb, pc] = [a, b, c].map(|corner| self.at(corner));
        if orient(pa, pb, at) == 0 {
            self.split_edge(point, first);
        } else if orient(pb, pc, at) == 0 {
            self.split_edge(point, first + 1);
        } else if orient(pc, pa, at) == 0 {
            self.split_edge(point, first + 2);
        } else {
            let [ab, bc, ca] = [0, 1, 2].map(|i| self.twins[(first + i) as usize]);
            let t0 = self.put([a, b, point], [ab, NONE, NONE], Some(first));
            let t1 = self.put([b, c, point], [bc, NONE, t0 + 1], None);
            let t2 = self.put([c, a, point], [ca, t0 + 2, t1 + 1], None);
            self.legalize(vec![t0, t1, t2]);
        }
        self.find_candidates();
    }

    /// Splits the edge `a` and the triangles at it, by a point on the edge.
    fn split_edge(&mut self, point: u32, a: u32) {
        let [al, ar] = [next(a), before(a)];
        let [p0, pr, pl] = [ar, a, al].map(|edge| self.corners[edge as usize]);
        let [hal, har, b] = [al, ar, a].map(|edge| self.twins[edge as usize]);
        let a0 = a - a % 3;
        if b == NONE {
            let t0 = self.put([point, p0, pr], [NONE, har, NONE], Some(a0));
            let t1 = self.put([p0, point, pl], [t0, NONE, hal], None);
            return self.legalize(vec![t0 + 1, t1 + 2]);
        }
        let (b0, bl, br) = (b - b % 3, before(b), next(b));
        let p1 = self.corners[bl as usize];
        let [hbl, hbr] = [bl, br].map(|edge| self.twins[edge as usize]);
        let t0 = self.put([p0, pr, point], [har, NONE, NONE], Some(a0));
        let t1 = self.put([pr, p1, point], [hbr, NONE, t0 + 1], Some(b0));
        let t2 = self.put([p1, pl, point], [hbl, NONE, t1 + 1], None);
        let t3 = self.put([pl, p0, point], [hal, t0 + 2, t2 + 1], None);
        self.legalize(vec![t0, t1, t2, t3]);
    }

    /// Flips edges until the triangles at them are Delaunay's. Each flip makes the triangulation more Delaunay, so it
    /// ends.
    fn legalize(&mut self, mut edges: Vec<u32>) {
        while let Some(a) = edges.pop() {
            let b = self.twins[a as usize];
            if b == NONE {
                continue;
            }
            let [al, ar, bl, br] = [next(a), before(a), before(b), next(b)];
            let [p0, pr, pl, p1] = [ar, a, al, bl].map(|edge| self.corners[edge as usize]);
            if !in_circle([p0, pr, pl].map(|corner| self.at(corner)), self.at(p1)) {
                continue;
            }
            let [hal, har, hbl, hbr] = [al, ar, bl, br].map(|edge| self.twins[edge as usize]);
            let t0 = self.put([p0, p1, pl], [NONE, hbl, hal], Some(a - a % 3));
            let t1 = self.put([p1, p0, pr], [t0, har, hbr], Some(b - b % 3));
            edges.extend([t0 + 1, t1 + 2]);
        }
    }

    /// Puts a triangle at the place of an existing one, or at the end, and returns its first half-edge.
    fn put(&mut self, corners: [u32; 3], twins: [u32; 3], first: Option<u32>) -> u32 {
        let first = first.unwrap_or_else(|| {
            self.corners.extend([NONE; 3]);
            self.twins.extend([NONE; 3]);
            self.changes.push(0);
            self.corners.len() as u32 - 3
        });
        for i in 0..3 {
            self.corners[first as usize + i] = corners[i];
            self.twins[first as usize + i] = twins[i];
            if twins[i] != NONE {
                self.twins[twins[i] as usize] = first + i as u32;
            }
        }
        self.changes[first as usize / 3] += 1;
        self.pending.push(first / 3);
        first
    }

    fn at(&self, point: u32) -> I64Vec2 {
        self.points[point as usize].as_i64vec2()
    }

    /// Finds the worst point of each triangle that has changed.
    fn find_candidates(&mut self) {
        let mut pending = std::mem::take(&mut self.pending);
        pending.sort_unstable();
        pending.dedup();
        for triangle in pending.drain(..) {
            let corners = [0, 1, 2].map(|i| self.points[self.corners[3 * triangle as usize + i] as usize]);
            let (error_m, point) = worst_point(self.lattice, corners);
            if error_m > 0.0 {
                self.queue.push(Candidate { error_m, triangle, change: self.changes[triangle as usize], point });
            }
        }
        self.pending = pending;
    }
}

fn next(edge: u32) -> u32 {
    edge - edge % 3 + (edge + 1) % 3
}

fn before(edge: u32) -> u32 {
    edge - edge % 3 + (edge + 2) % 3
}

/// Returns twice the area of a triangle; it is above 0 for the order of the triangulation.
fn orient(a: I64Vec2, b: I64Vec2, c: I64Vec2) -> i64 {
    (b.x - c.x) * (a.y - c.y) - (b.y - c.y) * (a.x - c.x)
}

/// Returns whether a point is inside of the circle through three others.
fn in_circle([a, b, c]: [I64Vec2; 3], point: I64Vec2) -> bool {
    // The products have up to five factors of 2²⁶, which need more than 64 bits.
    let [d, e, f] = [a - point, b - point, c - point].map(|way| [i128::from(way.x), i128::from(way.y)]);
    let [ap, bp, cp] = [d, e, f].map(|[x, y]| x * x + y * y);
    d[0] * (e[1] * cp - bp * f[1]) - d[1] * (e[0] * cp - bp * f[0]) + ap * (e[0] * f[1] - e[1] * f[0]) < 0
}

/// Returns the largest error of a point in a triangle, and the point; an infinite error where land meets no land, and
/// then the point nearest to the triangle's middle. The corners do not count.
fn worst_point(lattice: &Lattice, corners: [UVec2; 3]) -> (f32, UVec2) {
    let [a, b, c] = corners.map(|corner| corner.as_i64vec2());
    let heights_m = corners.map(|corner| lattice.height_m(corner));
    // The plane through the corners: its height at `a`, and its rise along both axes.
    let plane = match heights_m {
        [Some(za), Some(zb), Some(zc)] => {
            let (ab, ac) = ((b - a).as_dvec2(), (c - a).as_dvec2());
            let area = ab.perp_dot(ac);
            Some((za, ((zb - za) * ac.y - (zc - za) * ab.y) / area, ((zc - za) * ab.x - (zb - za) * ac.x) / area))
        }
        _ => None,
    };
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let (mut worst, mut at) = (0.0_f32, corners[0]);
    let mut nearest = i64::MAX;
    for y in low.y..=high.y {
        let Some([from, to]) = span([a, b, c], y, [low.x, high.x]) else { continue };
        let row = &lattice.row(y as u32)[from as usize..=to as usize];
        for (x, height_m) in (from..).zip(row) {
            let point = I64Vec2::new(x, y);
            let error_m = match plane {
                Some((za, rise_x, rise_y)) if !height_m.is_nan() => {
                    let way = (point - a).as_dvec2();
                    (za + rise_x * way.x + rise_y * way.y - f64::from(*height_m)).abs() as f32
                }
                // No land in a triangle without.
                None if height_m.is_nan() => continue,
                _ => f32::INFINITY,
            };
            if error_m < worst || [a, b, c].contains(&point) {
                continue;
            }
            if error_m.is_infinite() {
                let way = 3 * point - (a + b + c);
                let far = way.dot(way);
                if far >= nearest {
                    continue;
                }
                nearest = far;
            } else if error_m <= worst {
                continue;
            }
            (worst, at) = (error_m, point.as_uvec2());
        }
    }
    (worst, at)
}

/// Returns the first and the last column of a triangle in a row, between `low` and `high`.
fn span([a, b, c]: [I64Vec2; 3], y: i64, [low, high]: [i64; 2]) -> Option<[i64; 2]> {
    let (mut from, mut to) = (low, high);
    for (a, b) in [(a, b), (b, c), (c, a)] {
        // orient(a, b, point) = slope x + rest, which is not negative inside.
        let slope = b.y - a.y;
        let rest = y * (a.x - b.x) + b.x * a.y - b.y * a.x;
        match slope {
            0 if rest < 0 => return None,
            0 => {}
            1.. => from = from.max((-rest).div_euclid(slope) + i64::from((-rest).rem_euclid(slope) != 0)),
            _ => to = to.min(rest.div_euclid(-slope)),
        }
    }
    (from <= to).then_some([from, to])
}
