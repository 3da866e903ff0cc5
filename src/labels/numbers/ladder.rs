//! Ladders: numbers of successive contour lines above each other on a slope.

use glam::DVec2;

use super::course::Estimate;
use super::judge::{Candidate, Map};
use super::taken::{Taken, misaligned};

/// Step along a slope line, in letter heights.
const STEP: f64 = 0.5;
/// Longest slope line between two numbers of a ladder, divided by the spacing of numbers.
const MAX_RISE: f64 = 0.7;
/// Farthest distance of a number from the slope line, in widths of its text.
const REACH: f64 = 1.25;
/// Number of windows near a slope line that are judged.
const TRIALS: usize = 3;
/// Cost of a number that is one width away from the slope line.
pub(super) const ASIDE: f64 = 1.6;
/// Numbers with a higher cost do not belong to a ladder.
const MAX_COST: f64 = 5.5;
/// Longest ladder, in numbers on one side of its seed.
const MAX_RUNGS: usize = 100;

/// Returns the numbers of a ladder through a seed, from the lowest to the highest.
pub(super) fn ladder(taken: &Taken<'_>, map: &Map<'_>, seed: Candidate) -> Vec<Candidate> {
    let mut rungs = climb(taken, map, &seed, -1.0);
    rungs.reverse();
    let above = climb(taken, map, &seed, 1.0);
    rungs.push(seed);
    rungs.extend(above);
    rungs
}

/// Returns the numbers above a seed (sign 1), or those below it (−1).
pub(super) fn climb(taken: &Taken<'_>, map: &Map<'_>, seed: &Candidate, sign: f64) -> Vec<Candidate> {
    let mut rungs: Vec<Candidate> = Vec::new();
    while rungs.len() < MAX_RUNGS {
        let last = rungs.last().unwrap_or(seed);
        let Some((course, along_px)) = next(map, last, sign) else { break };
        let Some(rung) = nearby(taken, map, last, course, along_px) else { break };
        rungs.push(rung);
    }
    rungs
}

/// Follows the slope line from a number to the next level, and returns the course and the arc length where it arrives.
fn next(map: &Map<'_>, from: &Candidate, sign: f64) -> Option<(usize, f64)> {
    let role = &map.courses[from.course].role;
    let rung = role.rung?;
    let step_px = STEP * map.page.letter_px;
    let steps = (MAX_RISE * map.rules.spacing_px / step_px) as usize;
    let [low, high] = map.page.corners_px;
    let mut at = from.frame.centre;
    let mut before = DVec2::ZERO;
    for step in 0..steps {
        if at.cmplt(low).any() || at.cmpgt(high).any() {
            return None;
        }
        let way = sign * map.uphill(at)?;
        if way.dot(before) < 0.0 {
            return None;
        }
        let end = at + step_px * way;
        // At its begin the slope line is on the line of the number.
        let skipped = (step == 0).then_some(role.line);
        if let Some((course, along_px)) = crossing(map, [at, end], skipped) {
            let is_next = map.courses[course].role.rung.is_some_and(|other| other.abs_diff(rung) == 1);
            return is_next.then_some((course, along_px));
        }
        (at, before) = (end, way);
    }
    None
}

/// Returns the first line with numbers in ladders that a segment crosses, and the arc length of the crossing.
fn crossing(map: &Map<'_>, [from, to]: [DVec2; 2], skipped: Option<usize>) -> Option<(usize, f64)> {
    let mut first: Option<(f64, usize, f64)> = None;
    map.segments.visit([from.min(to), from.max(to)], |point, line| {
        let Some(course) = map.course_of[line] else { return true };
        if skipped == Some(line) || map.courses[course].role.rung.is_none() {
            return true;
        }
        let [a, b] = map.paths.segment(point);
        let (way, own) = (to - from, b - a);
        let area = way.perp_dot(own);
        let [part, own_part] = [(a - from).perp_dot(own) / area, (a - from).perp_dot(way) / area];
        if (0.0..=1.0).contains(&part) && (0.0..=1.0).contains(&own_part) && first.is_none_or(|first| part < first.0) {
            first = Some((part, course, map.paths.along_px(point) + own_part * own.length()));
        }
        true
    });
    first.map(|(_, course, along_px)| (course, along_px))
}

/// Returns the best number near an arc length that continues a ladder.
fn nearby(taken: &Taken<'_>, map: &Map<'_>, last: &Candidate, course: usize, along_px: f64) -> Option<Candidate> {
    let width_px = map.courses[course].role.width_px;
    let aside = |estimate: &Estimate| ASIDE * misaligned(&last.frame, &estimate.frame, width_px);
    let estimated = map.courses[course].around(along_px, REACH * width_px).filter_map(|window| {
        let estimate = map.estimate(course, window)?;
        Some((estimate.cost + aside(&estimate), window))
    });
    let estimated = estimated.filter(|(cost, _)| *cost < MAX_COST).collect();
    cheapest(estimated, TRIALS, |window| {
        let candidate = map.judge(course, window)?;
        let cost = candidate.cost + ASIDE * misaligned(&last.frame, &candidate.frame, width_px);
        let is_apart = || taken.spacing(course, candidate.frame.centre, None) >= 1.0;
        (cost < MAX_COST && is_apart() && taken.is_free(&candidate, None)).then_some((cost, candidate))
    })
}

/// Returns the cheapest of the candidates that `judge` finds with their costs, for windows with estimated costs. Only
/// the first `trials` windows in the order of their estimates are judged, and only while the estimates are less than
/// the cost found: nothing costs less than estimated, except by rounding.
pub(super) fn cheapest(
    mut estimated: Vec<(f64, usize)>,
    trials: usize,
    mut judge: impl FnMut(usize) -> Option<(f64, Candidate)>,
) -> Option<Candidate> {
    estimated.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut best: Option<(f64, Candidate)> = None;
    for (estimate, window) in estimated.into_iter().take(trials) {
        if best.as_ref().is_some_and(|best| best.0 <= estimate) {
            break;
        }
        if let Some(found) = judge(window)
            && best.as_ref().is_none_or(|best| found.0 < best.0)
        {
            best = Some(found);
        }
    }
    best.map(|(_, candidate)| candidate)
}
