//! Traces contour lines by marching squares.

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::form::Form;

/// Lines for each pixel of a cell from which on they are certainly too close to be drawn, index lines included.
const CROWDED_PER_PX: f64 = 8.0;

/// A contour line.
pub(super) struct Traced {
    /// Number of the level: the height is this many intervals.
    pub level: i64,
    /// Points in pixels. A closed line does not repeat its first point.
    pub points: Vec<DVec2>,
    pub is_closed: bool,
}

/// A square between four nodes of a [`Form`].
pub(super) struct Cell {
    /// Heights of the upper left, upper right, lower right and lower left node, in metres.
    pub heights_m: [f64; 4],
    /// Change of the height per pixel, in metres.
    pub rise_m: f64,
}

/// An edge between two nodes: twice the index of its first node, and 1 more if it leads down and not to the right.
type Edge = usize;

/// A piece of a line from edge to edge of a cell.
type Piece = [Edge; 2];

/// Returns the contour lines of a form at multiples of an interval. They end at cells without land, and at cells that
/// `is_drawn` excludes for a level.
pub(super) fn lines(form: &Form, interval_m: f64, is_drawn: impl Fn(&Cell, i64) -> bool) -> Vec<Traced> {
    let [columns, rows] = form.size;
    let mut levels: FxHashMap<i64, Vec<Piece>> = FxHashMap::default();
    for y in 0..rows.saturating_sub(1) {
        for x in 0..columns.saturating_sub(1) {
            let first = y * columns + x;
            let nodes = [first, first + 1, first + columns + 1, first + columns];
            let heights_m = nodes.map(|node| form.heights_m[node]);
            // NaN is in neither of the two.
            if !heights_m.iter().all(|height_m| height_m.is_finite()) {
                continue;
            }
            let [a, b, c, d] = heights_m;
            let rise_m = DVec2::new(b - a + c - d, d - a + c - b).length() / (2.0 * form.step_px);
            let cell = Cell { heights_m, rise_m };
            let lowest = heights_m.into_iter().fold(f64::INFINITY, f64::min);
            let highest = heights_m.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let [from, to] = [(lowest / interval_m).floor() as i64 + 1, (highest / interval_m).floor() as i64];
            if (to - from) as f64 > CROWDED_PER_PX * form.step_px {
                continue;
            }
            for level in (from..=to).filter(|level| is_drawn(&cell, *level)) {
                let edges = [2 * first, 2 * nodes[1] + 1, 2 * nodes[3], 2 * first + 1];
                let pieces = pieces(heights_m, level as f64 * interval_m, edges);
                levels.entry(level).or_default().extend(pieces.into_iter().flatten());
            }
        }
    }
    let mut levels: Vec<(i64, Vec<Piece>)> = levels.into_iter().collect();
    levels.sort_unstable_by_key(|(level, _)| *level);
    levels
        .iter()
        .flat_map(|(level, pieces)| {
            let height_m = *level as f64 * interval_m;
            joined(pieces).into_iter().map(move |(edges, is_closed)| Traced {
                level: *level,
                points: edges.into_iter().map(|edge| crossing(form, edge, height_m)).collect(),
                is_closed,
            })
        })
        .collect()
}

/// Returns the pieces of the line of a height in a cell. `edges` are those above, to the right, below and to the left.
fn pieces(heights_m: [f64; 4], height_m: f64, edges: [Edge; 4]) -> [Option<Piece>; 2] {
    let is_above = heights_m.map(|own_m| own_m >= height_m);
    let crossed: Vec<usize> = (0..4).filter(|edge| is_above[*edge] != is_above[(edge + 1) % 4]).collect();
    match crossed[..] {
        [from, to] => [Some([edges[from], edges[to]]), None],
        [_, _, _, _] => {
            // A saddle: the mean height decides which two corners are connected.
            let is_middle_above = heights_m.iter().sum::<f64>() / 4.0 >= height_m;
            let [first, second] = if is_middle_above == is_above[0] { [[0, 1], [2, 3]] } else { [[3, 0], [1, 2]] };
            [first, second].map(|piece| Some(piece.map(|edge| edges[edge])))
        }
        _ => [None, None],
    }
}

/// Joins pieces to lines, and returns whether each is closed. The order follows from that of the pieces.
fn joined(pieces: &[Piece]) -> Vec<(Vec<Edge>, bool)> {
    let mut at_edge: FxHashMap<Edge, [Option<usize>; 2]> = FxHashMap::default();
    for (number, edge) in pieces.iter().enumerate().flat_map(|(number, piece)| piece.map(|edge| (number, edge))) {
        let known = at_edge.entry(edge).or_default();
        if known[0].is_none() { known[0] = Some(number) } else { known[1] = Some(number) }
    }
    let mut is_used = vec![false; pieces.len()];
    let mut walk = |first: usize, from: Edge| {
        let (mut line, mut next) = (vec![from], Some(first));
        let mut at = from;
        while let Some(piece) = next.filter(|piece| !is_used[*piece]) {
            is_used[piece] = true;
            at = if pieces[piece][0] == at { pieces[piece][1] } else { pieces[piece][0] };
            line.push(at);
            next = at_edge[&at].into_iter().flatten().find(|other| *other != piece);
        }
        let is_closed = line.len() > 2 && at == from;
        if is_closed {
            line.pop();
        }
        (line, is_closed)
    };
    let ends = pieces.iter().enumerate().flat_map(|(number, piece)| piece.map(|edge| (number, edge)));
    let ends: Vec<(usize, Edge)> = ends.filter(|(_, edge)| at_edge[edge][1].is_none()).collect();
    let open = ends.into_iter().map(|(number, edge)| walk(number, edge)).filter(|(line, _)| line.len() > 1);
    let mut lines: Vec<(Vec<Edge>, bool)> = open.collect();
    let closed = (0..pieces.len()).map(|number| walk(number, pieces[number][0])).filter(|(line, _)| line.len() > 1);
    lines.extend(closed);
    lines
}

/// Returns where a height is on an edge, in pixels.
fn crossing(form: &Form, edge: Edge, height_m: f64) -> DVec2 {
    let columns = form.size[0];
    let (node, leads_down) = (edge / 2, edge % 2 == 1);
    let other = node + if leads_down { columns } else { 1 };
    let [from_m, to_m] = [node, other].map(|node| form.heights_m[node]);
    let part = ((height_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0);
    let first = DVec2::new((node % columns) as f64, (node / columns) as f64);
    form.px(first + part * if leads_down { DVec2::Y } else { DVec2::X })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the form of a function of the position in pixels.
    fn form(height_m: impl Fn(DVec2) -> f64) -> Form {
        let size = [41, 31];
        let mut form = Form { size, first_px: DVec2::new(5.0, 7.0), step_px: 2.0, heights_m: Vec::new() };
        let nodes = (0..31).flat_map(|y| (0..41).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        form.heights_m = nodes.map(|at| height_m(form.px(at))).collect();
        form
    }

    #[test]
    fn rings_are_closed_and_at_their_height() {
        let height_m = |at: DVec2| 100.0 - at.distance(DVec2::new(45.3, 36.7));
        let found = lines(&form(height_m), 10.0, |_, _| true);
        let rings: Vec<&Traced> = found.iter().filter(|line| line.is_closed).collect();
        assert_eq!(rings.iter().map(|line| line.level).collect::<Vec<_>>(), [8, 9]);
        for line in &found {
            let is_at_height = |at: &DVec2| (height_m(*at) - 10.0 * line.level as f64).abs() < 0.2;
            assert!(line.points.iter().all(is_at_height), "{}", line.level);
            // Neighbouring points are in the same cell.
            assert!(line.points.windows(2).all(|pair| pair[0].distance(pair[1]) < 3.0));
        }
        // Rings that leave the area are several open lines.
        assert!(found.iter().filter(|line| line.level == 6).count() > 1);
        assert!(found.iter().all(|line| line.is_closed || line.level < 8));
    }

    #[test]
    fn lines_end_where_there_is_no_land() {
        let plane = |at: DVec2| if (40.0..50.0).contains(&at.x) { f64::NAN } else { at.y };
        let found = lines(&form(plane), 10.0, |_, _| true);
        assert_eq!(found.iter().filter(|line| line.level == 3).count(), 2);
        // Cells that are excluded for one level.
        let found = lines(&form(|at| at.y), 10.0, |_, level| level != 3);
        assert_eq!(found.iter().map(|line| line.level).collect::<Vec<_>>(), [1, 2, 4, 5, 6]);
    }

    #[test]
    fn saddles_have_two_lines() {
        let found = lines(&form(|at| 0.1 * (at.x - 45.1) * (at.y - 37.1) + 0.3), 1000.0, |_, level| level == 0);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|line| !line.is_closed && line.points.len() > 30));
    }
}
