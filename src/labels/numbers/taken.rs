//! Numbers that are placed, and obstacles.

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::frame::{Frame, Quad, bounds, overlap};
use super::judge::{Candidate, Map};

/// Side of a cell, in letter heights.
const CELL: f64 = 6.0;
/// Free distance around a number, in letter heights; numbers are twice as far apart.
const APART: f64 = 0.25;
/// Distance of numbers of the same level on different lines, divided by that on the same line.
const OTHER_LINE: f64 = 0.5;

/// A number, or an obstacle without a candidate.
struct Item {
    quads: Vec<Quad>,
    bounds: [DVec2; 2],
    candidate: Option<Candidate>,
}

/// The occupied parts of the page, in a grid of cells.
pub(super) struct Taken<'m> {
    map: &'m Map<'m>,
    items: Vec<Item>,
    cells: FxHashMap<[i64; 2], Vec<usize>>,
    /// For each level, the centres, the courses and the indices of its numbers.
    of_level: Vec<Vec<(DVec2, usize, usize)>>,
}

impl<'m> Taken<'m> {
    /// Creates a page with obstacles only.
    pub(super) fn new(map: &'m Map<'m>) -> Self {
        let of_level = vec![Vec::new(); map.levels];
        let mut taken = Self { map, items: Vec::new(), cells: FxHashMap::default(), of_level };
        let [page_low, page_high] = map.page.corners_px;
        for [a, b] in map.page.obstacles_px.iter().filter(|[a, b]| a.is_finite() && b.is_finite()) {
            let [low, high] = [a.min(*b).max(page_low), a.max(*b).min(page_high)];
            if low.cmple(high).all() {
                let quad = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
                taken.insert(Item { quads: vec![quad], bounds: [low, high], candidate: None });
            }
        }
        taken
    }

    fn cells(&self, [low, high]: [DVec2; 2]) -> impl Iterator<Item = [i64; 2]> + use<> {
        let cell_px = CELL * self.map.page.letter_px;
        let [low, high] = [low, high].map(|corner| (corner / cell_px).floor().as_i64vec2());
        (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| [x, y]))
    }

    fn insert(&mut self, item: Item) {
        let number = self.items.len();
        for cell in self.cells(item.bounds) {
            self.cells.entry(cell).or_default().push(number);
        }
        self.items.push(item);
    }

    fn item(&self, candidate: Candidate) -> Item {
        let letter_px = self.map.page.letter_px;
        let around_px = 2.0 * APART * letter_px;
        let width_px = self.map.courses[candidate.course].role.width_px;
        let quads = candidate.frame.quads(width_px + around_px, letter_px + around_px);
        Item { bounds: bounds(&quads), quads, candidate: Some(candidate) }
    }

    /// Places a number, and returns its index.
    pub(super) fn place(&mut self, candidate: Candidate) -> usize {
        let number = self.items.len();
        let level = self.map.courses[candidate.course].role.level;
        self.of_level[level].push((candidate.frame.centre, candidate.course, number));
        let item = self.item(candidate);
        self.insert(item);
        number
    }

    /// Moves a number along its line.
    pub(super) fn shift(&mut self, number: usize, candidate: Candidate) {
        for cell in self.cells(self.items[number].bounds) {
            self.cells.entry(cell).or_default().retain(|other| *other != number);
        }
        let level = self.map.courses[candidate.course].role.level;
        let own = self.of_level[level].iter_mut().filter(|own| own.2 == number);
        own.for_each(|own| own.0 = candidate.frame.centre);
        let item = self.item(candidate);
        for cell in self.cells(item.bounds) {
            self.cells.entry(cell).or_default().push(number);
        }
        self.items[number] = item;
    }

    /// Returns the placed numbers with their indices.
    pub(super) fn numbers(&self) -> impl Iterator<Item = (usize, &Candidate)> {
        self.items.iter().enumerate().filter_map(|(number, item)| Some((number, item.candidate.as_ref()?)))
    }

    /// Returns a number.
    pub(super) fn number(&self, number: usize) -> Option<&Candidate> {
        self.items[number].candidate.as_ref()
    }

    /// Returns whether a number touches nothing, except for the number `except`.
    pub(super) fn is_free(&self, candidate: &Candidate, except: Option<usize>) -> bool {
        let item = self.item(candidate.clone());
        let touches = |number: &usize| {
            let other = &self.items[*number];
            let [low, high] = other.bounds;
            let is_near = item.bounds[0].cmple(high).all() && item.bounds[1].cmpge(low).all();
            let overlaps = || item.quads.iter().any(|own| other.quads.iter().any(|other| overlap(own, other)));
            except != Some(*number) && is_near && overlaps()
        };
        !self.cells(item.bounds).any(|cell| self.cells.get(&cell).is_some_and(|cell| cell.iter().any(touches)))
    }

    /// Returns the smallest distance from a point of a line to the numbers of the same level, divided by the distance
    /// that they must have.
    pub(super) fn spacing(&self, course: usize, at: DVec2, except: Option<usize>) -> f64 {
        let role = &self.map.courses[course].role;
        let others = self.of_level[role.level].iter().filter(|other| except != Some(other.2));
        let distance = |(centre, other, _): &(DVec2, usize, usize)| {
            centre.distance_squared(at) * if *other == course { 1.0 } else { OTHER_LINE.powi(-2) }
        };
        others.map(distance).fold(f64::INFINITY, f64::min).sqrt() / self.map.rules.spacing_px
    }

    /// Returns the numbers whose centres are within a distance of a point, in pixels.
    pub(super) fn near(&self, at: DVec2, reach_px: f64) -> Vec<usize> {
        let mut near: Vec<usize> = self.around(at, reach_px).collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Returns whether the centre of a number is within a distance of a point, in pixels.
    pub(super) fn is_near(&self, at: DVec2, reach_px: f64) -> bool {
        self.around(at, reach_px).next().is_some()
    }

    fn around(&self, at: DVec2, reach_px: f64) -> impl Iterator<Item = usize> {
        let is_near = move |number: &usize| {
            let centre = self.items[*number].candidate.as_ref().map(|candidate| candidate.frame.centre);
            centre.is_some_and(|centre| centre.distance(at) <= reach_px)
        };
        let reach = DVec2::splat(reach_px);
        let [page_low, page_high] = self.map.page.corners_px;
        let cells = self
            .cells([(at - reach).max(page_low), (at + reach).min(page_high)])
            .filter_map(|cell| self.cells.get(&cell));
        cells.flatten().copied().filter(is_near)
    }
}

/// Returns how far two numbers of a ladder are from being above each other, as the squared offset along their lines
/// divided by a width.
pub(super) fn misaligned(a: &Frame, b: &Frame, width_px: f64) -> f64 {
    let [own, other] = [a.direction(0.0), b.direction(0.0)];
    let along = if own.dot(other) < 0.0 { own - other } else { own + other };
    ((b.centre - a.centre).dot(along.normalize_or_zero()) / width_px).powi(2)
}
