//! Names of points in the frames of a moving map: [`points`] ten times per second, and [`Steady`] between.
//!
//! A name keeps its side of the symbol, and follows it, until the layout moves it.

use std::collections::BTreeMap;

use super::grid::Grid;
use super::points::{Page, Point, points};
use super::steady::Steady;
use super::{AHEAD, Hold, Rect, usual};

/// A point in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    /// Number of the point, the same in all frames.
    pub id: u64,
    /// The point.
    pub point: Point,
    /// Whether the point is visible.
    pub is_visible: bool,
}

/// A name as it is drawn in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShownName {
    /// Number of the point.
    pub id: u64,
    /// The side of the symbol.
    pub side: usize,
    /// The box of the name.
    pub area: Rect,
    /// Opacity from 0 to 1.
    pub opacity: f64,
    /// Whether the name disappears.
    pub is_leaving: bool,
}

/// The names of a map while it moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MapFlight {
    steady: Steady,
    points: BTreeMap<u64, Point>,
}

impl MapFlight {
    /// Returns the names of a frame, by their numbers. If several points have the same number, the last one counts.
    pub(crate) fn frame(&mut self, time_s: f64, spots: &[Spot], page: &Page, obstacles: &[Rect]) -> Vec<ShownName> {
        let (_, is_due) = self.steady.begin(time_s);
        let spots: BTreeMap<u64, &Spot> = spots.iter().map(|spot| (spot.id, spot)).collect();
        self.points.retain(|id, _| self.steady.visible(*id).is_some());
        for (id, point) in &mut self.points {
            let spot = spots.get(id).filter(|spot| spot.point.symbol().is_valid());
            *point = spot.map_or(*point, |spot| spot.point);
            let is_seen = spot.is_some_and(|spot| spot.is_visible && point.symbol().overlaps(&page.area, 0.0));
            if !is_seen {
                self.steady.hide(*id);
            }
        }
        self.clear(page);
        if is_due {
            self.decide(&spots, page, obstacles);
        }
        let shown = |(id, point): (&u64, &Point)| {
            let (side, opacity) = self.steady.visible(*id)?;
            let area = point.name_box(side, page);
            Some(ShownName { id: *id, side, area, opacity, is_leaving: self.steady.slot(*id).is_none() })
        };
        self.points.iter().filter_map(shown).collect()
    }

    /// Lets names disappear that are no longer on the page, or overlap a heavier one.
    fn clear(&mut self, page: &Page) {
        let name = |(id, point): (&u64, &Point)| Some((*id, *point, self.steady.slot(*id)?));
        let mut names: Vec<(u64, Point, usize)> = self.points.iter().filter_map(name).collect();
        names.sort_by(|a, b| b.1.weight.total_cmp(&a.1.weight));
        let wide_px = names.iter().map(|(_, point, _)| point.size_px[0]).sum::<f64>() / names.len().max(1) as f64;
        let mut grid = Grid::new(page.area, wide_px);
        for (number, (id, point, side)) in (0..).zip(names) {
            let area = point.name_box(side, page);
            let is_inside = (0..2)
                .all(|axis| area.from_px[axis] >= page.area.from_px[axis] && area.to_px[axis] <= page.area.to_px[axis]);
            // Less than the layout, which has rounding errors.
            if !is_inside || grid.is_occupied(&area, usual(page.gap_px) - 1e-6, |_| true) {
                self.steady.hide(id);
            } else {
                grid.insert(number, area);
            }
        }
    }

    /// Makes a layout, and lets names appear and disappear.
    fn decide(&mut self, spots: &BTreeMap<u64, &Spot>, page: &Page, obstacles: &[Rect]) {
        let seen: Vec<&Spot> = spots.values().copied().filter(|spot| spot.is_visible).collect();
        let all: Vec<Point> = seen.iter().map(|spot| spot.point).collect();
        let holds: Vec<_> = seen.iter().map(|spot| self.steady.hold(spot.id)).collect();
        let heights = all.iter().map(|point| point.size_px[1]).filter(|height_px| height_px.is_finite());
        let gap_px = usual(page.gap_px) + AHEAD * heights.fold(0.0, f64::max);
        let sides = points(&all, &Page { gap_px, ..*page }, obstacles, &holds);
        let mut new: Vec<(&Spot, usize)> = Vec::new();
        for ((spot, hold), side) in seen.iter().zip(holds).zip(sides) {
            // A name that may not change yet only leaves if it overlaps another one.
            if side.is_some() || !matches!(hold, Hold::Fixed(_)) {
                self.steady.follow(spot.id, side);
            }
            new.extend(side.filter(|_| self.steady.slot(spot.id).is_none()).map(|side| (*spot, side)));
        }
        new.sort_by(|a, b| b.0.point.weight.total_cmp(&a.0.point.weight));
        for (spot, side) in new {
            let area = spot.point.name_box(side, page);
            let is_blocked = || {
                self.points.iter().any(|(id, point)| {
                    let visible = self.steady.visible(*id);
                    // Less than the layout, which has rounding errors.
                    let gap_px = usual(page.gap_px) - 1e-6;
                    visible.is_some_and(|(side, _)| area.overlaps(&point.name_box(side, page), gap_px))
                })
            };
            if self.steady.may_appear(spot.id) && !is_blocked() {
                self.steady.appear(spot.id, side);
                self.points.insert(spot.id, spot.point);
            }
        }
    }
}
