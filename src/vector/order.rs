//! The order and direction in which a pen plotter draws strokes, so that its pen-up travel is short.
//!
//! A greedy pass goes from the pen's position to the nearest end of a remaining stroke, or to the nearest point of a
//! closed one, which ends where it begins. Then [`improve`](super::improve) shortens the tour. Finally each closed
//! stroke begins at the best point between the strokes before and after it. If the result is not shorter, the given
//! order is kept.

use super::grid::{Grid, distance};
use super::improve::{Stop, improve};
use crate::lines::strokes::polylines::Polyline;

/// A stroke in the tour: where it begins and in which direction it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Visit {
    /// Index of the stroke.
    pub stroke: usize,
    /// Whether the stroke is drawn from its last point to its first; always `false` for closed strokes.
    pub is_flipped: bool,
    /// Index of the point at which a closed stroke begins; 0 for open strokes.
    pub begin: usize,
}

impl Visit {
    /// Visits a stroke in its given direction, from its first point.
    pub(crate) fn as_is(stroke: usize) -> Self {
        Self { stroke, is_flipped: false, begin: 0 }
    }

    /// Returns the stroke with its points in drawing order; the first point of a closed stroke is not repeated.
    pub(crate) fn drawn(&self, strokes: &[&Polyline]) -> Polyline {
        let mut line = strokes[self.stroke].clone();
        line.points.rotate_left(self.begin);
        if self.is_flipped {
            line.points.reverse();
        }
        line
    }

    /// Returns where the pen goes down and where it goes up.
    fn ends(&self, strokes: &[&Polyline]) -> [[f64; 2]; 2] {
        let stroke = strokes[self.stroke];
        let at = |i: usize| stroke.points[i].px.map(f64::from);
        let last = stroke.points.len() - 1;
        match (stroke.is_closed, self.is_flipped) {
            (true, _) => [at(self.begin); 2],
            (false, false) => [at(0), at(last)],
            (false, true) => [at(last), at(0)],
        }
    }
}

/// Returns the length of the pen-up travel from `from` through all strokes, in pixels.
pub(crate) fn pen_up_px(strokes: &[&Polyline], visits: &[Visit], from: [f64; 2]) -> f64 {
    let mut at = from;
    let mut length = 0.0;
    for visit in visits {
        let [down, up] = visit.ends(strokes);
        length += distance(at, down);
        at = up;
    }
    length
}

/// Orders the strokes so that the pen-up travel from `from` is short, and never longer than in the given order. The
/// result contains each stroke once, except strokes without points, and depends only on the input.
pub(crate) fn order(strokes: &[&Polyline], from: [f64; 2]) -> Vec<Visit> {
    let given: Vec<Visit> = (0..strokes.len()).filter(|&i| !strokes[i].points.is_empty()).map(Visit::as_is).collect();
    let mut visits = greedy(strokes, from);
    let mut stops: Vec<Stop> = visits
        .iter()
        .map(|visit| Stop { ends: visit.ends(strokes), stroke: visit.stroke, is_flipped: false })
        .collect();
    improve(&mut stops, from);
    // The greedy visit of each stroke.
    let mut known = vec![Visit::as_is(0); strokes.len()];
    visits.iter().for_each(|visit| known[visit.stroke] = *visit);
    visits = stops
        .iter()
        .map(|stop| {
            let visit = known[stop.stroke];
            let turns = stop.is_flipped && !strokes[stop.stroke].is_closed;
            Visit { is_flipped: visit.is_flipped != turns, ..visit }
        })
        .collect();
    begin_well(strokes, &mut visits, from);
    if pen_up_px(strokes, &visits, from) < pen_up_px(strokes, &given, from) { visits } else { given }
}

fn greedy(strokes: &[&Polyline], from: [f64; 2]) -> Vec<Visit> {
    let mut ways: Vec<Visit> = Vec::new();
    for (i, stroke) in strokes.iter().enumerate() {
        match (stroke.points.len(), stroke.is_closed) {
            (0, _) => {}
            (count, true) => ways.extend((0..count).map(|begin| Visit { begin, ..Visit::as_is(i) })),
            (_, false) => ways.extend([false, true].map(|is_flipped| Visit { is_flipped, ..Visit::as_is(i) })),
        }
    }
    let places: Vec<[f64; 2]> = ways.iter().map(|way| way.ends(strokes)[0]).collect();
    let mut grid = Grid::new(&places);
    let mut is_left = vec![true; strokes.len()];
    let mut at = from;
    let mut visits = Vec::new();
    while let Some((way, _)) = grid.take_nearest(at, |way| is_left[ways[way as usize].stroke]) {
        let visit = ways[way as usize];
        is_left[visit.stroke] = false;
        at = visit.ends(strokes)[1];
        visits.push(visit);
    }
    visits
}

/// Makes each closed stroke begin at the point with the smallest detour between its neighbours.
fn begin_well(strokes: &[&Polyline], visits: &mut [Visit], from: [f64; 2]) {
    let mut before = from;
    for i in 0..visits.len() {
        let after = visits.get(i + 1).map(|next| next.ends(strokes)[0]);
        let visit = &mut visits[i];
        let stroke = strokes[visit.stroke];
        if stroke.is_closed {
            let detour = |place: [f64; 2]| distance(before, place) + after.map_or(0.0, |after| distance(place, after));
            let detours = stroke.points.iter().map(|point| detour(point.px.map(f64::from))).enumerate();
            // An equally good greedy choice is kept.
            let own = detour(visit.ends(strokes)[0]);
            let best = detours.min_by(|a, b| f64::total_cmp(&a.1, &b.1)).filter(|(_, detour)| *detour < own);
            visit.begin = best.map_or(visit.begin, |(begin, _)| begin);
        }
        before = visit.ends(strokes)[1];
    }
}
