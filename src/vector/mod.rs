//! Turns strokes into a vector drawing: they are ordered, fitted with curves, and placed on a page. All functions take
//! [`Polyline`]s from any source.
//!
//! ```text
//! images of ink ─▶ trace ─▶ polylines
//! polylines ─ by kind ─▶ pens ─▶ order ─▶ fit ─▶ sheet ─▶ file::svg
//! ```
//!
//! A stroke of the drawing has one width and one opacity, the means over its length: an SVG path has only one of each,
//! and a pen has one nib. SVG viewers blend encoded sRGB values, hachure blends linear light. So the opacity of a faint
//! stroke is not its fraction of ink, but the value that looks the same on white.
//!
//! Why: `docs/decisions/svg-drawings.md`.

pub(crate) mod border;
pub(crate) mod fit;
pub(crate) mod grid;
pub(crate) mod improve;
pub(crate) mod order;
pub(crate) mod pens;
pub(crate) mod sheet;
pub(crate) mod sheets;
pub(crate) mod trace;

use kurbo::{BezPath, Point};
use rayon::prelude::*;
use serde::Serialize;

use self::order::{Visit, order, pen_up_px};
use self::pens::{Pens, pieces};
use self::sheet::Sheet;
use crate::file::svg::{Layer, Stroke, Text};
use crate::lines::strokes::polylines::{EdgeKind, Polyline};
use crate::style::Color;
use crate::style::color::{linear_from_srgb, srgb_from_linear};

/// Default distance between paths and strokes.
pub(crate) const TOLERANCE_PX: f64 = 0.25;

/// Number of tones for the faint ink of marks.
const FAINT_STEPS: f64 = 32.0;
/// Position from which a pen starts: the upper left corner of the picture.
const CORNER_PX: [f64; 2] = [0.0; 2];
/// Rounding step of written numbers, as a fraction of the tolerance.
const ROUNDED_PART: f64 = 0.02;

/// Settings of a vector drawing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Largest distance between paths and strokes, in pixels.
    pub tolerance_px: f64,
    /// The page on which the strokes are drawn.
    pub sheet: Sheet,
    /// Default colour of the strokes.
    pub ink: Color,
}

impl Settings {
    /// Returns the number of decimal places with which coordinates are written.
    pub(crate) fn digits(&self) -> usize {
        let step = ROUNDED_PART * self.tolerance_px * self.sheet.units_per_px;
        (-step.log10()).ceil().clamp(2.0, 9.0) as usize
    }

    /// Returns the largest distance by which rounding to these decimal places moves a point: half a step on each axis.
    fn rounding_px(&self) -> f64 {
        std::f64::consts::FRAC_1_SQRT_2 * 0.1_f64.powi(self.digits() as i32) / self.sheet.units_per_px
    }
}

/// Returns the opacity that on white looks like the fraction `part` of ink. The opacity is for viewers that blend
/// encoded sRGB values; the fraction of ink is in linear light.
fn opacity(ink: &Color, part: f64) -> f64 {
    let part = part.clamp(0.0, 1.0) as f32;
    let darkest = ink.srgb().into_iter().fold(1.0, f32::min);
    if darkest > 0.95 {
        return part.into();
    }
    let light = 1.0 + (linear_from_srgb(darkest) - 1.0) * part;
    f64::from((1.0 - srgb_from_linear(light)) / (1.0 - darkest)).clamp(0.0, 1.0)
}

/// Lines of one kind. They become one layer of the drawing, or one for each pen.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// XML id of the layer.
    pub id: String,
    /// Human-readable name of the layer.
    pub label: String,
    /// Colour of the lines.
    pub ink: Color,
    /// Kind of the lines.
    pub kind: GroupKind,
    /// The lines, in no particular order.
    pub lines: Vec<Polyline>,
    /// Areas that are filled with the ink, in pixels. Pens cannot draw them.
    pub fills: Vec<BezPath>,
    /// The words of the letters among the lines and areas, in pixels. Pens have none.
    pub texts: Vec<Text>,
}

/// The kind of the lines of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GroupKind {
    /// Strokes along edges of this kind; each becomes one path.
    Strokes(EdgeKind),
    /// Lines of another ink: a path ends where the width changes.
    Ink(InkKind),
}

/// The kind of the lines of an ink other than strokes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InkKind {
    /// Hatching marks, rows, cuts, lines from shading, lines of the sky, and lettering.
    Mark,
    /// Contour lines of height.
    ContourLine,
    /// Streams.
    Stream,
    /// Ridge lines that follow from how the land drains.
    RidgeLine,
    /// Points, lines and areas from files.
    Feature,
    /// Dashes along no-data.
    Rim,
    /// Lines along the shores of water.
    Shoreline,
    /// Water lines or ruled lines, with the shorelines of the same ink.
    WaterLine,
}

impl InkKind {
    /// Returns the name of the kind.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Mark => "mark",
            Self::ContourLine => "contour line",
            Self::Stream => "stream",
            Self::RidgeLine => "ridge line",
            Self::Feature => "feature",
            Self::Rim => "rim",
            Self::Shoreline => "shoreline",
            Self::WaterLine => "water line",
        }
    }
}

impl GroupKind {
    /// Returns the name of the kind in one or two words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Strokes(EdgeKind::Contour) => "contour",
            Self::Strokes(EdgeKind::Border) => "border",
            Self::Strokes(EdgeKind::Crease) => "crease",
            Self::Strokes(EdgeKind::Suggestive) => "suggestive contour",
            Self::Strokes(EdgeKind::Ridge) => "ridge",
            Self::Strokes(EdgeKind::Valley) => "valley",
            Self::Ink(kind) => kind.name(),
        }
    }
}

/// Groups strokes by the kind of edge that they follow; groups without strokes are left out.
pub(crate) fn groups(polylines: &[Polyline], ink: Color) -> Vec<Group> {
    let group = |kind: EdgeKind| {
        let lines = polylines.iter().filter(|line| line.kind == kind && !line.points.is_empty());
        let (id, label) = match kind {
            EdgeKind::Contour => ("contours", "Contours"),
            EdgeKind::Border => ("borders", "Borders"),
            EdgeKind::Crease => ("creases", "Creases"),
            EdgeKind::Suggestive => ("suggestive-contours", "Suggestive contours"),
            EdgeKind::Ridge => ("ridges", "Ridges"),
            EdgeKind::Valley => ("valleys", "Valleys"),
        };
        let (id, label) = (id.to_owned(), label.to_owned());
        Group {
            id,
            label,
            ink,
            kind: GroupKind::Strokes(kind),
            lines: lines.cloned().collect(),
            fills: Vec::new(),
            texts: Vec::new(),
        }
    };
    EdgeKind::ALL.map(group).into_iter().filter(|group| !group.lines.is_empty()).collect()
}

/// Statistics of a vector drawing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct DrawingReport {
    /// Number of paths.
    pub strokes: u64,
    /// Number of paths along contours.
    pub contours: u64,
    /// Number of paths along borders of the land.
    pub borders: u64,
    /// Number of paths along creases.
    pub creases: u64,
    /// Number of paths along suggestive contours.
    pub suggestive: u64,
    /// Number of paths along ridges.
    pub ridges: u64,
    /// Number of paths along valleys.
    pub valleys: u64,
    /// Number of paths along streams.
    pub streams: u64,
    /// Number of paths along ridge lines.
    pub ridge_lines: u64,
    /// Number of paths that are marks: hachures, hatching, and other lines without a count of their own.
    pub marks: u64,
    /// Number of paths that are contour lines of height.
    pub contour_lines: u64,
    /// Number of paths that are points, lines, and outlines and hatching of areas from files.
    pub features: u64,
    /// Number of paths that are dashes along no-data.
    pub rims: u64,
    /// Number of paths that are shorelines.
    pub shorelines: u64,
    /// Number of paths that are water lines, and shorelines of the same ink.
    pub water_lines: u64,
    /// Widths of the pens in the page's unit; empty without pens.
    pub pens: Vec<f64>,
    /// Number of curves and straight lines of all paths.
    pub segments: u64,
    /// Length drawn on the paper, in pixels.
    pub pen_down_px: f64,
    /// Pen-up travel if the strokes were drawn in the order in which they were found; each layer starts at the upper
    /// left corner.
    pub pen_up_unordered_px: f64,
    /// Pen-up travel in the order of the file.
    pub pen_up_px: f64,
}

impl DrawingReport {
    /// Returns the number of paths of each kind, with the name of the kind; kinds without paths are left out.
    pub(crate) fn kinds(&self) -> impl Iterator<Item = (u64, &'static str)> {
        let strokes = [
            (self.contours, EdgeKind::Contour),
            (self.borders, EdgeKind::Border),
            (self.creases, EdgeKind::Crease),
            (self.suggestive, EdgeKind::Suggestive),
            (self.ridges, EdgeKind::Ridge),
            (self.valleys, EdgeKind::Valley),
        ];
        let inks = [
            (self.contour_lines, InkKind::ContourLine),
            (self.streams, InkKind::Stream),
            (self.ridge_lines, InkKind::RidgeLine),
            (self.marks, InkKind::Mark),
            (self.features, InkKind::Feature),
            (self.rims, InkKind::Rim),
            (self.shorelines, InkKind::Shoreline),
            (self.water_lines, InkKind::WaterLine),
        ];
        let strokes = strokes.map(|(count, kind)| (count, GroupKind::Strokes(kind).name()));
        let inks = inks.map(|(count, kind)| (count, kind.name()));
        strokes.into_iter().chain(inks).filter(|(count, _)| *count > 0)
    }

    /// Adds the statistics of another drawing.
    pub(crate) fn append(&mut self, other: &Self) {
        self.strokes += other.strokes;
        self.contours += other.contours;
        self.borders += other.borders;
        self.creases += other.creases;
        self.suggestive += other.suggestive;
        self.ridges += other.ridges;
        self.valleys += other.valleys;
        self.marks += other.marks;
        self.contour_lines += other.contour_lines;
        self.streams += other.streams;
        self.ridge_lines += other.ridge_lines;
        self.features += other.features;
        self.rims += other.rims;
        self.shorelines += other.shorelines;
        self.water_lines += other.water_lines;
        self.pens.clone_from(&other.pens);
        self.segments += other.segments;
        self.pen_down_px += other.pen_down_px;
        self.pen_up_unordered_px += other.pen_up_unordered_px;
        self.pen_up_px += other.pen_up_px;
    }
}

/// Makes a layer of each group, or of each of its pens; layers without strokes are left out. Paths are in the page's
/// unit and within the tolerance of the lines, including the rounding to [`Settings::digits`].
pub(crate) fn layers(groups: &[Group], settings: &Settings, pens: Option<&Pens>) -> (Vec<Layer>, DrawingReport) {
    let widths =
        pens.map(|pens| pens.widths_px.iter().map(|px| f64::from(*px) * settings.sheet.units_per_px).collect());
    let mut report = DrawingReport { pens: widths.unwrap_or_default(), ..DrawingReport::default() };
    let mut layers = Vec::new();
    for group in groups {
        let Some(pens) = pens else {
            layers.extend(layer(group, (&group.id, &group.label, None), &group.lines, settings, &mut report));
            continue;
        };
        let mut by_pen = vec![Vec::new(); pens.widths_px.len()];
        for line in &group.lines {
            pens.strokes(line).into_iter().for_each(|(pen, stroke)| by_pen[pen].push(stroke));
        }
        for (pen, lines) in by_pen.iter().enumerate() {
            let number = pen + 1;
            // Plotter software reads the number at the beginning of a layer's name as the number of its pen.
            let (id, label) = (format!("{}-pen-{number}", group.id), format!("{number}. pen: {}", group.label));
            layers.extend(layer(group, (&id, &label, Some(number)), lines, settings, &mut report));
        }
    }
    (layers, report)
}

/// Makes a layer of lines of a group, and adds its statistics to the report.
fn layer(
    group: &Group,
    (id, label, pen): (&str, &str, Option<usize>),
    lines: &[Polyline],
    settings: &Settings,
    report: &mut DrawingReport,
) -> Option<Layer> {
    let strokes: Vec<&Polyline> = lines.iter().filter(|line| !line.points.is_empty()).collect();
    let fills: Vec<BezPath> =
        if pen.is_none() { group.fills.iter().map(|fill| settings.sheet.place() * fill).collect() } else { Vec::new() };
    if strokes.is_empty() && fills.is_empty() {
        return None;
    }
    let written = group.texts.iter().filter(|_| pen.is_none());
    let texts = written.map(|text| text.placed(settings.sheet.place())).collect();
    let given: Vec<Visit> = (0..strokes.len()).map(Visit::as_is).collect();
    let visits = order(&strokes, CORNER_PX);
    report.pen_up_unordered_px += pen_up_px(&strokes, &given, CORNER_PX);
    report.pen_up_px += pen_up_px(&strokes, &visits, CORNER_PX);
    let drawn: Vec<(Stroke, f64)> =
        visits.par_iter().flat_map_iter(|visit| paths(&strokes, visit, group, settings)).collect();
    report.pen_down_px += drawn.iter().map(|(_, length_px)| length_px).sum::<f64>();
    let drawn: Vec<Stroke> = drawn.into_iter().map(|(stroke, _)| stroke).collect();
    let count = drawn.len() as u64;
    report.strokes += count;
    report.segments += drawn.iter().map(|stroke| segments(&stroke.path)).sum::<u64>();
    *match group.kind {
        GroupKind::Strokes(EdgeKind::Contour) => &mut report.contours,
        GroupKind::Strokes(EdgeKind::Border) => &mut report.borders,
        GroupKind::Strokes(EdgeKind::Crease) => &mut report.creases,
        GroupKind::Strokes(EdgeKind::Suggestive) => &mut report.suggestive,
        GroupKind::Strokes(EdgeKind::Ridge) => &mut report.ridges,
        GroupKind::Strokes(EdgeKind::Valley) => &mut report.valleys,
        GroupKind::Ink(InkKind::Mark) => &mut report.marks,
        GroupKind::Ink(InkKind::ContourLine) => &mut report.contour_lines,
        GroupKind::Ink(InkKind::Stream) => &mut report.streams,
        GroupKind::Ink(InkKind::RidgeLine) => &mut report.ridge_lines,
        GroupKind::Ink(InkKind::Feature) => &mut report.features,
        GroupKind::Ink(InkKind::Rim) => &mut report.rims,
        GroupKind::Ink(InkKind::Shoreline) => &mut report.shorelines,
        GroupKind::Ink(InkKind::WaterLine) => &mut report.water_lines,
    } += count;
    let ink = (group.ink != settings.ink).then(|| group.ink.to_string());
    let (id, label, kind) = (id.to_owned(), label.to_owned(), group.kind.name());
    Some(Layer { id, label, ink, kind, pen, strokes: drawn, fills, texts })
}

/// Makes one layer in one ink of all strokes of an eye; an anaglyph has two such layers.
pub(crate) fn layer_of_eye(
    polylines: &[Polyline],
    settings: &Settings,
    (id, label, ink): (&str, &str, &str),
) -> (Layer, DrawingReport) {
    let (layers, report) = layers(&groups(polylines, settings.ink), settings, None);
    let strokes = layers.into_iter().flat_map(|layer| layer.strokes).collect();
    let (id, label, ink) = (id.to_owned(), label.to_owned(), Some(ink.to_owned()));
    (Layer { id, label, ink, kind: "stroke", pen: None, strokes, fills: Vec::new(), texts: Vec::new() }, report)
}

fn segments(path: &BezPath) -> u64 {
    path.segments().count() as u64
}

/// Returns the paths of a line in drawing order, and their lengths in pixels.
fn paths(strokes: &[&Polyline], visit: &Visit, group: &Group, settings: &Settings) -> Vec<(Stroke, f64)> {
    let line = visit.drawn(strokes);
    let pieces = if matches!(group.kind, GroupKind::Ink(_)) { pieces(&line) } else { vec![line] };
    pieces.iter().map(|piece| path(piece, group, settings)).collect()
}

/// Returns the path of a line, and its length in pixels.
fn path(line: &Polyline, Group { ink, kind, .. }: &Group, settings: &Settings) -> (Stroke, f64) {
    let points: Vec<Point> = line.points.iter().map(|at| Point::new(at.px[0].into(), at.px[1].into())).collect();
    let mut path = fit::fit(&points, line.is_closed, settings.tolerance_px - settings.rounding_px());
    path.apply_affine(settings.sheet.place());
    let means = Means::of(line);
    let width = 2.0 * means.half_width_px * settings.sheet.units_per_px;
    let (opacity, ink) = match kind {
        GroupKind::Strokes(_) => (opacity(ink, means.ink), None),
        GroupKind::Ink(_) => (1.0, faint(ink, means.ink)),
    };
    (Stroke { path, width, opacity, ink }, means.length_px)
}

/// Returns the colour of faint ink on white; `None` for full ink. A colour is used instead of an opacity because pieces
/// of a mark overlap where they meet, which would show.
fn faint(ink: &Color, part: f64) -> Option<String> {
    let part = (part * FAINT_STEPS).round() / FAINT_STEPS;
    let on_white = |own: f32| srgb_from_linear(1.0 + (linear_from_srgb(own) - 1.0) * part as f32);
    (part < 1.0).then(|| Color::from_srgb(ink.srgb().map(on_white)).to_string())
}

/// Length of a polyline, and means over its length.
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
