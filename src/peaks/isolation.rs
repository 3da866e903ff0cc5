//! The nearest higher sample of each summit.
//!
//! A best-first search over the pyramid of maxima: blocks that have something higher than the summit are split in the
//! order of a lower bound of their distance, and those of the finest level are read. The land around the DEM takes part
//! as four strips of unknown height, so that the search also finds how far the isolation is certain.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::blocks::{Blocks, Level};
use super::spacing::{Metric, Origin};
use super::{Heights, Higher, Isolation, read_land};

/// Least number of samples along a side of a page.
const LEAST_PAGE_SIDE: usize = 256;
/// Number of pages in memory.
const MOST_PAGES: usize = 64;

/// Finds the isolation of summits, and caches the heights that it reads.
pub(super) struct IsolationSearch<'a, H: Heights> {
    heights: &'a mut H,
    blocks: &'a Blocks,
    metric: Metric,
    wraps: bool,
    /// Samples along a side of a page: a multiple of a block's.
    page_side: usize,
    /// The page that was used last comes last.
    pages: Vec<Page>,
    queue: BinaryHeap<Entry>,
}

/// A square of heights in memory.
struct Page {
    /// Column and row of the page.
    at: [usize; 2],
    columns: usize,
    heights_m: Vec<f32>,
}

/// What can be nearer than the nearest sample found so far.
#[derive(Clone, Copy)]
enum Area {
    /// A block of the pyramid: its level, column and row.
    Block(usize, [usize; 2]),
    /// Samples outside of the DEM: first and last column, first and last row.
    Outside([i64; 2], [i64; 2]),
}

/// An area with a lower bound of its nearness.
struct Entry {
    bound: f64,
    area: Area,
}

impl Ord for Entry {
    /// The nearest entry is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
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

/// A higher sample. Of samples of equal nearness, the one in the lower row counts as the nearer one; in one row, the
/// one that is fewer columns away; of two of those, the one in the lower column.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Candidate {
    nearness: f64,
    row: i64,
    columns: f64,
    column: i64,
    height_m: f32,
}

impl<'a, H: Heights> IsolationSearch<'a, H> {
    pub(super) fn new(heights: &'a mut H, blocks: &'a Blocks, metric: Metric, wraps: bool) -> Self {
        let page_side = blocks.side * LEAST_PAGE_SIDE.div_ceil(blocks.side);
        Self { heights, blocks, metric, wraps, page_side, pages: Vec::new(), queue: BinaryHeap::new() }
    }

    /// Returns a key by which summits are sorted so that those near each other follow each other: that of the page of
    /// the summit on a Z-order curve.
    pub(super) fn turn(&self, place: [usize; 2]) -> u64 {
        let [x, y] = place.map(|at| (at / self.page_side) as u64);
        (0..32).fold(0, |key, bit| key | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1))
    }

    /// Finds the nearest sample that is higher than a summit.
    ///
    /// # Errors
    /// The first heights that cannot be read.
    pub(super) fn find(&mut self, summit: [usize; 2], height_m: f32) -> Result<Isolation, H::Error> {
        let origin = self.metric.origin(summit[0] as i64, summit[1] as i64);
        self.queue.clear();
        self.push(&origin, Area::Block(self.blocks.levels.len() - 1, [0, 0]), height_m);
        self.push_outside(&origin);
        let mut nearest: Option<Candidate> = None;
        // Nearness and row of the nearest sample outside of the DEM.
        let mut outside: Option<(f64, i64)> = None;
        while let Some(Entry { bound, area }) = self.queue.pop() {
            // A sample of equal nearness may precede the nearest one.
            if nearest.is_some_and(|nearest| bound > nearest.nearness) {
                break;
            }
            match area {
                Area::Block(0, block) => self.scan(&origin, block, height_m, &mut nearest)?,
                Area::Block(level, [x, y]) => {
                    for block in [[2 * x, 2 * y], [2 * x + 1, 2 * y], [2 * x, 2 * y + 1], [2 * x + 1, 2 * y + 1]] {
                        self.push(&origin, Area::Block(level - 1, block), height_m);
                    }
                }
                Area::Outside(..) if outside.is_some() => {}
                Area::Outside([first, last], [top, bottom]) => {
                    if first == last && top == bottom {
                        outside = Some((bound, top));
                    } else if last - first > bottom - top {
                        let middle = first + (last - first) / 2;
                        self.push(&origin, Area::Outside([first, middle], [top, bottom]), height_m);
                        self.push(&origin, Area::Outside([middle + 1, last], [top, bottom]), height_m);
                    } else {
                        let middle = top + (bottom - top) / 2;
                        self.push(&origin, Area::Outside([first, last], [top, middle]), height_m);
                        self.push(&origin, Area::Outside([first, last], [middle + 1, bottom]), height_m);
                    }
                }
            }
        }
        let outside = outside.filter(|(nearness, _)| nearest.is_none_or(|nearest| *nearness < nearest.nearness));
        let higher = nearest.map(|nearest| Higher {
            column: nearest.column as usize,
            row: nearest.row as usize,
            height_m: nearest.height_m,
            distance_m: origin.distance_m(nearest.row, nearest.nearness),
        });
        let outside_m = outside.map(|(nearness, row)| origin.distance_m(row, nearness));
        Ok(Isolation { higher, outside_m })
    }

    /// Adds an area to the queue, unless it has no higher sample.
    fn push(&mut self, origin: &Origin, area: Area, height_m: f32) {
        let (columns, rows) = match area {
            Area::Block(level, block) => {
                let Level { size, highest_m } = &self.blocks.levels[level];
                let is_inside = block[0] < size[0] && block[1] < size[1];
                let is_higher = is_inside && highest_m[block[1] * size[0] + block[0]] > height_m;
                if !is_higher {
                    return;
                }
                let [columns, rows] = self.blocks.bounds(level, block);
                (columns.map(|column| column as i64), rows.map(|row| row as i64))
            }
            Area::Outside(columns, rows) => (columns, rows),
        };
        self.queue.push(Entry { bound: origin.bound(columns, rows), area });
    }

    /// Adds the samples around the DEM to the queue: the rows before the first and after the last, and the columns
    /// before the first and after the last if columns don't wrap.
    fn push_outside(&mut self, origin: &Origin) {
        let [columns, rows] = self.blocks.size.map(|samples| samples as i64);
        let metric = self.metric;
        for row in [-1, rows].into_iter().filter(|row| metric.has_row(*row)) {
            self.push(origin, Area::Outside([0, columns - 1], [row, row]), f32::NAN);
        }
        if !self.wraps {
            for column in [-1, columns] {
                self.push(origin, Area::Outside([column, column], [0, rows - 1]), f32::NAN);
            }
        }
    }

    /// Searches the samples of a block for a higher one that is nearer.
    fn scan(
        &mut self,
        origin: &Origin,
        block: [usize; 2],
        height_m: f32,
        nearest: &mut Option<Candidate>,
    ) -> Result<(), H::Error> {
        let [[first, last], [top, bottom]] = self.blocks.bounds(0, block);
        let page_side = self.page_side;
        let page = self.page([first / page_side, top / page_side])?;
        let at = |row: usize| row % page_side * page.columns + first % page_side;
        for row in top..=bottom {
            let terms = origin.row_terms(row as i64);
            if nearest.is_some_and(|nearest| terms.across > nearest.nearness) {
                continue;
            }
            let heights_m = &page.heights_m[at(row)..][..=last - first];
            for found in nearest_higher(heights_m, height_m, origin.column - first as i64).into_iter().flatten() {
                let column = (first + found) as i64;
                let columns = origin.columns_to(column);
                let nearness = origin.nearness(terms, columns);
                let candidate = Candidate { nearness, row: row as i64, columns, column, height_m: heights_m[found] };
                if nearest.is_none_or(|nearest| candidate < nearest) {
                    *nearest = Some(candidate);
                }
            }
        }
        Ok(())
    }

    /// Returns a page, and reads it if it isn't in memory. Forgets the page that was used least recently if there are
    /// too many.
    fn page(&mut self, at: [usize; 2]) -> Result<&Page, H::Error> {
        let page = if let Some(known) = self.pages.iter().rposition(|page| page.at == at) {
            self.pages.remove(known)
        } else {
            let mut heights_m = Vec::new();
            if self.pages.len() >= MOST_PAGES {
                heights_m = self.pages.remove(0).heights_m;
            }
            let first = at.map(|page| page * self.page_side);
            let size = [0, 1].map(|axis| self.page_side.min(self.blocks.size[axis] - first[axis]));
            read_land(self.heights, first, size, &mut heights_m)?;
            Page { at, columns: size[0], heights_m }
        };
        self.pages.push(page);
        Ok(&self.pages[self.pages.len() - 1])
    }
}

/// Returns the places in a piece of a row of those higher samples one of which is the nearest: the last one up to a
/// column and the first one from it on and, because columns come nearer again on the far side of the Earth, the first
/// and the last one.
fn nearest_higher(heights_m: &[f32], height_m: f32, column: i64) -> [Option<usize>; 4] {
    let is_higher = |other_m: &f32| *other_m > height_m;
    let Some(first) = heights_m.iter().position(is_higher) else { return [None; 4] };
    let last = heights_m.iter().rposition(is_higher);
    let middle = column.clamp(0, heights_m.len() as i64) as usize;
    let before = heights_m[..middle].iter().rposition(is_higher);
    let after = heights_m[middle..].iter().position(is_higher).map(|place| middle + place);
    [Some(first), last, before, after]
}
