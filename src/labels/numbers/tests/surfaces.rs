//! Surfaces for tests, and their contour lines by marching squares.

use glam::DVec2;
use rustc_hash::FxHashMap;

use crate::labels::numbers::{Contour, Every, Page, Rules, Tops, metres};

/// Height of the digits in the tests, in pixels.
pub(super) const LETTER_PX: f64 = 10.0;

/// Returns the width of a text in the tests, in pixels.
pub(super) fn width_px(text: &str) -> f64 {
    0.8 * LETTER_PX * text.chars().count() as f64
}

/// A contour line with its text.
#[derive(Clone, Debug)]
pub(super) struct Traced {
    pub points: Vec<DVec2>,
    pub is_closed: bool,
    pub level_m: f64,
    pub is_index: bool,
    pub is_depth: bool,
    pub text: String,
}

/// A page with the contour lines of a surface.
pub(super) struct Scene<F: Fn(DVec2) -> f64> {
    pub height_m: F,
    pub size_px: DVec2,
    pub lines: Vec<Traced>,
    pub obstacles_px: Vec<[DVec2; 2]>,
    pub rules: Rules,
}

impl<F: Fn(DVec2) -> f64> Scene<F> {
    /// Traces contour lines at multiples of an interval; every fifth is an index contour.
    pub(super) fn new(size_px: [f64; 2], interval_m: f64, height_m: F) -> Self {
        let size_px = DVec2::from_array(size_px);
        let lines = traced(&height_m, size_px, 4.0, interval_m);
        let rules = Rules { every: Every::Index, tops: Tops::Uphill, spacing_px: 250.0 };
        Self { height_m, size_px, lines, obstacles_px: Vec::new(), rules }
    }

    pub(super) fn contours(&self) -> Vec<Contour<'_>> {
        contours(&self.lines)
    }

    /// Calls a function with the page.
    pub(super) fn with_page<T>(&self, f: impl FnOnce(&Page<'_>) -> T) -> T {
        let uphill = |at| gradient(&self.height_m, at);
        f(&Page {
            corners_px: [DVec2::ZERO, self.size_px],
            obstacles_px: &self.obstacles_px,
            letter_px: LETTER_PX,
            width_px: &width_px,
            uphill: &uphill,
        })
    }
}

pub(super) fn contours(lines: &[Traced]) -> Vec<Contour<'_>> {
    lines.iter().map(contour).collect()
}

fn contour(line: &Traced) -> Contour<'_> {
    Contour {
        points: &line.points,
        is_closed: line.is_closed,
        level_m: line.level_m,
        is_index: line.is_index,
        is_depth: line.is_depth,
        text: &line.text,
    }
}

fn gradient(height_m: &impl Fn(DVec2) -> f64, at: DVec2) -> Option<DVec2> {
    let by = |way: DVec2| height_m(at + way) - height_m(at - way);
    DVec2::new(by(DVec2::X), by(DVec2::Y)).try_normalize()
}

/// Traces the contour lines of a surface on a grid.
pub(super) fn traced(height_m: &impl Fn(DVec2) -> f64, size_px: DVec2, step_px: f64, interval_m: f64) -> Vec<Traced> {
    let [columns, rows] = [size_px.x, size_px.y].map(|side| (side / step_px) as usize + 1);
    let at = |x: usize, y: usize| step_px * DVec2::new(x as f64, y as f64);
    // Heights exactly at a level would touch it without a crossing.
    let heights: Vec<f64> =
        (0..rows * columns).map(|i| height_m(at(i % columns, i / columns)) + 1e-7 * interval_m).collect();
    let [low, high] = [f64::min, f64::max].map(|pick| heights.iter().copied().reduce(pick).unwrap_or(0.0));
    let mut lines = Vec::new();
    for index in (low / interval_m).ceil() as i64..=(high / interval_m).floor() as i64 {
        let level_m = index as f64 * interval_m;
        let point = |edge: usize| {
            let (vertex, is_down) = (edge / 2, edge % 2 == 1);
            let other = if is_down { vertex + columns } else { vertex + 1 };
            let part = (level_m - heights[vertex]) / (heights[other] - heights[vertex]);
            at(vertex % columns, vertex / columns).lerp(at(other % columns, other / columns), part)
        };
        let segments = segments(&heights, [columns, rows], level_m);
        lines.extend(chains(&segments).into_iter().map(|(edges, is_closed)| Traced {
            points: edges.into_iter().map(point).collect(),
            is_closed,
            level_m,
            is_index: index % 5 == 0,
            is_depth: false,
            text: metres(level_m, false),
        }));
    }
    lines
}

/// Returns the segments of a level between edges of the grid. An edge begins at a vertex and goes right (even) or down
/// (odd).
fn segments(heights: &[f64], [columns, rows]: [usize; 2], level_m: f64) -> Vec<[usize; 2]> {
    let mut segments = Vec::new();
    for y in 0..rows - 1 {
        for x in 0..columns - 1 {
            let a = y * columns + x;
            let corners = [a, a + 1, a + columns + 1, a + columns];
            let is_above = corners.map(|corner| heights[corner] > level_m);
            let edges = [2 * a, 2 * (a + 1) + 1, 2 * (a + columns), 2 * a + 1];
            let crossed: Vec<usize> = (0..4).filter(|i| is_above[*i] != is_above[(i + 1) % 4]).collect();
            match crossed[..] {
                [from, to] => segments.push([edges[from], edges[to]]),
                [_, _, _, _] => {
                    let center = 0.25 * corners.iter().map(|corner| heights[*corner]).sum::<f64>();
                    // In a saddle, the corners on the side of the center are joined.
                    let turn = if (center > level_m) == is_above[0] { 0 } else { 3 };
                    segments.push([edges[turn], edges[(turn + 1) % 4]]);
                    segments.push([edges[(turn + 2) % 4], edges[(turn + 3) % 4]]);
                }
                _ => {}
            }
        }
    }
    segments
}

/// Joins segments to lines.
fn chains(segments: &[[usize; 2]]) -> Vec<(Vec<usize>, bool)> {
    let mut of_edge: FxHashMap<usize, Vec<usize>> = FxHashMap::default();
    for (i, segment) in segments.iter().enumerate() {
        segment.iter().for_each(|edge| of_edge.entry(*edge).or_default().push(i));
    }
    let mut is_done = vec![false; segments.len()];
    let mut walk = |first: usize, from: usize| {
        let (mut edges, mut at, mut segment) = (vec![from], from, Some(first));
        while let Some(own) = segment {
            is_done[own] = true;
            at = if segments[own][0] == at { segments[own][1] } else { segments[own][0] };
            edges.push(at);
            segment = of_edge[&at].iter().copied().find(|next| !is_done[*next]);
        }
        edges
    };
    let mut chains = Vec::new();
    let ends = segments.iter().enumerate().flat_map(|(i, segment)| segment.iter().map(move |edge| (i, *edge)));
    let mut seen = vec![false; segments.len()];
    for (i, edge) in ends.filter(|(_, edge)| of_edge[edge].len() == 1) {
        if !seen[i] {
            let chain = walk(i, edge);
            chain.iter().for_each(|edge| of_edge[edge].iter().for_each(|own| seen[*own] = true));
            chains.push((chain, false));
        }
    }
    for i in 0..segments.len() {
        if !seen[i] {
            let mut chain = walk(i, segments[i][0]);
            chain.iter().for_each(|edge| of_edge[edge].iter().for_each(|own| seen[*own] = true));
            chain.pop();
            chains.push((chain, true));
        }
    }
    chains
}
