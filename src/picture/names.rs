//! Names and heights of summits and places on a picture. In a view they are in rows above the land, with leaders down to
//! their summits; on a map they are next to their symbols.
//!
//! Only what the picture shows has a name: the surface that is drawn decides what is visible. Where labels are is
//! decided by [`crate::labels::placement`].

pub(crate) mod lakes;
#[cfg(feature = "window")]
mod mask;
pub(crate) mod moving;
mod seen;
pub(crate) mod sites;

use glam::{DVec2, DVec3};

#[cfg(feature = "window")]
pub(crate) use self::mask::{LETTER_GAP, LetterMask, leader_px, letter_mask};
#[cfg(feature = "window")]
pub(crate) use self::seen::placed_on;
pub(crate) use self::seen::{Seen, SeenSurface, Visible, Wanted, visible};
use super::title::{MAX_PEN, MIN_PEN, PEN};
use crate::file::svg::Text;
use crate::labels::placement::Rect;
use crate::labels::placement::panorama::{Label, Rows, panorama};
use crate::labels::placement::points::{Page, Point, points};
use crate::lettering::Line;
use crate::lettering::area::Area;
use crate::lettering::ink::PenStroke;
use crate::style::Paper;

// Lengths are in pixels of the style.

/// Height of capitals on views and on maps.
const LETTERS: [f64; 2] = [8.0, 7.0];
/// Height of a row, distance of the lowest row from the land below it, and the width of leaders.
const ROW: f64 = 17.0;
const ABOVE_LAND: f64 = 14.0;
const LEADER: f64 = 0.7;
/// Distance of a leader from its summit and from its name.
const LEADER_GAPS: [f64; 2] = [3.0, 3.0];
/// Distance of names in a row, from leaders, and from the border.
const GAP: f64 = 9.0;
const LEADER_GAP: f64 = 4.0;
const MARGIN: f64 = 10.0;
/// Length of a leader on other land at which a label counts half as much.
const ON_LAND: f64 = 20.0;
/// Longest leader on other land of a summit without a name.
pub(crate) const MAX_ON_LAND: f64 = 45.0;
/// Largest number of rows.
const MAX_ROWS: usize = 6;
/// Half of the height of a summit's triangle and of a place's ring on a map, and the distance of the name.
const SYMBOL: f64 = 3.2;
const SYMBOL_GAP: f64 = 2.0;
/// Distance of the middle of each arc of a saddle's symbol from the saddle, in halves of a symbol.
const SADDLE_GAP: f64 = 1.3;
/// Height of the wave of a lake's symbol, in halves of a symbol.
const WAVE: f64 = 0.35;
/// Width of the halo around letters on a map.
pub(super) const HALO: f64 = 2.2;

/// A place that may have a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Site {
    /// Position in the world, as the land is drawn.
    pub world_m: DVec3,
    /// The name, the height, or both.
    pub text: String,
    /// Importance, more than 0; the prominence of a summit.
    pub weight: f64,
    pub kind: SiteKind,
}

/// What a site is, which decides its symbol on maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SiteKind {
    /// A triangle.
    Summit,
    /// Two arcs, back to back.
    Saddle,
    /// A ring.
    Place,
    /// A wave.
    Lake,
}

impl SiteKind {
    /// Returns half of the width of the symbol, in pixels of the style.
    fn radius(self) -> f64 {
        match self {
            Self::Summit | Self::Place | Self::Lake => SYMBOL,
            Self::Saddle => SADDLE_GAP * SYMBOL,
        }
    }
}

/// The part of a picture that may have labels, and their inks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    /// Upper left and lower right corner, without margin, border and foot, in pixels.
    pub area_px: [DVec2; 2],
    pub paper: &'a Paper,
    /// Number of pixels per pixel of the style.
    pub px: f64,
}

/// Labels, ready to be drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Labels {
    /// Strokes and letters, in pixels of the picture.
    pub strokes: Vec<PenStroke>,
    pub areas: Vec<Area>,
    /// The words of the letters.
    pub texts: Vec<Text>,
    /// What is drawn under the letters in the colour of the paper; empty in views.
    pub halo: Vec<PenStroke>,
    /// Characters that neither the lettering nor a font of the machine has.
    pub replaced: Vec<char>,
    /// Indices of the sites with labels.
    pub labelled: Vec<usize>,
}

/// A label in a row above the land.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placed {
    /// The site, with its position on the picture.
    pub at: Seen,
    /// Index of the row, from the top.
    pub row: usize,
    /// Position of the label's left side from its summit, and of the lower side of its letters, in pixels.
    pub offset_px: f64,
    pub bottom_px: f64,
    /// Opacity from 0 to 1.
    pub opacity: f64,
    /// Whether the label has a halo, because it is not in the sky.
    pub has_halo: bool,
}

/// Lays out names in rows above the land. `land_top_px` is the upper end of all land.
pub(crate) fn above_land(sites: &[Site], seen: &[Seen], land_top_px: f64, ground: &Ground<'_>) -> Vec<Placed> {
    let lines = seen.iter().map(|at| Line::small(&sites[at.site].text, ground.paper.typeface));
    let labels: Vec<Label> =
        seen.iter().zip(lines).map(|(at, line)| row_label(&sites[at.site], at, line.width(), ground)).collect();
    let rows = rows(tops_px(land_top_px, ground), ground);
    let height_px = LETTERS[0] * ground.px;
    // Where there is no room in the sky, names are on land.
    let has_halo = rows.tops_px.iter().any(|top| top + height_px > land_top_px);
    let places = panorama(&labels, &rows, &[]);
    let placed = places.iter().zip(seen).filter_map(|(place, at)| {
        let place = (*place)?;
        let bottom_px = rows.tops_px[place.row] + height_px;
        Some(Placed { at: *at, row: place.row, offset_px: place.offset_px, bottom_px, opacity: 1.0, has_halo })
    });
    placed.collect()
}

/// Returns the label of a site for a layout in rows. `width` is that of its text, in heights of its letters.
fn row_label(site: &Site, at: &Seen, width: f64, ground: &Ground<'_>) -> Label {
    let (px, height_px) = (ground.px, LETTERS[0] * ground.px);
    let left_px = at.px.x - ground.area_px[0].x;
    Label {
        x_px: [left_px, left_px + at.apart_px],
        y_px: at.px.y,
        width_px: width * height_px,
        height_px,
        weight: site.weight / (1.0 + at.below_px / (ON_LAND * px)),
    }
}

fn rows(tops_px: Vec<f64>, ground: &Ground<'_>) -> Rows {
    let px = ground.px;
    let [low, high] = ground.area_px;
    Rows {
        tops_px,
        width_px: high.x - low.x,
        margin_px: MARGIN * px,
        gap_px: GAP * px,
        leader_gap_px: LEADER_GAP * px,
        align: 0.5,
    }
}

/// Draws labels in rows on the picture of an eye; 1 is the right eye of a stereo pair.
pub(crate) fn drawn_rows<'a>(
    sites: &[Site],
    placed: impl IntoIterator<Item = &'a Placed>,
    eye: usize,
    ground: &Ground<'_>,
) -> Labels {
    let (px, height_px) = (ground.px, LETTERS[0] * ground.px);
    let mut drawn = Labels::default();
    for label in placed {
        let Seen { site, px: first, apart_px, .. } = label.at;
        let at = DVec2::new(first.x + if eye == 1 { apart_px } else { 0.0 }, first.y);
        let [strokes, areas] = [drawn.strokes.len(), drawn.areas.len()];
        let line = Line::small(&sites[site].text, ground.paper.typeface);
        drawn.write(&line, DVec2::new(at.x + label.offset_px, label.bottom_px), height_px, px);
        let ends = [label.bottom_px + LEADER_GAPS[0] * px, at.y - LEADER_GAPS[1] * px];
        if ends[1] > ends[0] {
            let [from, to] = ends.map(|y| DVec2::new(at.x, y));
            drawn.strokes.push(PenStroke::line(from, to, LEADER * px));
        }
        if label.has_halo {
            drawn.halo.extend(halo(&drawn.strokes[strokes..], &drawn.areas[areas..], HALO * px));
        }
        drawn.labelled.push(site);
    }
    drawn
}

/// Returns the upper sides of rows, from the top: as many as there is room for between the border and the land, and one
/// at the border if there is none.
fn tops_px(land_top_px: f64, ground: &Ground<'_>) -> Vec<f64> {
    let px = ground.px;
    let [low, high] = ground.area_px;
    let (top, row_px) = (low.y + MARGIN * px, ROW * px);
    let lowest = land_top_px.min(high.y) - ABOVE_LAND * px;
    let rows = ((lowest - top) / row_px).floor().clamp(1.0, MAX_ROWS as f64);
    let first = (lowest - rows * row_px).max(top);
    let tops = (0..rows as usize).map(|row| first + row as f64 * row_px);
    tops.filter(|top| top + LETTERS[0] * px <= high.y).collect()
}

/// Lays out names next to their symbols on a map, and draws them.
pub(crate) fn on_map(sites: &[Site], seen: &[Seen], ground: &Ground<'_>) -> Labels {
    let px = ground.px;
    let height_px = LETTERS[1] * px;
    let lines: Vec<Line> = seen.iter().map(|at| Line::small(&sites[at.site].text, ground.paper.typeface)).collect();
    let named: Vec<Point> = seen
        .iter()
        .zip(&lines)
        .map(|(at, line)| Point {
            at_px: at.px.to_array(),
            radius_px: sites[at.site].kind.radius() * px,
            size_px: [line.width() * height_px, height_px],
            weight: sites[at.site].weight,
        })
        .collect();
    let inset = DVec2::splat(0.5 * MARGIN * px);
    let [low, high] = [ground.area_px[0] + inset, ground.area_px[1] - inset];
    let area = Rect { from_px: low.to_array(), to_px: high.max(low).to_array() };
    let page = Page { area, gap_px: 2.0 * px, symbol_gap_px: SYMBOL_GAP * px };
    let mut drawn = Labels::default();
    for (((side, at), line), point) in points(&named, &page, &[], &[]).iter().zip(seen).zip(&lines).zip(&named) {
        let Some(side) = side else { continue };
        let Rect { from_px: [left, _], to_px: [_, bottom] } = point.name_box(*side, &page);
        drawn.symbol(at.px, sites[at.site].kind, px);
        drawn.write(line, DVec2::new(left, bottom), height_px, px);
        drawn.labelled.push(at.site);
    }
    drawn.add_halo(HALO * px);
    drawn
}

impl Labels {
    fn write(&mut self, line: &Line, at: DVec2, height_px: f64, px: f64) {
        self.replaced.extend(&line.replaced);
        let width_px = (PEN * height_px).max((MIN_PEN * px).min(MAX_PEN * height_px));
        self.strokes.extend(line.strokes(at, height_px).into_iter().map(|points| PenStroke { points, width_px }));
        self.areas.extend(line.areas(at, height_px));
        self.texts.extend(line.words(at, height_px));
    }

    fn symbol(&mut self, at: DVec2, kind: SiteKind, px: f64) {
        let arc = |middle: DVec2, turns: f64, corners: usize| {
            let around = |i: usize| {
                let turn = std::f64::consts::TAU * turns * i as f64 / corners as f64;
                middle + SYMBOL * px * DVec2::new(turn.sin(), -turn.cos())
            };
            PenStroke { points: (0..=corners).map(around).collect(), width_px: 1.1 * px }
        };
        match kind {
            SiteKind::Summit => self.strokes.push(arc(at, 1.0, 3)),
            SiteKind::Place => self.strokes.push(arc(at, 1.0, 12)),
            // The right half of a circle to the left of the saddle, and the left half of one to its right.
            SiteKind::Saddle => {
                let aside = DVec2::new(SADDLE_GAP * SYMBOL * px, 0.0);
                self.strokes.extend([arc(at - aside, 0.5, 6), arc(at + aside, -0.5, 6)]);
            }
            SiteKind::Lake => {
                let wave = |i: i32| {
                    let part = f64::from(i) / 8.0 - 1.0;
                    at + SYMBOL * px * DVec2::new(part, WAVE * (std::f64::consts::TAU * part).sin())
                };
                self.strokes.push(PenStroke { points: (0..=16).map(wave).collect(), width_px: 1.1 * px });
            }
        }
    }

    /// Adds a halo around everything that is drawn.
    fn add_halo(&mut self, width_px: f64) {
        self.halo = halo(&self.strokes, &self.areas, width_px);
    }
}

/// Returns strokes that cover the given strokes and areas, and `width_px` around them.
pub(super) fn halo(strokes: &[PenStroke], areas: &[Area], width_px: f64) -> Vec<PenStroke> {
    let wider = |stroke: &PenStroke| PenStroke { width_px: stroke.width_px + 2.0 * width_px, ..stroke.clone() };
    let outlines = areas.iter().flat_map(Area::outlines);
    let around = outlines.map(|points| PenStroke { points, width_px: 2.0 * width_px });
    strokes.iter().map(wider).chain(around).collect()
}

/// Returns the text of a label: the name, and the height in whole metres.
pub(crate) fn label(name: Option<&str>, height_m: Option<f64>) -> String {
    let height = height_m.map(|height_m| super::title::grouped(height_m.round()));
    match (name, height) {
        (Some(name), Some(height)) => format!("{name} {height}"),
        (Some(name), None) => name.to_owned(),
        (None, height) => height.unwrap_or_default(),
    }
}
