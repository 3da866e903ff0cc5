//! Tiling of a poster onto the sheets of a small printer: the cut, the marks around each tile, and the paths of a tile.
//!
//! A sheet shows a window of the poster at the poster's own scale. Neighbouring windows overlap, so that one sheet can
//! be glued onto the other. Nothing is drawn over a window. Around it, within the printable area, are crop marks at its
//! corners, ticks where the neighbour's window begins, and the name of the sheet.

use glam::DVec2;
use kurbo::{Affine, BezPath, ParamCurve, PathSeg, Rect};

use crate::file::svg::{Layer, Stroke, Text};
use crate::lettering::Line;

/// Largest number of sheets; nobody glues more together.
pub(crate) const MAX_SHEETS: f64 = 400.0;
/// Width of the strip between the printer's margin and the window, for marks and names.
const MARKS_MM: f64 = 6.0;
/// Gap between a window and its marks.
const GAP_MM: f64 = 1.0;
/// Length of crop marks.
const CROP_MM: f64 = 4.0;
/// Length of the ticks where a neighbour begins.
const TICK_MM: f64 = 2.0;
/// Line width of marks and letters.
const PEN_MM: f64 = 0.2;
/// Height of letters.
const LETTER_MM: f64 = 3.0;
/// Largest distance of the polygons of an area that is cut from its outline, as a part of its size.
const FLATNESS: f64 = 1e-4;
/// Least distance between the windows of neighbouring sheets.
const MIN_STEP_MM: f64 = 10.0;

/// Largest number of pixels of all sheets together: this many, plus `MAX_RATIO` times the pixels of the poster. A
/// poster of A0 may be printed on A4.
const FREE_PX: f64 = 268_435_456.0;
const MAX_RATIO: f64 = 16.0;

/// The options of `--sheets`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Sides of the paper, the longer first.
    pub paper_mm: [f64; 2],
    /// Overlap of neighbouring windows.
    pub overlap_mm: f64,
    /// Margin that the printer cannot reach, at each side.
    pub margin_mm: f64,
}

/// The cut of a poster into sheets. Lengths are in the poster's unit, pixels or millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheets {
    /// Width and height of a sheet.
    pub paper: [f64; 2],
    /// Width and height of a sheet in millimetres.
    pub paper_mm: [f64; 2],
    /// Distance from the sheet's edges to the window.
    pub inset: f64,
    /// Width and height of a whole window.
    pub window: [f64; 2],
    /// Overlap of neighbouring windows.
    pub overlap: f64,
    /// Width and height of the poster.
    pub poster: [f64; 2],
    /// Number of columns and rows of sheets.
    pub counts: [u32; 2],
    units_per_mm: f64,
}

/// The position of a sheet in a poster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Column, from 0 at the left.
    pub column: u32,
    /// Row, from 0 at the top.
    pub row: u32,
}

impl Place {
    /// Returns the name of the sheet: letters for the row and a number for the column, like `B3`. Row `AA` follows row
    /// `Z`.
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
    /// Finds the cut with the fewest sheets, in portrait or landscape. `is_whole` rounds lengths to whole units.
    ///
    /// # Errors
    /// One line if margins and overlap leave no room, or if there would be too many sheets, or too large ones.
    pub fn new(poster: [f64; 2], units_per_mm: f64, is_whole: bool, wish: &Wish) -> Result<Self, String> {
        let [longer, shorter] = wish.paper_mm;
        let turned = |paper_mm: [f64; 2]| Self::turned(poster, units_per_mm, is_whole, paper_mm, wish);
        let (upright, lying) = (turned([shorter, longer]), turned([longer, shorter]));
        let Some(upright) = upright else {
            let Wish { overlap_mm, margin_mm, .. } = wish;
            return Err(format!(
                "--sheets: on {shorter}x{longer} mm paper, a margin of {margin_mm} mm, {MARKS_MM} mm for crop marks and an \
                 overlap of {overlap_mm} mm leave no room for the picture"
            ));
        };
        // Either both orientations have room or neither has.
        let fewest = lying.filter(|lying| lying.count() < upright.count()).unwrap_or(upright);
        let count = fewest.count();
        if count > MAX_SHEETS {
            return Err(format!("--sheets: the picture needs {count} sheets, but the limit is {MAX_SHEETS}"));
        }
        let [of_sheets, of_poster] = [fewest.paper, poster].map(|[width, height]| width * height);
        if is_whole && count * of_sheets > FREE_PX + MAX_RATIO * of_poster {
            let [width, height] = fewest.paper;
            return Err(format!(
                "--sheets: a sheet would have {width}x{height} pixels, which is too large for a picture of {}x{}",
                poster[0], poster[1]
            ));
        }
        Ok(fewest)
    }

    fn turned(poster: [f64; 2], units_per_mm: f64, is_whole: bool, paper_mm: [f64; 2], wish: &Wish) -> Option<Self> {
        let length = |mm: f64| if is_whole { (mm * units_per_mm).round() } else { mm * units_per_mm };
        let paper = paper_mm.map(length);
        let (inset, overlap) = (length(wish.margin_mm + MARKS_MM), length(wish.overlap_mm));
        let window = paper.map(|side| side - 2.0 * inset);
        let steps = window.map(|side| side - overlap);
        let least = (MIN_STEP_MM * units_per_mm).max(1.0);
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

    /// Returns the positions of all sheets, row by row.
    pub fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let [columns, rows] = self.counts;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| Place { column, row }))
    }

    /// Returns where the window of a sheet begins and ends on the poster: its upper left and lower right corner.
    pub fn part(&self, place: Place) -> [[f64; 2]; 2] {
        let steps = self.window.map(|side| side - self.overlap);
        let begin = [steps[0] * f64::from(place.column), steps[1] * f64::from(place.row)];
        let end = [0, 1].map(|i| (begin[i] + self.window[i]).min(self.poster[i]));
        [begin, end]
    }

    /// Returns the line width of marks and names.
    pub fn pen(&self) -> f64 {
        PEN_MM * self.units_per_mm
    }

    /// Returns crop marks, ticks and the name of a sheet, as lines on the sheet outside the window.
    pub fn marks(&self, place: Place) -> Vec<Vec<DVec2>> {
        let [begin, end] = self.part(place);
        let [left, top] = [self.inset; 2];
        let [right, bottom] = [0, 1].map(|i| self.inset + end[i] - begin[i]);
        let [gap, crop, tick] = [GAP_MM, CROP_MM, TICK_MM].map(|mm| mm * self.units_per_mm);
        let mut lines = Vec::new();
        // Vertical marks at the window's upper and lower side; `level` draws horizontal ones at the left and right
        // side.
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
        // To the right of a possible tick.
        let letter = LETTER_MM * self.units_per_mm;
        let at = DVec2::new(left + self.overlap + 2.0 * gap, bottom + gap + letter + 0.5 * gap);
        lines.extend(Line::new(&place.name()).strokes(at, letter));
        lines
    }

    /// Returns the paths of a sheet: those of the poster, clipped to its window at their centre lines.
    pub fn layers(&self, layers: &[Layer], place: Place) -> Vec<Layer> {
        let [begin, end] = self.part(place);
        let window = Rect::new(begin[0], begin[1], end[0], end[1]);
        let shift = Affine::translate((self.inset - begin[0], self.inset - begin[1]));
        let clipped = |stroke: &Stroke| Some(Stroke { path: shift * clipped(&stroke.path, window)?, ..stroke.clone() });
        let layer = |layer: &Layer| {
            let strokes = layer.strokes.iter().filter_map(clipped).collect();
            let fills = layer.fills.iter().filter_map(|fill| Some(shift * area_within(fill, window)?)).collect();
            let is_within = |text: &&Text| text.around().overlaps(window);
            let texts = layer.texts.iter().filter(is_within).map(|text| text.placed(shift)).collect();
            Layer {
                strokes,
                fills,
                texts,
                id: layer.id.clone(),
                label: layer.label.clone(),
                ink: layer.ink.clone(),
                ..*layer
            }
        };
        layers.iter().map(layer).filter(|layer| !layer.strokes.is_empty() || !layer.fills.is_empty()).collect()
    }
}

/// Returns the part of an area within a rectangle (Sutherland and Hodgman 1974); `None` if there is none. An area that is
/// cut consists of polygons.
fn area_within(path: &BezPath, window: Rect) -> Option<BezPath> {
    let around = path.control_box();
    if around.x0 >= window.x0 && around.x1 <= window.x1 && around.y0 >= window.y0 && around.y1 <= window.y1 {
        return Some(path.clone());
    }
    if around.x0 > window.x1 || around.x1 < window.x0 || around.y0 > window.y1 || around.y1 < window.y0 {
        return None;
    }
    let mut polygons: Vec<Vec<kurbo::Point>> = Vec::new();
    kurbo::flatten(path, FLATNESS * around.height().max(around.width()), |element| match element {
        kurbo::PathEl::MoveTo(at) => polygons.push(vec![at]),
        kurbo::PathEl::LineTo(at) => polygons.last_mut().into_iter().for_each(|polygon| polygon.push(at)),
        _ => {}
    });
    // How far a point is inside of each side of the rectangle.
    let sides: [fn(kurbo::Point, Rect) -> f64; 4] = [
        |at, window| at.x - window.x0,
        |at, window| window.x1 - at.x,
        |at, window| at.y - window.y0,
        |at, window| window.y1 - at.y,
    ];
    let mut kept = BezPath::new();
    for mut polygon in polygons {
        for inside in sides {
            let mut cut = Vec::new();
            for (i, to) in polygon.iter().enumerate() {
                let from = polygon[(i + polygon.len() - 1) % polygon.len()];
                let [a, b] = [from, *to].map(|at| inside(at, window));
                if (a >= 0.0) != (b >= 0.0) {
                    cut.push(from.lerp(*to, a / (a - b)));
                }
                if b >= 0.0 {
                    cut.push(*to);
                }
            }
            polygon = cut;
        }
        if polygon.len() > 2 {
            kept.move_to(polygon[0]);
            polygon.iter().skip(1).for_each(|at| kept.line_to(*at));
            kept.close_path();
        }
    }
    (!kept.is_empty()).then_some(kept)
}

/// Clips a path to a rectangle; `None` if nothing is left.
fn clipped(path: &BezPath, window: Rect) -> Option<BezPath> {
    // The box of the control points encloses the path.
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
            // A dot is a segment of zero length.
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

/// Returns the polynomial coefficients of one coordinate of a segment, in ascending powers of the parameter.
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
    fn sheets_have_few_pixels_more_than_the_poster() {
        let a4 = |dpi: f64| [297.0, 210.0].map(|side: f64| (side * dpi / 25.4).round());
        let on = |paper_mm: [f64; 2], dpi: f64| Sheets::new(a4(dpi), dpi / 25.4, true, &Wish { paper_mm, ..WISH });
        // An A4 on an A0 is possible at any resolution of a printer; a sheet of 100 m is not.
        assert!([72.0, 300.0, 1200.0].iter().all(|dpi| on([1189.0, 841.0], *dpi).is_ok()));
        let error = on([100_000.0, 100_000.0], 300.0).unwrap_err();
        assert!(error.starts_with("--sheets: a sheet would have 1181102x1181102 pixels"), "{error}");
        // Lines have no pixels.
        assert!(Sheets::new([297.0, 210.0], 1.0, false, &Wish { paper_mm: [100_000.0; 2], ..WISH }).is_ok());
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
        // A window is 186 by 273 mm: three landscape A4 sheets make a strip of 3 × 273 − 2 × 10 mm.
        assert_eq!((of([799.0, 180.0]).counts, of([799.5, 180.0]).counts), ([3, 1], [4, 1]));
        let narrow = Wish { overlap_mm: 180.0, ..WISH };
        assert!(Sheets::new([500.0; 2], 1.0, false, &narrow).unwrap_err().contains("no room"));
        assert!(Sheets::new([90_000.0; 2], 1.0, false, &WISH).unwrap_err().contains("the limit is 400"));
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
    fn words_are_on_every_sheet_that_shows_them() {
        let sheets = Sheets::new([841.0, 594.0], 1.0, false, &WISH).unwrap();
        let [first, second] = [0, 1].map(|column| Place { column, row: 0 });
        // The words begin before the overlap of two sheets and end behind it.
        let begin = sheets.part(second)[0][0] - 5.0;
        let along = kurbo::Vec2::new(sheets.part(first)[1][0] - begin + 5.0, 0.0);
        let text = Text { words: "Ridge".to_owned(), begin: kurbo::Point::new(begin, 50.0), along, height: 3.0 };
        let stroke = BezPath::from_svg("M1,50 L800,50").unwrap();
        let layer = Layer {
            id: "names".to_owned(),
            label: "Names".to_owned(),
            ink: None,
            kind: "mark",
            pen: None,
            strokes: vec![Stroke { path: stroke, width: 1.0, opacity: 1.0, ink: None }],
            fills: Vec::new(),
            texts: vec![text.clone()],
        };
        let words = |place: Place| sheets.layers(std::slice::from_ref(&layer), place)[0].texts.clone();
        for place in [first, second] {
            let [from, _] = sheets.part(place);
            let shift = sheets.inset - from[0];
            let found = words(place);
            assert!(found.len() == 1 && (found[0].begin.x - text.begin.x - shift).abs() < 1e-9, "{found:?}");
        }
        // Planted: a sheet that does not show them.
        assert!(words(Place { column: 2, row: 0 }).is_empty());
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
        // A curve that leaves and returns becomes two paths, and a closed one loses its part outside.
        let curve = cut("M10,40 C40,100 60,100 90,40").unwrap();
        assert_eq!(curve.to_svg().matches('M').count(), 2);
        assert!(curve.segments().all(|segment| (0..=20).all(|i| segment.eval(f64::from(i) / 20.0).y < 50.0 + 1e-9)));
        let square = cut("M50,25 L150,25 L150,75 L50,75 Z").unwrap();
        assert!((long(&square) - 75.0).abs() < 1e-6, "{}", long(&square));
        // A dot is kept.
        assert!(clipped(&path("M-5,25 L5,25 M7,7 L7,7"), window).unwrap().to_svg().contains("M7,7"));
    }
}
