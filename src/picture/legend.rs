//! The legend of a picture: a sample and a name of each kind of line and area that is drawn in it.
//!
//! Samples have the inks, widths and distances of the style's own layers, at the scale of the picture. An entry is only
//! shown if its ink is found in the picture: in the pictures of ink for a raster picture ([`Legend::look`]), and among
//! the groups of lines for a vector drawing ([`Legend::look_in`]). Lengths here are pixels of the style, which are
//! scaled with the dots per inch.

use glam::DVec2;
use kurbo::{Affine, BezPath, Circle, RoundedRect, Shape};

use super::Band;
use super::aov::{Plane, PlaneSource};
use super::title::{Block, LEGEND_HEIGHT, PEN, SMALL, grouped};
use crate::file::exr::Samples;
use crate::lettering::Line;
use crate::lettering::area::Area;
use crate::lettering::ink::PenStroke;
use crate::lines::strokes::polylines::Polyline;
use crate::style::layers::LINES_PER_INDEX;
use crate::style::{Color, DrainageLines, HeightsOf, Layer, Paper, Style, Typeface, Water};
use crate::surface::id::Kind;
use crate::vector::Group;

/// Height of a row of entries.
pub(super) const ROW: f64 = 21.0;
/// Width and height of a sample, the gap to its name, and the gap between entries.
const SAMPLE: [f64; 2] = [36.0, 13.0];
const NAME_GAP: f64 = 8.0;
const GAP: f64 = 26.0;
/// Width of the line above a legend.
const RULE: f64 = 0.6;
/// Ink and number of pixels with at least so much of it that a picture must have for an entry.
const LEAST_INK: f32 = 0.25;
const LEAST_PIXELS: usize = 6;
/// The longest interval that an entry may name, in metres: the space for entries is kept before the interval is known.
const LONGEST_INTERVAL_M: f32 = 10_000.0;
/// Pieces of a line whose width grows.
const PIECES: usize = 12;

/// The sample of an entry.
#[derive(Clone, Debug, PartialEq)]
enum Sample {
    /// A line whose width grows from `from_px` to `to_px`, between two lines of the width `beside_px`; 0 draws none.
    Line { ink: Color, from_px: f64, to_px: f64, beside_px: f64 },
    /// A dashed line: its width, and the lengths of dashes and gaps, in pixels.
    Dashes { ink: Color, width_px: f64, dash_px: f64, gap_px: f64 },
    /// Water on a paper.
    Water(Box<Water>, Color),
    /// Crowns of trees from above.
    Crowns { ink: Color },
}

/// How a picture shows that an entry is drawn.
#[derive(Clone, Debug, PartialEq)]
enum Evidence {
    /// Ink of a layer, whose group of lines in a vector drawing has the id.
    Ink { layer: usize, id: String },
    /// Ink of contour lines, and land that reaches across a multiple of `every_m` metres. In a vector drawing the lines
    /// there are wider than `least_px`.
    IndexLines { layer: usize, id: String, every_m: f32, least_px: f32 },
    /// Pixels of trees.
    Trees,
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    name: String,
    sample: Sample,
    evidence: Evidence,
    is_drawn: bool,
}

/// The legend of a picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Legend {
    entries: Vec<Entry>,
    /// Pixels with ink, by layer.
    inked: Vec<usize>,
    trees: usize,
    /// Lowest and highest land, in metres as it is drawn.
    range_m: [f32; 2],
    exaggeration: f32,
}

/// Where a legend is on a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LegendPlace {
    /// Upper left corner, in pixels.
    pub at: DVec2,
    /// Width in pixels, and the number of rows for which there is space.
    pub room_px: f64,
    pub rows: usize,
    /// Pixels per pixel of the style.
    pub px: f64,
    pub typeface: Typeface,
    /// Colour of names.
    pub ink: Color,
}

/// Returns the entries of all that a style can draw.
fn entries(style: &Style, longest_m: Option<f32>) -> Vec<Entry> {
    let inks = style.inks();
    let lettering = style.lettering_ink();
    let mut entries = Vec::new();
    let mut add = |name: String, sample: Sample, evidence: Evidence| {
        // A second layer of a kind is the same to a reader.
        if entries.iter().all(|entry: &Entry| entry.name != name) {
            entries.push(Entry { name, sample, evidence, is_drawn: false });
        }
    };
    for (layer, own) in style.layers.iter().enumerate() {
        let Some(ink) = inks.iter().find(|ink| ink.layer == Some(layer)) else { continue };
        let id = ink.id(None);
        let seen = Evidence::Ink { layer, id: id.clone() };
        let ink = ink.color;
        match own {
            Layer::HeightLines(lines) => {
                let interval_m = longest_m.unwrap_or(lines.interval_m);
                let [thin, wide] = [lines.line_px, lines.index_px].map(f64::from);
                let words = |name: &str, every_m: f32| match every_m.fract() {
                    0.0 => format!("{name} every {} m", grouped(every_m.into())),
                    _ => format!("{name} every {every_m} m"),
                };
                let sample = Sample::Line { ink, from_px: thin, to_px: thin, beside_px: thin };
                let name = if lines.of == HeightsOf::Sea { "Depth contours" } else { "Contour lines" };
                add(words(name, interval_m), sample, seen);
                // Depths have no entry of their own: the sea in view may have no index line.
                if wide > thin && lines.of == HeightsOf::Land {
                    let every_m = LINES_PER_INDEX as f32 * interval_m;
                    let sample = Sample::Line { ink, from_px: wide, to_px: wide, beside_px: thin };
                    let least_px = 0.5 * (lines.line_px + lines.index_px);
                    add(words("Index lines", every_m), sample, Evidence::IndexLines { layer, id, every_m, least_px });
                }
            }
            Layer::Drainage(lines) => {
                let name = match lines.of {
                    DrainageLines::Streams => "Streams",
                    DrainageLines::Ridges => "Ridge lines",
                };
                let [from_px, to_px] = [lines.line_px, lines.widest_px.max(lines.line_px)].map(f64::from);
                add(name.to_owned(), Sample::Line { ink, from_px, to_px, beside_px: 0.0 }, seen);
            }
            Layer::Water(water) => {
                add("Water".to_owned(), Sample::Water(Box::new(water.clone()), style.paper.color), seen);
            }
            Layer::Features(features) => {
                let width_px = f64::from(features.line_px.max(0.25));
                let sample = Sample::Line { ink, from_px: width_px, to_px: width_px, beside_px: 0.0 };
                let name = if features.file.is_empty() { "Features" } else { &features.file };
                add(name.to_owned(), sample, seen);
            }
            Layer::Rims(rims) if rims.width_px > 0.0 => {
                let [width_px, dash_px, gap_px] = [rims.width_px, rims.dash_px, rims.gap_px].map(f64::from);
                add("Land without data".to_owned(), Sample::Dashes { ink, width_px, dash_px, gap_px }, seen);
            }
            _ => {}
        }
    }
    add("Trees".to_owned(), Sample::Crowns { ink: lettering }, Evidence::Trees);
    entries
}

/// Returns the largest number of rows that a legend of a style needs in a width of `room_px` pixels of the style.
pub(crate) fn most_rows(style: &Style, room_px: f64) -> usize {
    let entries = entries(style, Some(LONGEST_INTERVAL_M));
    rows(&entries.iter().collect::<Vec<_>>(), room_px, style.paper.typeface).len()
}

/// Distributes entries to rows: each with its distance from the left, in pixels of the style.
fn rows<'a>(entries: &[&'a Entry], room_px: f64, typeface: Typeface) -> Vec<Vec<(f64, &'a Entry)>> {
    let mut rows: Vec<Vec<(f64, &Entry)>> = Vec::new();
    let mut x = 0.0;
    for entry in entries {
        let width = SAMPLE[0] + NAME_GAP + SMALL[0] * Line::small(&entry.name, typeface).width();
        if rows.is_empty() || x + width > room_px {
            rows.push(Vec::new());
            x = 0.0;
        }
        rows.last_mut().into_iter().for_each(|row| row.push((x, *entry)));
        x += width + GAP;
    }
    rows
}

impl Legend {
    /// Creates a legend of a picture of which nothing has been seen.
    pub(crate) fn new(style: &Style, exaggeration: f64) -> Self {
        Self {
            entries: entries(style, None),
            inked: vec![0; style.layers.len()],
            trees: 0,
            range_m: [f32::MAX, f32::MIN],
            exaggeration: exaggeration as f32,
        }
    }

    /// Returns the channels that a raster picture must have for [`Legend::look`].
    pub(crate) fn planes(&self) -> Vec<Plane> {
        let mut planes = Vec::new();
        let mut add = |source| {
            let plane = Plane { name: "legend".to_owned(), source };
            if !planes.contains(&plane) {
                planes.push(plane);
            }
        };
        for entry in &self.entries {
            match &entry.evidence {
                Evidence::Ink { layer, .. } => add(PlaneSource::Ink(*layer)),
                Evidence::IndexLines { layer, .. } => {
                    add(PlaneSource::Ink(*layer));
                    add(PlaneSource::WorldPosition(2));
                }
                Evidence::Trees => add(PlaneSource::SurfaceId),
            }
        }
        planes
    }

    /// Looks at a band of a picture whose last channels are [`Legend::planes`], and removes these. `area` are the columns
    /// and rows of the picture that are not paper, each from the first to the one after the last.
    pub(crate) fn look(&mut self, band: &mut Band, width: usize, [columns, rows]: [[usize; 2]; 2]) {
        let planes = self.planes();
        let own = band.planes.split_off(band.planes.len() - planes.len().min(band.planes.len()));
        let first = band.first_row as usize;
        let inside = |i: usize| {
            let (x, y) = (i % width.max(1), first + i / width.max(1));
            x >= columns[0] && x < columns[1] && y >= rows[0] && y < rows[1]
        };
        for (plane, samples) in planes.iter().zip(&own) {
            match (plane.source, samples) {
                (PlaneSource::Ink(layer), Samples::F32(ink)) => {
                    let inked = ink.iter().enumerate().filter(|(i, ink)| **ink >= LEAST_INK && inside(*i));
                    self.inked[layer] += inked.count();
                }
                (PlaneSource::WorldPosition(_), Samples::F32(heights_m)) => {
                    // The sky has the height 0.
                    for (_, height_m) in heights_m.iter().enumerate().filter(|(i, at)| **at != 0.0 && inside(*i)) {
                        self.range_m = [self.range_m[0].min(*height_m), self.range_m[1].max(*height_m)];
                    }
                }
                (PlaneSource::SurfaceId, Samples::U32(ids)) => {
                    let trees = ids.iter().enumerate().filter(|(i, id)| Kind::of(**id) == Kind::Tree && inside(*i));
                    self.trees += trees.count();
                }
                _ => {}
            }
        }
        let has_ink = |layer: usize| self.inked[layer] >= LEAST_PIXELS;
        for entry in &mut self.entries {
            entry.is_drawn = match &entry.evidence {
                Evidence::Ink { layer, .. } => has_ink(*layer),
                Evidence::IndexLines { layer, every_m, .. } => {
                    let [low, high] = self.range_m.map(|height_m| (height_m / (every_m * self.exaggeration)).floor());
                    has_ink(*layer) && high > low
                }
                Evidence::Trees => self.trees >= LEAST_PIXELS,
            };
        }
    }

    /// Looks at the groups of lines of a vector drawing. Trees have no group of their own, and no entry. Water has only
    /// its lines.
    pub(crate) fn look_in(&mut self, groups: &[Group]) {
        for entry in &mut self.entries {
            let of = |own: &String| -> Vec<&Polyline> {
                groups.iter().filter(|group| group.id == *own).flat_map(|group| &group.lines).collect()
            };
            entry.is_drawn = match &entry.evidence {
                Evidence::Ink { id, .. } => !of(id).is_empty(),
                Evidence::IndexLines { id, least_px, .. } => {
                    of(id).iter().flat_map(|line| &line.points).any(|point| 2.0 * point.half_width_px > *least_px)
                }
                Evidence::Trees => false,
            };
            if let Sample::Water(water, _) = &mut entry.sample {
                water.tint = Color::WHITE;
            }
        }
    }

    /// Returns whether nothing that a legend explains is drawn.
    pub(crate) fn is_empty(&self) -> bool {
        !self.entries.iter().any(|entry| entry.is_drawn)
    }

    /// Returns the names of what is drawn.
    #[cfg(test)]
    pub(crate) fn names(&self) -> Vec<&str> {
        self.entries.iter().filter(|entry| entry.is_drawn).map(|entry| &*entry.name).collect()
    }

    /// Lays out the entries of what is drawn: a block for each ink, from the bottom to the top.
    pub(crate) fn blocks(&self, place: &LegendPlace) -> Vec<Block> {
        let LegendPlace { at, room_px, px, typeface, .. } = *place;
        let drawn: Vec<&Entry> = self.entries.iter().filter(|entry| entry.is_drawn).collect();
        let rows = rows(&drawn, room_px / px, typeface);
        if rows.is_empty() {
            return Vec::new();
        }
        let mut blocks = Vec::new();
        let mut names = Block::empty(place.ink);
        let rule = at - DVec2::new(0.0, 0.5 * LEGEND_HEIGHT * px);
        names.strokes.push(PenStroke::line(rule, rule + DVec2::X * room_px, RULE * px));
        // Rows that are not needed are above and below the others.
        let spare = 0.5 * ROW * place.rows.saturating_sub(rows.len()) as f64;
        for (number, row) in rows.iter().enumerate() {
            let y = at.y + (spare + ROW * (number as f64 + 0.5)) * px;
            for (x, entry) in row {
                let from = DVec2::new(at.x + x * px, y);
                blocks.extend(sample(&entry.sample, from, px));
                let height = SMALL[0] * px;
                let begin = from + DVec2::new((SAMPLE[0] + NAME_GAP) * px, 0.5 * height);
                let line = Line::small(&entry.name, typeface);
                let width_px = (PEN * height).max(1.15 * px);
                names
                    .strokes
                    .extend(line.strokes(begin, height).into_iter().map(|points| PenStroke { points, width_px }));
                names.areas.extend(line.areas(begin, height));
                names.texts.extend(line.words(begin, height));
            }
        }
        blocks.push(names);
        blocks
    }
}

/// Returns the height of a curve in the middle of a sample, as a part of its height, at `t` from its left end (0) to its
/// right end (1).
fn curve(t: f64) -> f64 {
    0.2 * ((0.08 + 0.84 * t) * std::f64::consts::TAU).sin()
}

/// Draws a sample: its left end, in the middle of its height, is at `from`.
fn sample(sample: &Sample, from: DVec2, px: f64) -> Vec<Block> {
    let [width, height] = SAMPLE.map(|side| side * px);
    let on_curve = |t: f64, up: f64| from + DVec2::new(width * t, -height * (curve(t) + up));
    let along = |begin: f64, end: f64, up: f64| -> Vec<DVec2> {
        (0..=8).map(|i| on_curve(begin + (end - begin) * f64::from(i) / 8.0, up)).collect()
    };
    match sample {
        Sample::Line { ink, from_px, to_px, beside_px } => {
            let mut block = Block::empty(*ink);
            if from_px == to_px {
                let points = (0..=48).map(|i| on_curve(f64::from(i) / 48.0, 0.0)).collect();
                block.strokes.push(PenStroke { points, width_px: *from_px });
            } else {
                block.strokes.extend((0..PIECES).map(|piece| {
                    let [begin, end] = [piece, piece + 1].map(|piece| piece as f64 / PIECES as f64);
                    let width_px = from_px + (to_px - from_px) * 0.5 * (begin + end);
                    PenStroke { points: along(begin, end, 0.0), width_px }
                }));
            }
            for up in [-0.34, 0.34].iter().filter(|_| *beside_px > 0.0) {
                let points = (0..=48).map(|i| on_curve(f64::from(i) / 48.0, *up)).collect();
                block.strokes.push(PenStroke { points, width_px: *beside_px });
            }
            vec![block]
        }
        Sample::Dashes { ink, width_px, dash_px, gap_px } => {
            let mut block = Block::empty(*ink);
            let step = (dash_px + gap_px).max(1.0);
            let mut x = 0.0;
            while x < width {
                let [begin, end] = [x, (x + dash_px).min(width)].map(|x| x / width);
                block.strokes.push(PenStroke { points: along(begin, end, 0.0), width_px: *width_px });
                x += step;
            }
            vec![block]
        }
        Sample::Water(water, paper) => water_sample(water, *paper, from, px),
        Sample::Crowns { ink } => {
            let mut block = Block::empty(*ink);
            for [x, y, radius] in [[0.26, 0.1, 0.34], [0.52, -0.12, 0.3], [0.76, 0.12, 0.36]] {
                let middle = from + DVec2::new(width * x, height * y);
                let circle = Circle::new((middle.x, middle.y), height * radius);
                block.strokes.push(PenStroke { points: points_of(&circle.to_path(0.05)), width_px: px });
            }
            vec![block]
        }
    }
}

/// Draws a piece of water with its shore, and with its water lines or ruled lines.
fn water_sample(water: &Water, paper: Color, from: DVec2, px: f64) -> Vec<Block> {
    let [width, height] = SAMPLE.map(|side| side * px);
    let top = from.y - 0.5 * height;
    let inset = |by: f64| {
        let radius = (3.0 * px - by).max(0.0);
        RoundedRect::new(from.x + by, top + by, from.x + width - by, top + height - by, radius).to_path(0.05)
    };
    let mut blocks = Vec::new();
    if water.tint != Color::WHITE {
        let mut fill = Block::empty(product(water.tint, paper));
        fill.areas.push(Area::new(inset(0.0), px));
        blocks.push(fill);
    }
    let mut shore = Block::empty(water.ink);
    if water.shore_px > 0.0 {
        shore.strokes.push(PenStroke { points: points_of(&inset(0.0)), width_px: water.shore_px.into() });
    }
    let spacing = f64::from(water.spacing_px);
    let line_px = f64::from(water.line_px);
    if water.rules {
        let mut y = spacing;
        while y < height {
            let [left, right] = [from.x + px, from.x + width - px].map(|x| DVec2::new(x, top + y));
            shore.strokes.push(PenStroke::line(left, right, line_px));
            y += spacing;
        }
    }
    blocks.push(shore);
    let (mut by, mut gap, mut part) = (spacing, spacing, 1.0);
    for _ in 0..if water.rules { 0 } else { water.lines } {
        if 2.0 * by >= height - line_px {
            break;
        }
        let mut line = Block::empty(mixed(product(water.tint, paper), water.ink, part));
        line.strokes.push(PenStroke { points: points_of(&inset(by)), width_px: line_px });
        blocks.push(line);
        gap *= f64::from(water.growth);
        (by, part) = (by + gap, part * water.paler);
    }
    blocks
}

fn product(a: Color, b: Color) -> Color {
    let [a, b] = [a, b].map(Color::linear);
    Color::from_srgb([0, 1, 2].map(|i| crate::style::color::srgb_from_linear(a[i] * b[i])))
}

/// Returns a colour of which `part` is ink.
fn mixed(under: Color, ink: Color, part: f32) -> Color {
    let [under, ink] = [under, ink].map(Color::linear);
    Color::from_srgb([0, 1, 2].map(|i| crate::style::color::srgb_from_linear(under[i] + (ink[i] - under[i]) * part)))
}

/// Returns the corners of an outline as a polygon, with the first one again at its end.
fn points_of(path: &BezPath) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = Vec::new();
    kurbo::flatten(Affine::IDENTITY * path.clone(), 0.05, |element| {
        if let Some(at) = element.end_point() {
            points.push(DVec2::new(at.x, at.y));
        }
    });
    points.extend(points.first().copied());
    points
}

/// Returns the columns and rows of a picture that are not paper, each from the first to the one after the last.
pub(crate) fn drawn_area(paper: &Paper, [width, height]: [u32; 2]) -> [[usize; 2]; 2] {
    let edge = (paper.margin_px + paper.border_px).ceil() as usize;
    let [right, bottom] = [width as usize, (height as usize).saturating_sub(paper.foot_px.ceil() as usize)];
    [[edge, right.saturating_sub(edge)], [edge, bottom.saturating_sub(edge)]]
}

#[cfg(test)]
mod tests;
