//! Labels of a camera that moves: the frames of a film, or a window.
//!
//! Rows are above the land, and move up and down with it as the summits do. Where other land becomes the highest, they
//! follow it within about a second. A label follows its summit within its row. Which labels there are is decided by
//! [`Flight`], so that a label appears, disappears or changes its row at most once a second.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::sites::Sites;
use super::{ABOVE_LAND, Ground, LETTERS, MARGIN, MAX_ON_LAND, MAX_ROWS, Placed, ROW, Seen, Visible, row_label, rows};
use crate::labels::placement::Hold;
use crate::labels::placement::flight::{Flight, Summit};
use crate::labels::placement::panorama::{Label, panorama};
use crate::lettering::Line;

/// Time in which rows follow land that becomes the highest, in seconds: after it, 37 % of the way is left.
const FOLLOW_S: f64 = 0.5;
/// The part of [`MARGIN`] up to which a row remains in use when it moves to the upper border.
const LEAST_MARGIN: f64 = 0.4;
/// Rows above those that a layout needs that remain in use.
const MORE_ROWS: usize = 1;
/// Times per second at which it is found how many rows a layout needs.
const CHECKS_PER_S: f64 = 2.0;
/// Factor on the weight of a summit that has a label, and on [`MAX_ON_LAND`] for it, when the summits with labels are
/// chosen.
const HELD: f64 = 1.25;
/// The median distance by which summits with labels move from one frame to the next, as a part of the picture's width,
/// beyond which the camera is at another place: all labels are laid out from scratch.
const CUT: f64 = 0.2;
/// Time for which labels were there before the first frame, in seconds: long enough to be opaque, and free to change.
const BEFORE_S: f64 = 1.0;

/// The labels of successive frames.
#[derive(Debug, Default)]
pub(crate) struct MovingNames {
    flight: Flight,
    /// Whether each row is in use, from the top.
    rows: [bool; MAX_ROWS],
    /// Time of the last frame, and the upper end of the land that its rows were above, in pixels.
    land: Option<[f64; 2]>,
    /// How many rows a layout from scratch needs, and the number of the check that found it.
    needed: Option<(usize, f64)>,
    /// Widths of the texts of sites, in heights of their letters.
    widths: FxHashMap<usize, f64>,
    /// Where summits with labels were in the last frame.
    before_px: BTreeMap<usize, DVec2>,
}

impl MovingNames {
    /// Returns the sites that have labels.
    pub(crate) fn held(&self) -> BTreeSet<usize> {
        self.flight.ids().map(|id| id as usize).collect()
    }

    /// Returns the labels of the next frame. `most` is the largest number of summits without names that have one.
    pub(crate) fn frame(
        &mut self,
        time_s: f64,
        sites: &Sites,
        visible: &Visible,
        most: usize,
        ground: &Ground<'_>,
    ) -> Vec<Placed> {
        let seen = self.chosen(sites, &visible.sites, most, ground);
        let is_chosen: BTreeSet<usize> = seen.iter().map(|at| at.site).collect();
        // Labels that disappear follow their summits.
        let held = self.held();
        let others = visible.sites.iter().chain(&visible.hidden);
        let leaving: Vec<Seen> =
            others.filter(|at| held.contains(&at.site) && !is_chosen.contains(&at.site)).copied().collect();
        let at: BTreeMap<usize, Seen> = seen.iter().chain(&leaving).map(|at| (at.site, *at)).collect();
        let width_px = ground.area_px[1].x - ground.area_px[0].x;
        let is_cut = !self.before_px.is_empty() && self.moved_px(&at) > CUT * width_px;
        if is_cut {
            self.flight = Flight::default();
            self.rows = [false; MAX_ROWS];
            self.needed = None;
            self.land = None;
        }
        let land_px = self.land_px(time_s, &at, visible.land_top_px.min(ground.area_px[1].y));
        self.land = Some([time_s, land_px]);
        let mut summit = |at: &Seen, is_visible| {
            let (site, typeface) = (&sites.all[at.site], ground.paper.typeface);
            let width = self.widths.entry(at.site).or_insert_with(|| Line::small(&site.text, typeface).width());
            Summit { id: at.site as u64, label: row_label(site, at, *width, ground), is_visible }
        };
        let mut summits: Vec<Summit> = seen.iter().map(|at| summit(at, true)).collect();
        let leaving: Vec<Summit> = leaving.iter().map(|at| summit(at, false)).collect();
        let check = (time_s * CHECKS_PER_S).floor();
        if self.needed.is_none_or(|(_, last)| last != check) {
            let tops_px = self.tops_px(land_px, MAX_ROWS, ground);
            let labels: Vec<Label> = summits.iter().map(|summit| summit.label).collect();
            let lowest = tops_px.iter().rposition(|top_px| top_px.is_finite()).unwrap_or(0);
            let places = panorama(&labels, &rows(tops_px, ground), &[]);
            let highest = places.iter().flatten().map(|place| place.row).min().unwrap_or(lowest);
            self.needed = Some((lowest - highest.min(lowest) + 1, check));
        }
        let in_use = self.needed.map_or(1, |(needed, _)| needed + MORE_ROWS);
        let tops_px = self.tops_px(land_px, in_use, ground);
        self.rows = std::array::from_fn(|row| tops_px[row].is_finite());
        let rows = rows(tops_px, ground);
        if self.before_px.is_empty() || is_cut {
            self.flight.frame(time_s - BEFORE_S, &summits, &rows);
        } else {
            summits.extend(leaving);
        }
        let height_px = LETTERS[0] * ground.px;
        let placed = self.flight.frame(time_s, &summits, &rows).into_iter().filter_map(|shown| {
            let site = shown.id as usize;
            let [left, right] = shown.label.x_px;
            let px = DVec2::new(left + ground.area_px[0].x, shown.label.y_px);
            let last = Seen { site, px, apart_px: right - left, below_px: 0.0 };
            let bottom_px = top_px(shown.place.row, land_px, ground) + height_px;
            (shown.opacity > 0.0).then(|| Placed {
                at: at.get(&site).copied().unwrap_or(last),
                row: shown.place.row,
                offset_px: shown.place.offset_px,
                bottom_px,
                opacity: shown.opacity,
                has_halo: bottom_px > visible.land_top_px,
            })
        });
        let placed = placed.collect();
        let held = self.held();
        self.before_px = at.values().filter(|at| held.contains(&at.site)).map(|at| (at.site, at.px)).collect();
        placed
    }

    /// Returns the median distance by which summits with labels have moved; one that is no longer in front of the camera
    /// is infinitely far away.
    fn moved_px(&self, at: &BTreeMap<usize, Seen>) -> f64 {
        let moved =
            |(site, before_px): (&usize, &DVec2)| at.get(site).map_or(f64::INFINITY, |at| at.px.distance(*before_px));
        let mut moved_px: Vec<f64> = self.before_px.iter().map(moved).collect();
        moved_px.sort_by(f64::total_cmp);
        moved_px.get(moved_px.len() / 2).copied().unwrap_or(0.0)
    }

    /// Returns the sites inside of the picture's border that may have labels: all names, and the `most` weightiest
    /// summits. Summits that have labels count more, and remain as long as their labels may not change.
    fn chosen(&self, sites: &Sites, seen: &[Seen], most: usize, ground: &Ground<'_>) -> Vec<Seen> {
        let inside = seen.iter().filter(|at| is_inside(at, ground)).copied();
        // Only maps have saddles.
        let of_views = inside.filter(|at| at.site < sites.first_saddle());
        let (names, heights): (Vec<Seen>, Vec<Seen>) = of_views.partition(|at| at.site < sites.names);
        let longest_px = MAX_ON_LAND * ground.px;
        let rank = |at: Seen| {
            let weight = sites.all[at.site].weight;
            let (rank, factor) = match self.flight.hold(at.site as u64) {
                Hold::Fixed(_) => (f64::INFINITY, f64::INFINITY),
                Hold::Kept(_) => (HELD * weight, HELD),
                Hold::Free | Hold::Out => (weight, 1.0),
            };
            (at.below_px < factor * longest_px).then_some((rank, at))
        };
        let mut ranked: Vec<(f64, Seen)> = heights.into_iter().filter_map(rank).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        names.into_iter().chain(ranked.into_iter().take(most).map(|(_, at)| at)).collect()
    }

    /// Returns the upper end of the land that the rows of the next frame are above: it moves as the summits do, and
    /// towards that of the frame, `wanted_px`.
    fn land_px(&self, time_s: f64, at: &BTreeMap<usize, Seen>, wanted_px: f64) -> f64 {
        let Some([before_s, before_px]) = self.land else { return wanted_px };
        let sunk = self.before_px.iter().filter_map(|(site, before_px)| Some(at.get(site)?.px.y - before_px.y));
        let mut sunk_px: Vec<f64> = sunk.collect();
        sunk_px.sort_by(f64::total_cmp);
        let moved_px = before_px + sunk_px.get(sunk_px.len() / 2).copied().unwrap_or(0.0);
        let left = (-(time_s - before_s).max(0.0) / FOLLOW_S).exp();
        wanted_px + (moved_px - wanted_px) * left
    }

    /// Returns the upper sides of all rows above land, of which the `most` lowest ones are in use; NaN for the others.
    fn tops_px(&self, land_px: f64, most: usize, ground: &Ground<'_>) -> Vec<f64> {
        let [low, high] = ground.area_px.map(|corner| corner.y);
        let top = |row: usize| {
            let top_px = top_px(row, land_px, ground);
            let margin = if self.rows[row] { LEAST_MARGIN * MARGIN } else { MARGIN } - 1e-6;
            let is_inside = top_px >= low + margin * ground.px && top_px + LETTERS[0] * ground.px <= high;
            if is_inside && MAX_ROWS - row <= most { top_px } else { f64::NAN }
        };
        (0..MAX_ROWS).map(top).collect()
    }
}

/// Returns the upper side of a row above land. If there is no room above the land, the lowest row is on the land at the
/// border.
fn top_px(row: usize, land_px: f64, ground: &Ground<'_>) -> f64 {
    let px = ground.px;
    let lowest_px = (land_px - (ABOVE_LAND + ROW) * px).max(ground.area_px[0].y + MARGIN * px);
    lowest_px - ROW * px * (MAX_ROWS - 1 - row) as f64
}

/// Returns whether a site is inside of the picture's border, for both eyes.
pub(crate) fn is_inside(at: &Seen, ground: &Ground<'_>) -> bool {
    let [low, high] = ground.area_px;
    [0.0, at.apart_px].into_iter().all(|apart_px| {
        let px = at.px + DVec2::new(apart_px, 0.0);
        px.cmpge(low).all() && px.cmplt(high).all()
    })
}
