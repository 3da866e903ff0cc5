//! Names of points on a map, without overlaps.
//!
//! Each name is at one of eight sides of its symbol, in an order of preference: to the upper right first, as Imhof asks
//! for (1975, "Positioning names on maps"); the order of the others is that of QGIS, after Krygier and Wood. Names are
//! placed by weight, the heaviest one first, and then improved by simulated annealing, which Christensen, Marks and
//! Shieber found to be best (1995, "An empirical study of algorithms for point-feature label placement"). A step moves
//! one name, and looks for other sides for the names that it displaces. Random numbers are the same in each run.

use super::grid::Grid;
use super::{Hold, Random, Rect, usual};

/// The directions from a symbol to its name, in the order of preference; y goes down.
const SIDES: [[f64; 2]; 8] =
    [[1.0, -1.0], [-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, 0.0], [-1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
/// The part of its weight that a name loses for each side that is preferred to its own.
const SIDE_LOSS: f64 = 0.01;
/// Steps of the annealing for each name, without the final ones that only accept improvements.
const STEPS: usize = 24;
/// Smallest and largest number of steps.
const STEP_RANGE: [usize; 2] = [2000, 30_000];
/// First and last temperature, in mean weights of a name.
const TEMPERATURES: [f64; 2] = [0.3, 0.01];

/// A point with a name. A point whose numbers are not finite has no name, and is no obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Position in pixels.
    pub at_px: [f64; 2],
    /// Half of the side of the symbol in pixels. Names of other points keep clear of the symbol.
    pub radius_px: f64,
    /// Width and height of the name's box in pixels; zero for a symbol without a name.
    pub size_px: [f64; 2],
    /// Importance of the name, more than 0.
    pub weight: f64,
}

/// The area for names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Page {
    /// The area in which all names are, in pixels.
    pub area: Rect,
    /// Least distance of names from each other, from obstacles and from symbols of other points, in pixels.
    pub gap_px: f64,
    /// Distance of names from their own symbols, in pixels.
    pub symbol_gap_px: f64,
}

impl Point {
    /// Returns the box of the symbol.
    pub(crate) fn symbol(&self) -> Rect {
        let corner = |sign: f64| self.at_px.map(|at| at + sign * self.radius_px);
        Rect { from_px: corner(-1.0), to_px: corner(1.0) }
    }

    /// Returns the box of the name at one of eight sides. A corner is at 45° from the symbol's centre.
    pub(crate) fn name_box(&self, side: usize, page: &Page) -> Rect {
        let direction = SIDES[side.min(SIDES.len() - 1)];
        let is_corner = direction[0] != 0.0 && direction[1] != 0.0;
        let away_px = (self.radius_px + usual(page.symbol_gap_px))
            * if is_corner { std::f64::consts::FRAC_1_SQRT_2 } else { 1.0 };
        let from_px = [0, 1].map(|axis| {
            let size_px = self.size_px[axis];
            let part = 0.5 * (direction[axis] - 1.0);
            self.at_px[axis] + direction[axis] * away_px + part * size_px
        });
        Rect { from_px, to_px: [from_px[0] + self.size_px[0], from_px[1] + self.size_px[1]] }
    }

    fn has_symbol(&self) -> bool {
        self.symbol().is_valid()
    }

    fn has_name(&self) -> bool {
        let is_usual = self.weight > 0.0 && self.weight.is_finite() && self.size_px.iter().all(|side| *side > 0.0);
        is_usual && self.has_symbol() && self.size_px.iter().all(|side| side.is_finite())
    }
}

/// Chooses the names that are drawn, and their sides. `obstacles` stay free. `holds` is what the last layout requires
/// of each name, with sides as slots; names for which it has no element are free. Returns the side of each name (see
/// [`Point::name_box`]), or `None` for a name that is left out.
pub(crate) fn points(points: &[Point], page: &Page, obstacles: &[Rect], holds: &[Hold]) -> Vec<Option<usize>> {
    if !page.area.is_valid() {
        return vec![None; points.len()];
    }
    let mut board = Board::new(points, page, obstacles, holds);
    board.fill();
    board.anneal();
    board.sides
}

/// Names on the page.
pub(super) struct Board {
    /// For each name and side, the box and what it is worth; `None` where the name may not be.
    choices: Vec<[Option<(Rect, f64)>; 8]>,
    /// Names with at least one choice, the heaviest one first.
    names: Vec<u32>,
    pub sides: Vec<Option<usize>>,
    grid: Grid,
    gap_px: f64,
    /// Names that a step displaces.
    displaced: Vec<u32>,
    /// What a step has changed: names, with their sides before.
    changes: Vec<(u32, Option<usize>)>,
}

impl Board {
    pub(super) fn new(points: &[Point], page: &Page, obstacles: &[Rect], holds: &[Hold]) -> Self {
        let gap_px = usual(page.gap_px);
        let named = || points.iter().filter(|point| point.has_name());
        let bond = 4.0 * named().map(|point| point.weight).sum::<f64>();
        let usual_px = named().map(|point| point.size_px[0].max(point.size_px[1])).sum::<f64>();
        let grid = Grid::new(page.area, usual_px / named().count().max(1) as f64);
        let mut fixed = grid.clone();
        // Obstacles have numbers after those of the symbols.
        let symbols = points.iter().map(|point| point.has_symbol().then(|| point.symbol()));
        let others = obstacles.iter().map(|area| area.is_valid().then_some(*area));
        for (number, area) in (0..).zip(symbols.chain(others)) {
            area.into_iter().for_each(|area| fixed.insert(number, area));
        }
        let choice = |number: usize, side: usize| {
            let point = &points[number];
            let area = point.name_box(side, page);
            let is_inside = (0..2)
                .all(|axis| area.from_px[axis] >= page.area.from_px[axis] && area.to_px[axis] <= page.area.to_px[axis]);
            let gain = holds.get(number).copied().unwrap_or_default().gain(side, point.weight, bond);
            let gain = gain - SIDE_LOSS * side as f64 * point.weight;
            let is_free = || !fixed.is_occupied(&area, gap_px, |other| other as usize != number);
            (point.has_name() && is_inside && gain > 0.0 && is_free()).then_some((area, gain))
        };
        let choices: Vec<[Option<(Rect, f64)>; 8]> =
            (0..points.len()).map(|number| std::array::from_fn(|side| choice(number, side))).collect();
        let best = |number: &u32| choices[*number as usize].iter().flatten().map(|(_, gain)| *gain).fold(0.0, f64::max);
        let mut names: Vec<u32> = (0..points.len() as u32).filter(|number| best(number) > 0.0).collect();
        names.sort_by(|a, b| best(b).total_cmp(&best(a)));
        let sides = vec![None; points.len()];
        Self { choices, names, sides, grid, gap_px, displaced: Vec::new(), changes: Vec::new() }
    }

    /// Returns what a name is worth where it is.
    fn gain(&self, name: u32) -> f64 {
        let choice = self.sides[name as usize].and_then(|side| self.choices[name as usize][side]);
        choice.map_or(0.0, |(_, gain)| gain)
    }

    /// Moves a name to another side, or removes it.
    fn put(&mut self, name: u32, side: Option<usize>) {
        let index = name as usize;
        let before = std::mem::replace(&mut self.sides[index], side);
        self.changes.push((name, before));
        let area = |side: Option<usize>| side.and_then(|side| self.choices[index][side]);
        let [old, new] = [area(before), area(side)];
        old.into_iter().for_each(|(area, _)| self.grid.remove(name, area));
        new.into_iter().for_each(|(area, _)| self.grid.insert(name, area));
    }

    /// Returns the best side of a name where it displaces no other name.
    fn free_side(&self, name: u32) -> Option<usize> {
        let choices = self.choices[name as usize].iter().enumerate();
        let mut best = (0.0, None);
        for (side, (area, gain)) in choices.filter_map(|(side, choice)| Some((side, choice.as_ref()?))) {
            if *gain > best.0 && !self.grid.is_occupied(area, self.gap_px, |other| other != name) {
                best = (*gain, Some(side));
            }
        }
        best.1
    }

    /// Places all names that have space, the heaviest one first.
    pub(super) fn fill(&mut self) {
        for index in 0..self.names.len() {
            let name = self.names[index];
            if self.sides[name as usize].is_none()
                && let Some(side) = self.free_side(name)
            {
                self.put(name, Some(side));
            }
        }
        self.changes.clear();
    }

    /// Moves a name to a side, and the names that are there to other sides, or removes them. Returns the change of the
    /// total gain.
    fn step(&mut self, name: u32, side: usize) -> f64 {
        let Some((area, gain)) = self.choices[name as usize][side] else { return 0.0 };
        let mut change = gain - self.gain(name);
        let mut displaced = std::mem::take(&mut self.displaced);
        self.grid.find(&area, self.gap_px, &mut displaced);
        displaced.retain(|other| *other != name);
        for other in &displaced {
            change -= self.gain(*other);
            self.put(*other, None);
        }
        self.put(name, Some(side));
        displaced.sort_by(|a, b| self.best_gain(*b).total_cmp(&self.best_gain(*a)));
        for other in &displaced {
            if let Some(side) = self.free_side(*other) {
                self.put(*other, Some(side));
                change += self.gain(*other);
            }
        }
        self.displaced = displaced;
        change
    }

    /// Returns the largest gain of a name at any side.
    fn best_gain(&self, name: u32) -> f64 {
        self.choices[name as usize].iter().flatten().map(|(_, gain)| *gain).fold(0.0, f64::max)
    }

    /// Improves the layout by random steps, of which those that make it worse become rarer.
    fn anneal(&mut self) {
        // If each name is at its best side, nothing is left to improve.
        let is_perfect = |name: &u32| self.gain(*name) >= self.best_gain(*name);
        if self.names.iter().all(is_perfect) {
            return;
        }
        let mut random = Random(2);
        // A fixed name counts far more than any other, so the median is more useful than the mean.
        let mean = self.best_gain(self.names[self.names.len() / 2]);
        let steps = (STEPS * self.names.len()).clamp(STEP_RANGE[0], STEP_RANGE[1]);
        let mut total: f64 = self.names.iter().map(|name| self.gain(*name)).sum();
        let mut best = (total, self.sides.clone());
        for turn in 0..steps + steps / 4 {
            let name = self.names[random.below(self.names.len())];
            let side = random.below(SIDES.len());
            let is_choice = self.choices[name as usize][side].is_some() && self.sides[name as usize] != Some(side);
            if !is_choice {
                continue;
            }
            self.changes.clear();
            let change = self.step(name, side);
            let part = turn as f64 / steps as f64;
            let heat = mean * TEMPERATURES[0] * (TEMPERATURES[1] / TEMPERATURES[0]).powf(part);
            let is_final = turn >= steps;
            if change >= 0.0 || (!is_final && random.unit() < (change / heat).exp()) {
                total += change;
            } else {
                self.undo();
            }
            if turn % self.names.len() == 0 && total > best.0 {
                best = (total, self.sides.clone());
            }
        }
        if best.0 > total {
            self.restore(&best.1);
        }
        self.fill();
    }

    /// Reverts the last step.
    fn undo(&mut self) {
        while let Some((name, before)) = self.changes.pop() {
            self.put(name, before);
            self.changes.pop();
        }
    }

    /// Returns to an earlier layout.
    fn restore(&mut self, sides: &[Option<usize>]) {
        for index in 0..self.names.len() {
            self.put(self.names[index], None);
        }
        for index in 0..self.names.len() {
            let name = self.names[index];
            self.put(name, sides[name as usize]);
        }
    }
}
