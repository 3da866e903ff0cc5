//! Chooses the numbers among the possible positions.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::Number;
use super::frame::Frame;
use super::judge::{Candidate, Map};
use super::ladder::{ASIDE, cheapest, climb, ladder};
use super::taken::{Taken, misaligned};

/// Windows in a row of which only the best is tried; on short lines more of them are tried.
const BLOCK: usize = 6;
const SHORT_BLOCK: usize = 2;
/// Blocks are this many times longer on lines outside of ladders.
const SPARSE_BLOCKS: usize = 2;
/// Lines with fewer windows are short.
const SHORT: usize = 100;
/// Side of the cells with one seed of a ladder each, divided by the spacing.
const SEED_CELL: f64 = 0.5;
/// Value of each number of a ladder, from which its cost is subtracted.
const RUNG: f64 = 5.0;
/// Highest cost of a number that is as close to the next one as allowed, and of one that is `FAR` times as far.
const LIMIT_NEAR: f64 = 2.0;
const LIMIT_FAR: f64 = 9.0;
const FAR: f64 = 3.5;
/// Distance of numbers outside of ladders from all numbers, divided by the spacing.
const SPARSE: f64 = 0.4;
/// Rounds of moving numbers; how far they move, divided by the spacing; how many positions are judged for each.
const ROUNDS: usize = 2;
const MOVE: f64 = 0.4;
const TRIALS: usize = 3;
/// Numbers of neighbouring levels within this distance, divided by the spacing, form ladders.
const NEIGHBOURS: f64 = 0.6;
/// Smaller gains are not worth a move.
const MIN_GAIN: f64 = 0.05;

/// A window that is the best of its block, by its estimated cost.
#[derive(Clone, Copy)]
struct Best {
    cost: f64,
    course: usize,
    window: usize,
}

/// Places the numbers of a map.
pub(super) fn numbers(map: &Map<'_>) -> Vec<Number> {
    let best = best(map);
    let mut taken = Taken::new(map);
    ladders(&mut taken, map, &best);
    fill(&mut taken, map, &best, true);
    for _ in 0..ROUNDS {
        improve(&mut taken, map);
    }
    fill(&mut taken, map, &best, true);
    fill(&mut taken, map, &best, false);
    let mut numbers: Vec<Number> = taken.numbers().map(|(_, candidate)| number(map, candidate)).collect();
    numbers.sort_by(|a, b| a.line.cmp(&b.line).then(a.gap_px[0].total_cmp(&b.gap_px[0])));
    numbers
}

fn number(map: &Map<'_>, candidate: &Candidate) -> Number {
    let role = &map.courses[candidate.course].role;
    let [begin_px, end_px] = candidate.gap_px;
    let path = map.paths.path(role.line);
    let begin_within_px = if path.is_closed { begin_px.rem_euclid(path.length_px()) } else { begin_px };
    Number {
        line: role.line,
        text: map.contours[role.line].text.to_owned(),
        gap_px: [begin_within_px, begin_within_px + (end_px - begin_px)],
        centre_px: candidate.frame.centre,
        angle: candidate.frame.along.to_angle(),
        bend: candidate.frame.bend,
        size_px: DVec2::new(role.width_px, map.page.letter_px),
    }
}

/// Returns the best window of each block.
fn best(map: &Map<'_>) -> Vec<Best> {
    let mut all = Vec::new();
    for (course, own) in map.courses.iter().enumerate() {
        let block = if own.count < SHORT { SHORT_BLOCK } else { BLOCK };
        let block = if own.role.rung.is_some() { block } else { SPARSE_BLOCKS * block };
        for first in (0..own.count).step_by(block) {
            let windows = first..(first + block).min(own.count);
            let estimates = windows.filter_map(|window| Some((map.estimate(course, window)?.cost, window)));
            let least = estimates.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(cost, _)| *cost < LIMIT_FAR);
            all.extend(least.map(|(cost, window)| Best { cost, course, window }));
        }
    }
    all
}

/// Places the best ladders.
fn ladders(taken: &mut Taken<'_>, map: &Map<'_>, best: &[Best]) {
    let cell_px = SEED_CELL * map.rules.spacing_px;
    let mut seeds: FxHashMap<[i64; 2], Best> = FxHashMap::default();
    for own in best.iter().filter(|own| map.courses[own.course].role.rung.is_some()) {
        let cell = (map.courses[own.course].middle(own.window) / cell_px).floor().as_i64vec2().to_array();
        let seed = seeds.entry(cell).or_insert(*own);
        if own.cost < seed.cost {
            *seed = *own;
        }
    }
    let mut seeds: Vec<Best> = seeds.into_values().collect();
    seeds.sort_by(|a, b| a.cost.total_cmp(&b.cost).then((a.course, a.window).cmp(&(b.course, b.window))));
    // A seed near a number of an earlier ladder would only lead to the same ladder.
    let mut climbed: Vec<Vec<DVec2>> = vec![Vec::new(); map.courses.len()];
    let ladders = seeds.into_iter().filter_map(|seed| {
        let middle = map.courses[seed.course].middle(seed.window);
        if climbed[seed.course].iter().any(|other| other.distance(middle) < cell_px) {
            return None;
        }
        let seed = map.judge(seed.course, seed.window)?;
        let rungs = taken.is_free(&seed, None).then(|| ladder(taken, map, seed))?;
        rungs.iter().for_each(|rung| climbed[rung.course].push(rung.frame.centre));
        Some((value(map, &rungs), rungs))
    });
    let mut ladders: Vec<(f64, Vec<Candidate>)> = ladders.filter(|(_, rungs)| rungs.len() > 1).collect();
    ladders.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, rungs) in ladders {
        let free: Vec<Candidate> = rungs.into_iter().filter(|rung| is_possible(taken, rung)).collect();
        if free.len() > 1 {
            for rung in free {
                place_if_possible(taken, rung);
            }
        }
    }
}

/// Returns how good a ladder is.
fn value(map: &Map<'_>, rungs: &[Candidate]) -> f64 {
    let own: f64 = rungs.iter().map(|rung| RUNG - rung.cost).sum();
    let aside = |pair: &[Candidate]| {
        let width_px = map.courses[pair[1].course].role.width_px;
        ASIDE * misaligned(&pair[0].frame, &pair[1].frame, width_px)
    };
    own - rungs.windows(2).map(aside).sum::<f64>()
}

/// Returns whether a number keeps its distance from the others.
fn is_possible(taken: &Taken<'_>, candidate: &Candidate) -> bool {
    let spacing = taken.spacing(candidate.course, candidate.frame.centre, None);
    spacing >= 1.0 && candidate.cost <= limit(spacing) && taken.is_free(candidate, None)
}

fn place_if_possible(taken: &mut Taken<'_>, candidate: Candidate) -> bool {
    let is_possible = is_possible(taken, &candidate);
    if is_possible {
        taken.place(candidate);
    }
    is_possible
}

/// Returns the highest cost of a number whose nearest number of the same level has a distance, in units of the smallest
/// one: the longer a line has had no number, the more it needs one.
fn limit(spacing: f64) -> f64 {
    LIMIT_NEAR + (LIMIT_FAR - LIMIT_NEAR) * ((spacing - 1.0) / (FAR - 1.0)).clamp(0.0, 1.0)
}

/// A window of [`fill`], or the position that was found for it.
struct Entry {
    cost: f64,
    best: Best,
    candidate: Option<Box<Candidate>>,
}

impl Ord for Entry {
    /// The entry with the lowest cost is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        let own = (other.best.course, other.best.window).cmp(&(self.best.course, self.best.window));
        other.cost.total_cmp(&self.cost).then(own)
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

/// Places single numbers, the best first, and grows a ladder from each; or the numbers outside of ladders.
fn fill(taken: &mut Taken<'_>, map: &Map<'_>, best: &[Best], in_ladders: bool) {
    let own = best.iter().filter(|best| map.courses[best.course].role.rung.is_some() == in_ladders);
    let mut heap: BinaryHeap<Entry> = own.map(|best| Entry { cost: best.cost, best: *best, candidate: None }).collect();
    while let Some(Entry { best, candidate, .. }) = heap.pop() {
        let Some(candidate) = candidate else {
            let middle = map.courses[best.course].middle(best.window);
            // The centre of the number will not be exactly here.
            if taken.spacing(best.course, middle, None) > 0.98 && (in_ladders || is_sparse(taken, map, middle)) {
                let candidate = map.judge(best.course, best.window);
                heap.extend(candidate.map(|own| Entry { cost: own.cost, best, candidate: Some(Box::new(own)) }));
            }
            continue;
        };
        if !in_ladders && !is_sparse(taken, map, candidate.frame.centre) {
            continue;
        }
        if place_if_possible(taken, (*candidate).clone()) && in_ladders {
            for sign in [1.0, -1.0] {
                for rung in climb(taken, map, &candidate, sign) {
                    if !place_if_possible(taken, rung) {
                        break;
                    }
                }
            }
        }
    }
}

fn is_sparse(taken: &Taken<'_>, map: &Map<'_>, at: DVec2) -> bool {
    !taken.is_near(at, SPARSE * map.rules.spacing_px)
}

/// Moves numbers along their lines if they, or their ladders, are better there.
fn improve(taken: &mut Taken<'_>, map: &Map<'_>) {
    let numbers: Vec<(usize, Candidate)> = taken.numbers().map(|(i, candidate)| (i, candidate.clone())).collect();
    for (number, own) in numbers {
        if let Some(better) = better(taken, map, number, &own) {
            taken.shift(number, better);
        }
    }
}

/// Returns a better position for a number on the same part of its line.
fn better(taken: &Taken<'_>, map: &Map<'_>, number: usize, own: &Candidate) -> Option<Candidate> {
    let course = &map.courses[own.course];
    let reach_px = MOVE * map.rules.spacing_px;
    let neighbours = Neighbours::new(taken, map, own, reach_px)?;
    let before = own.cost + neighbours.aside(&own.frame);
    let estimated = course.around(course.middle_px(own.window), reach_px).filter_map(|window| {
        let estimate = map.estimate(own.course, window)?;
        Some((estimate.cost + neighbours.aside(&estimate.frame), window))
    });
    let estimated = estimated.filter(|(cost, _)| *cost < before - MIN_GAIN).collect();
    cheapest(estimated, TRIALS, |window| {
        let candidate = map.judge(own.course, window)?;
        let cost = candidate.cost + neighbours.aside(&candidate.frame);
        let is_apart = || taken.spacing(own.course, candidate.frame.centre, Some(number)) >= 1.0;
        let is_better = cost < before - MIN_GAIN && is_apart() && taken.is_free(&candidate, Some(number));
        is_better.then_some((cost, candidate))
    })
}

/// The numbers of the levels below and above a number.
struct Neighbours {
    frames: [Vec<Frame>; 2],
    near_px: f64,
    width_px: f64,
}

impl Neighbours {
    /// Collects the neighbours of all positions within `reach_px` of a number that belongs to ladders.
    fn new(taken: &Taken<'_>, map: &Map<'_>, own: &Candidate, reach_px: f64) -> Option<Self> {
        let role = &map.courses[own.course].role;
        let rung = role.rung?;
        let near_px = NEIGHBOURS * map.rules.spacing_px;
        let near = taken.near(own.frame.centre, reach_px + near_px);
        let near: Vec<&Candidate> = near.into_iter().filter_map(|other| taken.number(other)).collect();
        let of = |rung: Option<usize>| {
            let is_of = |other: &&&Candidate| rung.is_some() && map.courses[other.course].role.rung == rung;
            near.iter().filter(is_of).map(|other| other.frame).collect()
        };
        Some(Self { frames: [of(rung.checked_sub(1)), of(rung.checked_add(1))], near_px, width_px: role.width_px })
    }

    /// Returns the cost of a position that is not above or below its neighbours.
    fn aside(&self, own: &Frame) -> f64 {
        let of = |frames: &Vec<Frame>| {
            let near = frames.iter().filter(|other| other.centre.distance(own.centre) < self.near_px);
            near.map(|other| misaligned(other, own, self.width_px)).fold(1.0, f64::min)
        };
        ASIDE * self.frames.iter().map(of).sum::<f64>()
    }
}
