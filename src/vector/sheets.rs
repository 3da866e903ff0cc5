//! A poster on sheets of a small printer: how it is cut, what stands around each part, and the paths of a part.
//!
//! A sheet shows a window of the poster at the poster's own scale. Windows of neighbours overlap, so that one may be
//! glued on the other, and are the poster where they lie: nothing is drawn over them. Around a window, within what a
//! printer can reach, stand crop marks at its corners, ticks where the neighbour's window begins, and the sheet's name.

use glam::DVec2;
use kurbo::{Affine, BezPath, ParamCurve, PathSeg, Rect};

use crate::file::svg::{Layer, Stroke};
use crate::lettering::Line;

/// More sheets are not glued together by anybody.
pub const MOST_SHEETS: f64 = 400.0;
/// Between what a printer reaches and the window: the room of marks and names.
const MARKS_MM: f64 = 6.0;
/// Between a window and its marks.
const GAP_MM: f64 = 1.0;
/// Of crop marks.
const CROP_MM: f64 = 4.0;
/// Of ticks where a neighbour begins.
const TICK_MM: f64 = 2.0;
/// Of marks and letters.
const PEN_MM: f64 = 0.2;
/// Of letters.
const LETTER_MM: f64 = 3.0;
/// A step from sheet to sheet is at least as long.
const LEAST_STEP_MM: f64 = 10.0;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// The longer side first.
    pub paper_mm: [f64; 2],
    /// Of neighbours.
    pub overlap_mm: f64,
    /// What a printer leaves free.
    pub margin_mm: f64,
}

/// How a poster is cut. Lengths are in the poster's unit, pixels or millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheets {
    /// Width and height of a sheet.
    pub paper: [f64; 2],
    /// The same in millimetres.
    pub paper_mm: [f64; 2],
    /// From the sheet's edges to the window.
    pub inset: f64,
    /// Width and height of a whole window.
    pub window: [f64; 2],
    /// Of neighbours.
    pub overlap: f64,
    /// Width and height.
    pub poster: [f64; 2],
    /// Columns and rows.
    pub counts: [u32; 2],
    units_per_mm: f64,
}

/// A part of a poster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// From the left, from 0.
    pub column: u32,
    /// From the top, from 0.
    pub row: u32,
}

impl Place {
    /// A letter for the row and a number for the column, like `B3`; `AA1` comes after `Z1`.
    pub fn name(self) -> String {
        let mut letters = String::new();
        let mut left = self.row + 1;
        while left > 0 {
            let digit = ((left - 1) % 26) as u8;
            letters.insert(0, char::from(b'A' + digit));
            left = (left - 1) / 26;
        }
        format!("{letters}{}", self.column + 1)
    }
}

impl Sheets {
    /// The cut with the fewest sheets, upright or lying. `is_whole` rounds lengths to whole units.
    ///
    /// # Errors
    /// What is wrong with the options, in one line.
    pub fn new(poster: [f64; 2], units_per_mm: f64, is_whole: bool, wish: &Wish) -> Result<Self, String> {
        let [longer, shorter] = wish.paper_mm;
        let turned = |paper_mm: [f64; 2]| Self::turned(poster, units_per_mm, is_whole, paper_mm, wish);
        let (upright, lying) = (turned([shorter, longer]), turned([longer, shorter]));
        let Some(upright) = upright else {
            let Wish { overlap_mm, margin_mm, .. } = wish;
            return Err(format!(
                "--sheets: on {shorter}x{longer} mm a margin of {margin_mm} mm, {MARKS_MM} mm for crop marks and an overlap \
                 of {overlap_mm} mm leave no room for the picture"
            ));
        };
        // Both turns have room or none has.
        let fewest = lying.filter(|lying| lying.count() < upright.count()).unwrap_or(upright);
        let count = fewest.count();
        if count > MOST_SHEETS {
            return Err(format!("--sheets: the picture needs {count} sheets, and there are {MOST_SHEETS} at most"));
        }
        Ok(fewest)
    }

    fn turned(poster: [f64; 2], units_per_mm: f64, is_whole: bool, paper_mm: [f64; 2], wish: &Wish) -> Option<Self> {
        let length = |mm: f64| if is_whole { (mm * units_per_mm).round() } else { mm * units_per_mm };
        let paper = paper_mm.map(length);
        let (inset, overlap) = (length(wish.margin_mm + MARKS_MM), length(wish.overlap_mm));
        let window = paper.map(|side| side - 2.0 * inset);
        let steps = window.map(|side| side - overlap);
        let least = (LEAST_STEP_MM * units_per_mm).max(1.0);
        if steps.iter().any(|step| *step < least) {
            return None;
        }
        let count = |i: usize| (1.0 + ((poster[i] - window[i]) / steps[i] - 1e-9).ceil().max(0.0)).min(1e6) as u32;
        let counts = [count(0), count(1)];
        Some(Self { paper, paper_mm, inset, window, overlap, poster, counts, units_per_mm })
    }

    fn count(&self) -> f64 {
        f64::from(self.counts[0]) * f64::from(self.counts[1])
    }

    /// All parts, row by row.
    pub fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let [columns, rows] = self.counts;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| Place { column, row }))
    }

    /// Where a part begins and ends on the poster.
    pub fn part(&self, place: Place) -> [[f64; 2]; 2] {
        let steps = self.window.map(|side| side - self.overlap);
        let begin = [steps[0] * f64::from(place.column), steps[1] * f64::from(place.row)];
        let end = [0, 1].map(|i| (begin[i] + self.window[i]).min(self.poster[i]));
        [begin, end]
    }

    /// The pen of marks and names.
    pub fn pen(&self) -> f64 {
        PEN_MM * self.units_per_mm
    }

    /// Crop marks, ticks and the name of a sheet, as lines on the sheet, all outside of the window.
    pub fn marks(&self, place: Place) -> Vec<Vec<DVec2>> {
        let [begin, end] = self.part(place);
        let [left, top] = [self.inset; 2];
        let [right, bottom] = [0, 1].map(|i| self.inset + end[i] - begin[i]);
        let [gap, crop, tick] = [GAP_MM, CROP_MM, TICK_MM].map(|mm| mm * self.units_per_mm);
        let mut lines = Vec::new();
        // Away from the window's upper and lower side, and from its left and right one.
        let mut upright = |x: f64, length: f64| {
            lines.push(vec![DVec2::new(x, top - gap), DVec2::new(x, top - gap - length)]);
            lines.push(vec![DVec2::new(x, bottom + gap), DVec2::new(x, bottom + gap + length)]);
        };
        upright(left, crop);
        upright(right, crop);
        let Place { column, row } = place;
        if column > 0 {
            upright(left + self.overlap, tick);
        }
        if column + 1 < self.counts[0] {
            upright(right - self.overlap, tick);
        }
        let mut level = |y: f64, length: f64| {
            lines.push(vec![DVec2::new(left - gap, y), DVec2::new(left - gap - length, y)]);
            lines.push(vec![DVec2::new(right + gap, y), DVec2::new(right + gap + length, y)]);
        };
        level(top, crop);
        level(bottom, crop);
        if row > 0 {
            level(top + self.overlap, tick);
        }
        if row + 1 < self.counts[1] {
            level(bottom - self.overlap, tick);
        }
        // Right of the tick that may stand there.
        let letter = LETTER_MM * self.units_per_mm;
        let at = DVec2::new(left + self.overlap + 2.0 * gap, bottom + gap + letter + 0.5 * gap);
        lines.extend(Line::new(&place.name()).strokes(at, letter));
        lines
    }

    /// The paths of a sheet: those of the poster within its window, cut at its sides by the middle of their pens.
    pub fn layers(&self, layers: &[Layer], place: Place) -> Vec<Layer> {
        let [begin, end] = self.part(place);
        let window = Rect::new(begin[0], begin[1], end[0], end[1]);
        let shift = Affine::translate((self.inset - begin[0], self.inset - begin[1]));
        let clipped = |stroke: &Stroke| Some(Stroke { path: shift * clipped(&stroke.path, window)?, ..stroke.clone() });
        let layer = |layer: &Layer| {
            let strokes = layer.strokes.iter().filter_map(clipped).collect();
            Layer { strokes, id: layer.id.clone(), label: layer.label.clone(), ink: layer.ink.clone(), ..*layer }
        };
        layers.iter().map(layer).filter(|layer| !layer.strokes.is_empty()).collect()
    }
}

/// A path within a rectangle; none if nothing of it is.
fn clipped(path: &BezPath, window: Rect) -> Option<BezPath> {
    // Of its control points, which enclose it.
    let around = path.control_box();
    if around.x0 >= window.x0 && around.x1 <= window.x1 && around.y0 >= window.y0 && around.y1 <= window.y1 {
        return Some(path.clone());
    }
    if around.x0 > window.x1 || around.x1 < window.x0 || around.y0 > window.y1 || around.y1 < window.y0 {
        return None;
    }
    let mut kept = BezPath::new();
    let mut pen = None;
    for segment in path.segments() {
        let mut cuts = vec![0.0, 1.0];
        let [x, y] = [0, 1].map(|axis| coefficients(&segment, axis));
        for (of, sides) in [(x, [window.x0, window.x1]), (y, [window.y0, window.y1])] {
            for side in sides {
                cuts.extend(kurbo::common::solve_cubic(of[0] - side, of[1], of[2], of[3]));
            }
        }
        cuts.retain(|cut| (0.0..=1.0).contains(cut));
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            let middle = segment.eval(0.5 * (pair[0] + pair[1]));
            let is_in =
                middle.x >= window.x0 && middle.x <= window.x1 && middle.y >= window.y0 && middle.y <= window.y1;
            // A dot is a segment without a length.
            let is_dot = segment.start() == segment.end() && matches!(segment, PathSeg::Line(_));
            if !is_in || (pair[1] - pair[0] < 1e-9 && !is_dot) {
                continue;
            }
            let part = segment.subsegment(pair[0]..pair[1]);
            if pen != Some(part.start()) {
                kept.move_to(part.start());
            }
            kept.push(part.as_path_el());
            pen = Some(part.end());
        }
    }
    (!kept.elements().is_empty()).then_some(kept)
}

/// Of a coordinate along a segment, as a polynomial of the parameter.
fn coefficients(segment: &PathSeg, axis: usize) -> [f64; 4] {
    let of = |point: kurbo::Point| if axis == 0 { point.x } else { point.y };
    match segment {
        PathSeg::Line(line) => [of(line.p0), of(line.p1) - of(line.p0), 0.0, 0.0],
        PathSeg::Quad(quad) => {
            let [a, b, c] = [quad.p0, quad.p1, quad.p2].map(of);
            [a, 2.0 * (b - a), a - 2.0 * b + c, 0.0]
        }
        PathSeg::Cubic(cubic) => {
            let [a, b, c, d] = [cubic.p0, cubic.p1, cubic.p2, cubic.p3].map(of);
            [a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)]
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use kurbo::ParamCurveArclen;

    use super::*;

    const WISH: Wish = Wish { paper_mm: [297.0, 210.0], overlap_mm: 10.0, margin_mm: 6.0 };

    #[test]
    fn names_count_rows_by_letters() {
        let name = |row, column| Place { column, row }.name();
        assert_eq!([name(0, 0), name(1, 2), name(25, 11)], ["A1", "B3", "Z12"]);
        assert_eq!([name(26, 0), name(51, 0), name(52, 0)], ["AA1", "AZ1", "BA1"]);
    }

    #[test]
    fn windows_cover_the_poster_and_overlap() {
        for poster in [[841.0, 594.0], [100.0, 100.0], [186.0, 3000.0], [4000.0, 20.0]] {
            for (units_per_mm, is_whole) in [(1.0, false), (150.0 / 25.4, true)] {
                let poster = poster.map(|side: f64| (side * units_per_mm).round());
                let sheets = Sheets::new(poster, units_per_mm, is_whole, &WISH).unwrap();
                for i in 0..2 {
                    let part = |at: u32| sheets.part(Place { column: at, row: at }).map(|corner| corner[i]);
                    assert_eq!((part(0)[0], part(sheets.counts[i] - 1)[1]), (0.0, poster[i]));
                    for at in 1..sheets.counts[i] {
                        assert!((part(at - 1)[1] - part(at)[0] - sheets.overlap).abs() < 1e-6);
                        assert!(part(at)[1] - part(at)[0] > sheets.overlap, "a sheet of its own");
                    }
                    assert!(!is_whole || part(0)[1].fract() == 0.0);
                }
            }
        }
        let of = |poster| Sheets::new(poster, 1.0, false, &WISH).unwrap();
        // A window is 186 by 273 mm: three lying sheets of A4 make a strip of 3 × 273 − 2 × 10 mm.
        assert_eq!((of([799.0, 180.0]).counts, of([799.5, 180.0]).counts), ([3, 1], [4, 1]));
        let narrow = Wish { overlap_mm: 180.0, ..WISH };
        assert!(Sheets::new([500.0; 2], 1.0, false, &narrow).unwrap_err().contains("no room"));
        assert!(Sheets::new([90_000.0; 2], 1.0, false, &WISH).unwrap_err().contains("400 at most"));
    }

    #[test]
    fn marks_stay_between_the_window_and_the_margin() {
        let sheets = Sheets::new([841.0, 594.0], 1.0, false, &WISH).unwrap();
        for place in sheets.places() {
            let [begin, end] = sheets.part(place);
            for point in sheets.marks(place).concat() {
                let [x, y] = [point.x - sheets.inset, point.y - sheets.inset];
                let is_outside = x < 0.0 || y < 0.0 || x > end[0] - begin[0] || y > end[1] - begin[1];
                let is_printed =
                    (0..2).all(|i| point[i] > WISH.margin_mm && point[i] < sheets.paper[i] - WISH.margin_mm);
                let on_cut = x == 0.0 || y == 0.0 || x == end[0] - begin[0] || y == end[1] - begin[1];
                assert!((is_outside || on_cut) && is_printed, "{place:?}: {point}");
            }
        }
    }

    #[test]
    fn paths_are_cut_at_the_window() {
        let window = Rect::new(0.0, 0.0, 100.0, 50.0);
        let long = |path: &BezPath| path.segments().map(|segment| segment.arclen(1e-6)).sum::<f64>();
        let path = |text: &str| BezPath::from_svg(text).unwrap();
        let cut = |text: &str| clipped(&path(text), window);
        assert_eq!(cut("M10,10 L20,30"), Some(path("M10,10 L20,30")));
        assert_eq!(cut("M10,-10 L200,-5"), None);
        let crossing = cut("M-50,25 L150,25").unwrap();
        assert!((long(&crossing) - 100.0).abs() < 1e-6);
        // A curve that leaves and comes back is two paths, and a closed one loses what lies outside.
        let curve = cut("M10,40 C40,100 60,100 90,40").unwrap();
        assert_eq!(curve.to_svg().matches('M').count(), 2);
        assert!(curve.segments().all(|segment| (0..=20).all(|i| segment.eval(f64::from(i) / 20.0).y < 50.0 + 1e-9)));
        let square = cut("M50,25 L150,25 L150,75 L50,75 Z").unwrap();
        assert!((long(&square) - 75.0).abs() < 1e-6, "{}", long(&square));
        // A dot stays.
        assert!(clipped(&path("M-5,25 L5,25 M7,7 L7,7"), window).unwrap().to_svg().contains("M7,7"));
    }
}
