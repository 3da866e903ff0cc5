//! Names of peaks in the frames of a flight: [`panorama`] ten times per second, and [`Steady`] between.
//!
//! Within a row, labels slide at a limited speed towards the positions of the layout, and keep clear of each other and of
//! leaders in each frame. A label only appears where there is space for it among all labels that are still visible.

use std::collections::BTreeMap;

use super::panorama::{Label, Place, Problem, Rows, panorama};
use super::steady::Steady;
use super::{AHEAD, Hold, settle, usual};

/// Speed of labels along their row, in heights of the label per second.
const SLIDE_PER_S: f64 = 4.0;

/// A summit in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Summit {
    /// Number of the summit, the same in all frames.
    pub id: u64,
    /// The label.
    pub label: Label,
    /// Whether the summit is visible, and not hidden by the land in front of it.
    pub is_visible: bool,
}

/// A label as it is drawn in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shown {
    /// Number of the summit.
    pub id: u64,
    /// The label, with the position of the summit in this frame; the last known one if the summit has left the picture.
    pub label: Label,
    /// Where the label is.
    pub place: Place,
    /// Opacity from 0 to 1.
    pub opacity: f64,
    /// Whether the label disappears.
    pub is_leaving: bool,
}

/// The labels of a panorama during a flight. A stereo pair has one `Flight` for both pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Flight {
    steady: Steady,
    labels: BTreeMap<u64, Followed>,
}

/// A label in the frames in which it is visible.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Followed {
    label: Label,
    offset_px: f64,
    /// The offset of the layout.
    target_px: f64,
}

impl Flight {
    /// Returns the numbers of the labels that are visible, or begin to be.
    pub(crate) fn ids(&self) -> impl Iterator<Item = u64> + '_ {
        self.labels.keys().copied()
    }

    /// Returns what the state of a label requires of the next layout.
    pub(crate) fn hold(&self, id: u64) -> Hold {
        self.steady.hold(id)
    }

    /// Returns the labels of a frame, by their numbers. If several summits have the same number, the last one counts.
    pub(crate) fn frame(&mut self, time_s: f64, summits: &[Summit], rows: &Rows) -> Vec<Shown> {
        let (passed_s, is_due) = self.steady.begin(time_s);
        let summits: BTreeMap<u64, &Summit> = summits.iter().map(|summit| (summit.id, summit)).collect();
        self.labels.retain(|id, _| self.steady.visible(*id).is_some());
        for (id, followed) in &mut self.labels {
            let summit = summits.get(id);
            if let Some(summit) = summit.filter(|summit| summit.label.is_valid()) {
                followed.label = summit.label;
            }
            let row = self.steady.visible(*id).map(|(row, _)| row);
            let floor_px = row.and_then(|row| rows.tops_px.get(row)).map(|top_px| top_px + followed.label.height_px);
            let is_above = floor_px.is_some_and(|floor_px| floor_px <= followed.label.y_px);
            if !is_above || !summit.is_some_and(|summit| summit.is_visible && is_inside(&summit.label, rows)) {
                self.steady.hide(*id);
            }
        }
        // What is decided now takes effect from now on.
        self.slide(passed_s, rows);
        if is_due {
            self.decide(&summits, rows);
        }
        let shown = |(id, followed): (&u64, &Followed)| {
            let (row, opacity) = self.steady.visible(*id)?;
            let place = Place { row, offset_px: followed.offset_px };
            let is_leaving = self.steady.slot(*id).is_none();
            Some(Shown { id: *id, label: followed.label, place, opacity, is_leaving })
        };
        self.labels.iter().filter_map(shown).collect()
    }

    /// Makes a layout, and lets labels appear and disappear.
    fn decide(&mut self, summits: &BTreeMap<u64, &Summit>, rows: &Rows) {
        let candidates: Vec<&Summit> = summits.values().copied().filter(|summit| summit.is_visible).collect();
        let labels: Vec<Label> = candidates.iter().map(|summit| summit.label).collect();
        let holds: Vec<_> = candidates.iter().map(|summit| self.steady.hold(summit.id)).collect();
        let heights = labels.iter().map(|label| label.height_px).filter(|height_px| height_px.is_finite());
        let ahead_px = AHEAD * heights.fold(0.0, f64::max);
        let [gap_px, leader_gap_px] = [rows.gap_px, rows.leader_gap_px].map(|gap_px| usual(gap_px) + ahead_px);
        let places = panorama(&labels, &Rows { gap_px, leader_gap_px, ..rows.clone() }, &holds);
        let mut new: Vec<(&Summit, Place)> = Vec::new();
        for ((summit, hold), place) in candidates.iter().zip(holds).zip(places) {
            // A label that may not change yet only leaves if it overlaps another one.
            if place.is_some() || !matches!(hold, Hold::Fixed(_)) {
                self.steady.follow(summit.id, place.map(|place| place.row));
            }
            let Some(place) = place else { continue };
            if self.steady.slot(summit.id).is_none() {
                new.push((summit, place));
            } else if let Some(followed) = self.labels.get_mut(&summit.id) {
                followed.target_px = place.offset_px;
            }
        }
        new.sort_by(|a, b| b.0.label.weight.total_cmp(&a.0.label.weight));
        for (summit, place) in new {
            let offset_px = place.offset_px;
            if self.steady.may_appear(summit.id) && !self.is_blocked(&summit.label, place, rows) {
                self.steady.appear(summit.id, place.row);
                self.labels.insert(summit.id, Followed { label: summit.label, offset_px, target_px: offset_px });
            }
        }
    }

    /// Returns whether a label that is still visible is in the way of a new one, or of its leader.
    fn is_blocked(&self, label: &Label, place: Place, rows: &Rows) -> bool {
        self.labels.iter().any(|(id, followed)| {
            let Some((row, _)) = self.steady.visible(*id) else { return false };
            let other = Place { row, offset_px: followed.offset_px };
            are_in_conflict([(label, place), (&followed.label, other)], rows)
        })
    }

    /// Moves labels along their rows, and apart.
    fn slide(&mut self, passed_s: f64, rows: &Rows) {
        for (id, followed) in &mut self.labels {
            if self.steady.slot(*id).is_some() {
                let step_px = SLIDE_PER_S * followed.label.height_px * passed_s;
                followed.offset_px += (followed.target_px - followed.offset_px).clamp(-step_px, step_px);
            }
        }
        // If labels that disappear leave no space for the others, they are in the way for a moment. If those that remain
        // have no space, the least important one disappears.
        if !self.part(rows, true).is_empty() {
            while let Some(lost) = self.part(rows, false).first() {
                let id = self.lightest(*lost, rows);
                self.steady.hide(id);
            }
        }
    }

    /// Returns the label with the least weight among those that remain: a label, and those that are in its way.
    fn lightest(&self, lost: u64, rows: &Rows) -> u64 {
        let Some(own) = self.labels.get(&lost) else { return lost };
        let place =
            |id: u64, followed: &Followed| self.steady.slot(id).map(|row| Place { row, offset_px: followed.offset_px });
        let Some(own_place) = place(lost, own) else { return lost };
        let mut lightest = (own.label.weight, lost);
        for (id, followed) in self.labels.iter().filter(|(id, _)| **id != lost) {
            let Some(place) = place(*id, followed) else { continue };
            let is_lighter = followed.label.weight < lightest.0;
            if is_lighter && are_in_conflict([(&own.label, own_place), (&followed.label, place)], rows) {
                lightest = (followed.label.weight, *id);
            }
        }
        lightest.1
    }

    /// Moves labels as little as is needed for them to keep clear of each other and of leaders. Returns the labels
    /// that remain and have no space; if there are any, and `with_leaving`, nothing is moved.
    fn part(&mut self, rows: &Rows, with_leaving: bool) -> Vec<u64> {
        let is_moved = |id: &u64| with_leaving || self.steady.slot(*id).is_some();
        let ids: Vec<u64> = self.labels.keys().copied().filter(is_moved).collect();
        let followed: Vec<Followed> = ids.iter().filter_map(|id| self.labels.get(id).copied()).collect();
        let labels: Vec<Label> = followed.iter().map(|followed| followed.label).collect();
        let problem = Problem::new(&labels, rows, &[]);
        let row = |index: usize| self.steady.visible(ids[index]).map(|(row, _)| row);
        let rows_of: Vec<Option<usize>> =
            problem.sites.iter().map(|site| row(site.index).filter(|row| *row < problem.gains.len())).collect();
        let preferred: Vec<f64> = problem.sites.iter().map(|site| followed[site.index].offset_px).collect();
        let offsets = settle::offsets(&problem, &rows_of, &preferred);
        let found = || problem.sites.iter().zip(&offsets);
        let without = found().filter(|(_, offset_px)| offset_px.is_none()).map(|(site, _)| ids[site.index]);
        let lost: Vec<u64> = without.filter(|id| self.steady.slot(*id).is_some()).collect();
        if with_leaving && !lost.is_empty() {
            return lost;
        }
        for (site, offset_px) in found() {
            if let (Some(followed), Some(offset_px)) = (self.labels.get_mut(&ids[site.index]), offset_px) {
                followed.offset_px = *offset_px;
            }
        }
        lost
    }
}

/// Returns whether a summit is inside of the picture, as far as labels may be.
fn is_inside(label: &Label, rows: &Rows) -> bool {
    label.is_valid() && label.x_px.iter().all(|x_px| *x_px >= rows.margin_px && *x_px <= rows.width_px - rows.margin_px)
}

/// Returns whether two labels overlap, or the leader of one crosses the other, in either picture.
fn are_in_conflict(pair: [(&Label, Place); 2], rows: &Rows) -> bool {
    // Less than the layout, which has rounding errors.
    let [gap_px, leader_gap_px] = [rows.gap_px, rows.leader_gap_px].map(|gap_px| usual(gap_px) - 1e-6);
    (0..2).any(|eye| {
        let [a, b] = pair.map(|(label, place)| {
            let left_px = label.x_px[eye] + place.offset_px;
            (place.row, label.x_px[eye], [left_px, left_px + label.width_px])
        });
        let is_crossed = |leader: (usize, f64, [f64; 2]), name: (usize, f64, [f64; 2])| {
            leader.0 < name.0 && leader.1 > name.2[0] - leader_gap_px && leader.1 < name.2[1] + leader_gap_px
        };
        let overlaps = a.0 == b.0 && a.2[0] < b.2[1] + gap_px && b.2[0] < a.2[1] + gap_px;
        overlaps || is_crossed(a, b) || is_crossed(b, a)
    })
}
