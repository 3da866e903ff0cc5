//! SVG: paths in layers, for browsers, Inkscape and the programs of pen plotters.
//!
//! Each stroke is one `<path>` with its width and, where it is faint, its opacity; common attributes are on the layer.
//! A layer is a `<g>` with an `id` and the attributes by which Inkscape recognises layers; plotter programs read these
//! too. Coordinates are absolute and no path is transformed, so that a unit of the file is a unit of the page in every
//! program. There is no background: the page is the paper.
//!
//! Letters are drawn as outlines, which look the same without any font. Transparent text of the same words lies over
//! them, so that they are found, selected, copied and read aloud.

use std::io::Write;
use std::path::Path;

use kurbo::{Affine, BezPath, PathEl, Point, Rect, Vec2};

use super::FileError;
use super::atomic::AtomicFile;
use super::imprint::{self, KEY};

/// Height of capitals of usual fonts, as a part of their size.
pub(super) const CAPITALS: f64 = 0.7;

/// The unit of the file's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Pixels of the picture.
    Px,
    /// Millimetres of paper.
    Mm,
}

impl Unit {
    /// Returns the unit's name in SVG.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Px => "px",
            Self::Mm => "mm",
        }
    }
}

/// A drawing that consists of layers of strokes.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    /// Title for readers.
    pub title: String,
    /// Description for readers, in a line or two.
    pub description: String,
    /// Width and height in `unit`.
    pub size: [f64; 2],
    /// Unit of all lengths and coordinates.
    pub unit: Unit,
    /// Number of decimals.
    pub digits: usize,
    /// Colour of every path unless its layer or stroke has another: `#14120f`.
    pub ink: String,
    /// Layers, the lowest first.
    pub layers: Vec<Layer>,
}

#[derive(Clone, Debug)]
pub struct Layer {
    /// Identifier, which must be a valid XML name.
    pub id: String,
    /// Name that Inkscape shows for the layer.
    pub label: String,
    /// Colour of the layer, if it differs from the drawing's.
    pub ink: Option<String>,
    /// The kind of its strokes: `contour`, `border`, `crease`, `suggestive contour`, `ridge`, `valley`, `contour line`,
    /// `mark`, `rim`, `shoreline`, `water line`, or `stroke` for all strokes of an eye. It is not written to the SVG.
    pub kind: &'static str,
    /// Number of the pen that draws the layer, from 1, if pens are used.
    pub pen: Option<usize>,
    /// Strokes in drawing order.
    pub strokes: Vec<Stroke>,
    /// Areas in the colour of the layer: inside is where the path winds around a point.
    pub fills: Vec<BezPath>,
    /// The words whose letters are among the strokes and areas.
    pub texts: Vec<Text>,
}

/// Words that a drawing shows, on a straight baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    pub words: String,
    /// The left end of the baseline.
    pub begin: Point,
    /// From there to the right end.
    pub along: Vec2,
    /// Height of capitals, in the unit of the positions.
    pub height: f64,
}

impl Text {
    /// Moves the text by a similarity.
    pub(crate) fn placed(&self, place: Affine) -> Self {
        let begin = place * self.begin;
        let along = place * (self.begin + self.along) - begin;
        let factor = along.hypot() / self.along.hypot();
        Self { words: self.words.clone(), begin, along, height: factor * self.height }
    }

    /// Returns the box around the letters.
    pub(crate) fn around(&self) -> Rect {
        let up = self.height * Vec2::new(self.along.y, -self.along.x) / self.along.hypot();
        let baseline = Rect::from_points(self.begin, self.begin + self.along);
        baseline.union(Rect::from_points(self.begin + up, self.begin + self.along + up))
    }

    /// Returns whether it has a place and a size.
    pub(super) fn is_drawn(&self) -> bool {
        let is_finite = self.begin.is_finite() && self.along.is_finite() && self.height.is_finite();
        is_finite && self.height > 0.0 && self.along.hypot() > 0.0
    }
}

/// A path with a width.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// Centre line of the stroke.
    pub path: BezPath,
    /// Width in the drawing's unit.
    pub width: f64,
    /// Opacity, 0 to 1.
    pub opacity: f64,
    /// Colour of the stroke, if it differs from its layer's.
    pub ink: Option<String>,
}

/// Writes a drawing, completely or not at all, with an imprint that says how it was made ([`super::imprint`]).
///
/// # Errors
/// Fails if a number is not finite, the folder does not exist or is not writable, or the disk is full.
pub(crate) fn write_svg(path: &Path, drawing: &Drawing, imprint: Option<&str>) -> Result<(), FileError> {
    let strokes = drawing.layers.iter().flat_map(|layer| &layer.strokes);
    let is_finite = |stroke: &Stroke| stroke.path.is_finite() && stroke.width.is_finite() && stroke.opacity.is_finite();
    let mut fills = drawing.layers.iter().flat_map(|layer| &layer.fills);
    if !strokes.into_iter().all(is_finite)
        || !fills.all(BezPath::is_finite)
        || !drawing.size.into_iter().all(f64::is_finite)
    {
        return Err(FileError::write(path, "a stroke has a number that is not finite"));
    }
    let failed = |error| FileError::write(path, error);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    write(file.writer(), drawing, imprint).map_err(failed)?;
    file.commit().map_err(failed)
}

fn write(out: &mut impl Write, drawing: &Drawing, imprint: Option<&str>) -> std::io::Result<()> {
    let unit = drawing.unit.name();
    let number = |value: f64| number(value, drawing.digits);
    let [width, height] = drawing.size.map(number);
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(out, "<svg xmlns=\"http://www.w3.org/2000/svg\"")?;
    writeln!(out, "     xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\"")?;
    writeln!(
        out,
        "     version=\"1.1\" width=\"{width}{unit}\" height=\"{height}{unit}\" viewBox=\"0 0 {width} {height}\">"
    )?;
    writeln!(out, "<title>{}</title>", escaped(&drawing.title))?;
    writeln!(out, "<desc>{}</desc>", escaped(&drawing.description))?;
    if let Some(imprint) = imprint {
        writeln!(out, "<metadata id=\"{KEY}\">{}</metadata>", imprint::escaped(imprint))?;
    }
    for layer in &drawing.layers {
        writeln!(
            out,
            "<g id=\"{0}\" inkscape:groupmode=\"layer\" inkscape:label=\"{1}\"",
            escaped(&layer.id),
            escaped(&layer.label)
        )?;
        let ink = layer.ink.as_ref().unwrap_or(&drawing.ink);
        writeln!(out, "   fill=\"none\" stroke=\"{}\"", escaped(ink))?;
        writeln!(out, "   stroke-linecap=\"round\" stroke-linejoin=\"round\">")?;
        for stroke in &layer.strokes {
            write!(out, "<path stroke-width=\"{}\"", number(stroke.width))?;
            if stroke.opacity < 0.9995 {
                write!(out, " stroke-opacity=\"{}\"", self::number(stroke.opacity, 3))?;
            }
            if let Some(ink) = &stroke.ink {
                write!(out, " stroke=\"{}\"", escaped(ink))?;
            }
            writeln!(out, " d=\"{}\"/>", path_data(&stroke.path, drawing.digits))?;
        }
        for fill in &layer.fills {
            let data = path_data(fill, drawing.digits);
            writeln!(out, "<path fill=\"{}\" stroke=\"none\" d=\"{data}\"/>", escaped(ink))?;
        }
        for text in layer.texts.iter().filter(|text| text.is_drawn()) {
            let [x, y, length] = [text.begin.x, text.begin.y, text.along.hypot()].map(number);
            write!(out, "<text x=\"{x}\" y=\"{y}\" textLength=\"{length}\" lengthAdjust=\"spacingAndGlyphs\"")?;
            write!(out, " font-family=\"sans-serif\" font-size=\"{}\"", number(text.height / CAPITALS))?;
            let turn = self::number(text.along.atan2().to_degrees(), 3);
            if turn != "0" {
                write!(out, " transform=\"rotate({turn} {x} {y})\"")?;
            }
            writeln!(out, " fill=\"#000\" fill-opacity=\"0\" stroke=\"none\">{}</text>", escaped(&text.words))?;
        }
        writeln!(out, "</g>")?;
    }
    writeln!(out, "</svg>")
}

/// Formats a path as the attribute `d`.
fn path_data(path: &BezPath, digits: usize) -> String {
    let mut text = String::new();
    let place = |point: Point| format!("{},{}", number(point.x, digits), number(point.y, digits));
    for element in path.elements() {
        let words = match *element {
            PathEl::MoveTo(to) => format!("M{}", place(to)),
            PathEl::LineTo(to) => format!("L{}", place(to)),
            PathEl::QuadTo(by, to) => format!("Q{} {}", place(by), place(to)),
            PathEl::CurveTo(a, b, to) => format!("C{} {} {}", place(a), place(b), place(to)),
            PathEl::ClosePath => "Z".to_owned(),
        };
        if !text.is_empty() {
            text.push(' ');
        }
        text += &words;
    }
    text
}

/// Rounds a number and removes trailing zeros: `1.5` for 1.500, `0` for -0.0.
fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// Escapes text for use between tags or quotes. Characters that XML cannot represent become question marks.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\t' | '\n' | '\r' => safe.push(' '),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => safe.push('?'),
            _ => safe.push(character),
        }
    }
    safe
}
