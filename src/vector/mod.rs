//! Strokes become a drawing of lines: ordered, fitted, laid on a sheet. Everything here takes
//! [`Polyline`]s, wherever they come from.
//!
//! ```text
//! polylines ─ by kind ─▶ order ─▶ fit ─▶ sheet ─▶ file::svg
//! ```
//!
//! A stroke of the drawing has one width and one opacity, the means of what was drawn, by length: a path has no others,
//! and a pen has one nib. Programs that show SVG mix colours as they are written; hachure mixes light. So a faint
//! stroke's opacity is not its part of ink, but what makes it look the same on white.
//!
//! Why: `docs/decisions/svg-drawings.md`.

pub mod fit;
pub mod grid;
pub mod improve;
pub mod order;
pub mod sheet;

use kurbo::BezPath;
use rayon::prelude::*;
use serde::Serialize;

use self::order::{Visit, order, pen_up_px};
use self::sheet::Sheet;
use crate::file::svg::{Layer, Stroke};
use crate::lines::strokes::polylines::{EdgeKind, Polyline};
use crate::style::Color;
use crate::style::color::{linear_from_srgb, srgb_from_linear};

/// How near paths are to the strokes, unless somebody says otherwise.
pub const TOLERANCE_PX: f64 = 0.25;

/// Where a pen waits: the upper left corner of the picture.
const CORNER_PX: [f64; 2] = [0.0; 2];
/// Numbers are rounded to this part of the tolerance.
const ROUNDED_PART: f64 = 0.02;

/// How strokes are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How near paths are to the strokes, in pixels.
    pub tolerance_px: f64,
    /// What they are drawn on.
    pub sheet: Sheet,
    /// Their colour.
    pub ink: Color,
}

impl Settings {
    /// Digits behind the point with which numbers on the sheet are written.
    pub fn digits(&self) -> usize {
        let step = ROUNDED_PART * self.tolerance_px * self.sheet.units_per_px;
        (-step.log10()).ceil().clamp(2.0, 9.0) as usize
    }

    /// What rounding to these digits may move a place, at most: half a step each way.
    fn rounding_px(&self) -> f64 {
        std::f64::consts::FRAC_1_SQRT_2 * 0.1_f64.powi(self.digits() as i32) / self.sheet.units_per_px
    }

    /// The opacity that looks on white, where colours are mixed as they are written, like this part of ink where light
    /// is mixed.
    fn opacity(&self, part: f64) -> f64 {
        let part = part.clamp(0.0, 1.0) as f32;
        let darkest = self.ink.srgb().into_iter().fold(1.0, f32::min);
        if darkest > 0.95 {
            return part.into();
        }
        let light = 1.0 + (linear_from_srgb(darkest) - 1.0) * part;
        f64::from((1.0 - srgb_from_linear(light)) / (1.0 - darkest)).clamp(0.0, 1.0)
    }
}

/// What came of the strokes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DrawingReport {
    /// Paths.
    pub strokes: u64,
    /// Of them.
    pub contours: u64,
    /// Of them.
    pub borders: u64,
    /// Of them.
    pub creases: u64,
    /// Curves and lines that paths consist of.
    pub segments: u64,
    /// On the paper.
    pub pen_down_px: f64,
    /// In the air, in the order in which strokes were found; from the upper left corner for each layer.
    pub pen_up_unordered_px: f64,
    /// In the air, as the file has them.
    pub pen_up_px: f64,
}

impl DrawingReport {
    /// Adds another drawing's.
    pub fn append(&mut self, other: &Self) {
        self.strokes += other.strokes;
        self.contours += other.contours;
        self.borders += other.borders;
        self.creases += other.creases;
        self.segments += other.segments;
        self.pen_down_px += other.pen_down_px;
        self.pen_up_unordered_px += other.pen_up_unordered_px;
        self.pen_up_px += other.pen_up_px;
    }
}

/// Layers by kind, those without strokes left out: one path for each polyline, in the sheet's unit and within the
/// tolerance of it, the rounding to [`Settings::digits`] included.
pub fn layers(polylines: &[Polyline], settings: &Settings) -> (Vec<Layer>, DrawingReport) {
    let mut report = DrawingReport::default();
    let mut layers = Vec::new();
    for kind in EdgeKind::ALL {
        let strokes: Vec<&Polyline> =
            polylines.iter().filter(|line| line.kind == kind && !line.points.is_empty()).collect();
        if strokes.is_empty() {
            continue;
        }
        let given: Vec<Visit> = (0..strokes.len()).map(Visit::as_is).collect();
        let visits = order(&strokes, CORNER_PX);
        report.pen_up_unordered_px += pen_up_px(&strokes, &given, CORNER_PX);
        report.pen_up_px += pen_up_px(&strokes, &visits, CORNER_PX);
        let drawn: Vec<(Stroke, f64)> = visits.par_iter().map(|visit| stroke(&strokes, visit, settings)).collect();
        report.pen_down_px += drawn.iter().map(|(_, length_px)| length_px).sum::<f64>();
        let drawn: Vec<Stroke> = drawn.into_iter().map(|(stroke, _)| stroke).collect();
        let count = drawn.len() as u64;
        report.strokes += count;
        report.segments += drawn.iter().map(|stroke| segments(&stroke.path)).sum::<u64>();
        let (id, label, counted) = match kind {
            EdgeKind::Contour => ("contours", "Contours", &mut report.contours),
            EdgeKind::Border => ("borders", "Borders", &mut report.borders),
            EdgeKind::Crease => ("creases", "Creases", &mut report.creases),
        };
        *counted += count;
        layers.push(Layer { id, label, ink: None, strokes: drawn });
    }
    (layers, report)
}

/// All strokes of an eye as one layer in an ink: an anaglyph has two of them.
pub fn layer_of_eye(
    polylines: &[Polyline],
    settings: &Settings,
    (id, label, ink): (&'static str, &'static str, &'static str),
) -> (Layer, DrawingReport) {
    let (layers, report) = layers(polylines, settings);
    let strokes = layers.into_iter().flat_map(|layer| layer.strokes).collect();
    (Layer { id, label, ink: Some(ink), strokes }, report)
}

fn segments(path: &BezPath) -> u64 {
    path.segments().count() as u64
}

/// The path of a stroke, and its length in pixels.
fn stroke(strokes: &[&Polyline], visit: &Visit, settings: &Settings) -> (Stroke, f64) {
    let line = strokes[visit.stroke];
    let mut path = fit::fit(&visit.points(strokes), line.is_closed, settings.tolerance_px - settings.rounding_px());
    path.apply_affine(settings.sheet.place());
    let means = Means::of(line);
    let width = 2.0 * means.half_width_px * settings.sheet.units_per_px;
    (Stroke { path, width, opacity: settings.opacity(means.ink) }, means.length_px)
}

/// Of a polyline, by length.
struct Means {
    length_px: f64,
    half_width_px: f64,
    ink: f64,
}

impl Means {
    fn of(line: &Polyline) -> Self {
        let mut sums = [0.0; 3];
        let around = line.is_closed.then_some(()).and(line.points.first());
        let next = line.points.iter().skip(1).chain(around);
        for (a, b) in line.points.iter().zip(next) {
            let [dx, dy] = [0, 1].map(|i| f64::from(b.px[i] - a.px[i]));
            let length_px = dx.hypot(dy);
            sums[0] += length_px;
            sums[1] += length_px * 0.5 * f64::from(a.half_width_px + b.half_width_px);
            sums[2] += length_px * 0.5 * f64::from(a.ink + b.ink);
        }
        let [length_px, half_width_px, ink] = sums;
        if length_px > 0.0 {
            return Self { length_px, half_width_px: half_width_px / length_px, ink: ink / length_px };
        }
        let first = line.points.first().copied().unwrap_or_default();
        Self { length_px, half_width_px: first.half_width_px.into(), ink: first.ink.into() }
    }
}
