//! Filled areas: the coverage of pixels, and hatching for pens.

use glam::DVec2;
use kurbo::{BezPath, PathEl};

use super::ink::PenStroke;

/// Rows of samples in a pixel; along a row coverage is exact.
const ROWS: u32 = 16;
/// Largest distance of a polygon from the curve of an outline, in pixels.
const TOLERANCE_PX: f64 = 0.02;

/// An area inside closed outlines, which may have holes and overlap: it is where the outlines wind around a point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Area {
    /// The outlines as curves, in pixels; y goes down.
    pub curves: BezPath,
    /// Width of a pen that suits the area, in pixels.
    pub pen_px: f64,
    /// Corners of each outline as a polygon.
    outlines: Vec<Vec<DVec2>>,
    high_px: [f64; 2],
}

impl Area {
    /// Creates an area inside of outlines in pixels, which suits a pen of a width.
    pub(crate) fn new(curves: BezPath, pen_px: f64) -> Self {
        let mut outlines: Vec<Vec<DVec2>> = Vec::new();
        kurbo::flatten(&curves, TOLERANCE_PX, |element| match element {
            PathEl::MoveTo(at) => outlines.push(vec![DVec2::new(at.x, at.y)]),
            PathEl::LineTo(at) => {
                outlines.last_mut().into_iter().for_each(|outline| outline.push(DVec2::new(at.x, at.y)));
            }
            _ => {}
        });
        outlines.retain(|outline| outline.len() > 2);
        let points = || outlines.iter().flatten().map(|at| at.y);
        let high_px = [points().fold(f64::MAX, f64::min), points().fold(f64::MIN, f64::max)];
        Self { curves, pen_px, outlines, high_px }
    }

    /// Returns the upper and lower end.
    pub(crate) fn high_px(&self) -> [f64; 2] {
        self.high_px
    }

    /// Returns the outlines as closed polygons, whose last point is the first one.
    pub(crate) fn outlines(&self) -> impl Iterator<Item = Vec<DVec2>> + '_ {
        self.outlines.iter().map(|outline| outline.iter().chain(outline.first()).copied().collect())
    }

    /// Returns the parts of a horizontal line that are inside, from left to right.
    fn spans(&self, y: f64) -> Vec<[f64; 2]> {
        let mut crossings: Vec<(f64, i32)> = Vec::new();
        for outline in &self.outlines {
            for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
                if (a.y <= y) != (b.y <= y) {
                    let x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
                    crossings.push((x, if a.y < b.y { 1 } else { -1 }));
                }
            }
        }
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut spans, mut winding, mut begin): (Vec<[f64; 2]>, i32, f64) = (Vec::new(), 0, 0.0);
        for (x, turn) in crossings {
            let before = winding;
            winding += turn;
            match (before, winding) {
                (0, _) => begin = x,
                (_, 0) if x > begin => spans.push([begin, x]),
                _ => {}
            }
        }
        spans
    }

    /// Returns strokes of a pen of [`Area::pen_px`] that fill the area, as far as the pen is fine enough: rows from top
    /// to bottom, every second one backwards.
    pub(crate) fn hatching(&self) -> Vec<PenStroke> {
        let [top, bottom] = self.high_px();
        let (pen, mut strokes) = (self.pen_px.max(1e-3), Vec::new());
        let rows = (((bottom - top) / pen).ceil() as usize).clamp(1, 1000);
        for row in 0..rows {
            let y = top + (bottom - top) * (row as f64 + 0.5) / rows as f64;
            let stroke = |[from, to]: [f64; 2]| {
                // The ends of the pen are round; a part that is narrower than the pen becomes a dot.
                let inset = (0.5 * pen).min(0.5 * (to - from));
                let [from, to] = [from + inset, to - inset].map(|x| DVec2::new(x, y));
                if row % 2 == 0 { PenStroke::line(from, to, pen) } else { PenStroke::line(to, from, pen) }
            };
            let mut of_row: Vec<PenStroke> = self.spans(y).into_iter().map(stroke).collect();
            if row % 2 == 1 {
                of_row.reverse();
            }
            strokes.extend(of_row);
        }
        strokes
    }
}

/// Adds the coverage of areas to the pixels of row `row`, which begins at column `first`: 0 to 1.
pub(crate) fn cover_areas(areas: &[Area], first: f64, row: f64, covered: &mut [f32]) {
    for area in areas {
        let [top, bottom] = area.high_px();
        if row + 1.0 < top || row > bottom {
            continue;
        }
        for sample in 0..ROWS {
            let y = row + (f64::from(sample) + 0.5) / f64::from(ROWS);
            for [from, to] in area.spans(y) {
                let [from, to] = [from - first, to - first].map(|x| x.clamp(0.0, covered.len() as f64));
                let begin = from.floor() as usize;
                let under = covered.iter_mut().enumerate().take(to.ceil() as usize).skip(begin);
                for (pixel, part) in under {
                    let inside = to.min(pixel as f64 + 1.0) - from.max(pixel as f64);
                    *part = (*part + (inside / f64::from(ROWS)) as f32).min(1.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(middle: f64, radius: f64, is_reversed: bool) -> BezPath {
        let ring = kurbo::Circle::new((middle, middle), radius);
        let path = kurbo::Shape::to_path(&ring, 1e-3);
        if is_reversed { path.reverse_subpaths() } else { path }
    }

    fn area(rings: &[BezPath]) -> Area {
        Area::new(rings.iter().flat_map(BezPath::iter).collect(), 1.5)
    }

    /// Returns the ink of an area in a picture of 60 × 60 pixels, filled and hatched.
    fn ink(area: &Area) -> [f64; 2] {
        let mut filled = 0.0;
        for row in 0..60 {
            let mut covered = vec![0.0; 60];
            cover_areas(std::slice::from_ref(area), 0.0, f64::from(row), &mut covered);
            filled += covered.iter().map(|part| f64::from(*part)).sum::<f64>();
        }
        // The rows of a pen that is as wide as their distance touch each other.
        let ink_of = |stroke: &PenStroke| {
            let ends = 0.25 * std::f64::consts::PI * stroke.width_px * stroke.width_px;
            stroke.points[0].distance(stroke.points[1]) * stroke.width_px + ends
        };
        [filled, area.hatching().iter().map(ink_of).sum()]
    }

    #[test]
    fn areas_have_their_ink_and_their_holes() {
        let disk = area(&[ring(30.0, 20.0, false)]);
        let hole = area(&[ring(30.0, 20.0, false), ring(30.0, 10.0, true)]);
        let twice = area(&[ring(30.0, 20.0, false), ring(30.0, 20.0, false)]);
        for (drawn, expected) in [(disk, 400.0), (hole, 300.0), (twice, 400.0)] {
            let expected = expected * std::f64::consts::PI;
            let [filled, hatched] = ink(&drawn);
            assert!((filled / expected - 1.0).abs() < 0.01, "{filled} and not {expected}");
            assert!((hatched / expected - 1.0).abs() < 0.08, "{hatched} and not {expected}");
            // Planted: without the last outline.
            let less = area(&[ring(30.0, 17.0, false)]);
            assert!((ink(&less)[0] / expected - 1.0).abs() > 0.03);
        }
        // The parts to the left of the picture and above it are cut off.
        let outside = area(&[ring(0.0, 20.0, false)]);
        assert!((ink(&outside)[0] / (100.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }
}
