//! PDF: the paths of a drawing on one page, in layers that viewers can switch off, as in an SVG of the same drawing.
//!
//! As in an SVG, letters are outlines with the same words as invisible text over them. Its font is Courier, one of those
//! that every reader has, since invisible text needs no glyphs; `ActualText` has the characters.
//!
//! A unit of the page is a point, 1/72 inch, from the lower left corner. A layer is an optional content group. The
//! imprint is a stream of its own, uncompressed, so that it is found without a PDF reader.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use kurbo::{Affine, PathEl, Point};
use pdf_writer::types::{LineCapStyle, LineJoinStyle, TextRenderingMode};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, TextStr};

use super::FileError;
use super::atomic::AtomicFile;
use super::input::open_regular;
use super::svg::{CAPITALS, Drawing, Layer, Text, Unit};

/// Points per millimetre, and per pixel at 96 dots per inch.
const POINTS_PER_MM: f64 = 72.0 / 25.4;
const POINTS_PER_PX: f64 = 72.0 / 96.0;
/// Longest side that readers of PDF 1.7 must support, in points: 200 inches.
const LONGEST_POINTS: f64 = 14_400.0;
/// Name of the key that marks the stream of the imprint.
const IMPRINT: &[u8] = b"HachureImprint";
/// The entry with this name in the dictionary of the stream.
const IMPRINT_TYPE: &[u8] = b"/Type /HachureImprint";
/// Bytes of a file that are searched for the imprint at once, and largest distance from its type to its stream.
const PIECE_BYTES: u64 = 1 << 20;
const DICTIONARY_BYTES: u64 = 256;
/// Largest file that is searched for an imprint.
const LARGEST_FILE_BYTES: u64 = 1 << 30;
/// Name of the font of the invisible text, and the width of each of its glyphs as a part of its size.
const FONT: Name<'static> = Name(b"F");
const GLYPH_WIDTH: f64 = 0.6;
/// Steps of opacity: a graphics state for each.
const OPACITY_STEPS: f64 = 1000.0;

/// Writes a drawing as a page, completely or not at all, with an imprint that says how it was made.
///
/// # Errors
/// Fails if the page is larger than 200 inches, a number is not finite, the folder does not exist or is not writable,
/// or the disk is full.
pub(crate) fn write_pdf(path: &Path, drawing: &Drawing, imprint: Option<&str>) -> Result<(), FileError> {
    let strokes = drawing.layers.iter().flat_map(|layer| &layer.strokes);
    let mut strokes = strokes.map(|own| own.path.is_finite() && own.width.is_finite() && own.opacity.is_finite());
    let mut fills = drawing.layers.iter().flat_map(|layer| &layer.fills);
    if !strokes.all(|is_finite| is_finite)
        || !fills.all(kurbo::BezPath::is_finite)
        || !drawing.size.into_iter().all(f64::is_finite)
    {
        return Err(FileError::write(path, "a stroke has a number that is not finite"));
    }
    let points_per_unit = match drawing.unit {
        Unit::Mm => POINTS_PER_MM,
        Unit::Px => POINTS_PER_PX,
    };
    let size = drawing.size.map(|side| side * points_per_unit);
    if size.into_iter().any(|side| side > LONGEST_POINTS) {
        let cause = format!(
            "a page of {:.0} x {:.0} mm is larger than the 5080 mm that a PDF may have; use a smaller --paper or --size",
            size[0] / POINTS_PER_MM,
            size[1] / POINTS_PER_MM
        );
        return Err(FileError::write(path, cause));
    }
    let failed = |error| FileError::write(path, error);
    let bytes = Page { drawing, size, points_per_unit }.document(imprint).map_err(failed)?;
    let mut file = AtomicFile::create(path).map_err(failed)?;
    file.writer().write_all(&bytes).map_err(failed)?;
    file.commit().map_err(failed)
}

struct Page<'a> {
    drawing: &'a Drawing,
    /// Width and height in points.
    size: [f64; 2],
    points_per_unit: f64,
}

impl Page<'_> {
    fn document(&self, imprint: Option<&str>) -> std::io::Result<Vec<u8>> {
        let mut next = Ref::new(1);
        let [catalog, pages, page, contents, info, font] = std::array::from_fn(|_| next.bump());
        let groups: Vec<Ref> = self.drawing.layers.iter().map(|_| next.bump()).collect();
        let (content, opacities) = self.content();
        let packed = deflated(&content)?;
        let mut pdf = Pdf::new();
        {
            let mut root = pdf.catalog(catalog);
            root.pages(pages);
            let mut properties = root.insert(Name(b"OCProperties")).dict();
            properties.insert(Name(b"OCGs")).array().items(groups.iter().copied());
            let mut shown = properties.insert(Name(b"D")).dict();
            shown.insert(Name(b"Order")).array().items(groups.iter().copied());
            shown.insert(Name(b"ON")).array().items(groups.iter().copied());
        }
        pdf.pages(pages).kids([page]).count(1);
        {
            let mut own = pdf.page(page);
            own.parent(pages).contents(contents);
            own.media_box(Rect::new(0.0, 0.0, self.size[0] as f32, self.size[1] as f32));
            let mut resources = own.resources();
            let mut states = resources.ext_g_states();
            for step in opacities {
                let name = opacity_name(step);
                let mut state = states.insert(Name(name.as_bytes())).start::<ExtGraphicsState<'_>>();
                state.stroking_alpha((f64::from(step) / OPACITY_STEPS) as f32);
            }
            states.finish();
            resources.fonts().pair(FONT, font);
            let mut layers = resources.insert(Name(b"Properties")).dict();
            for (number, group) in groups.iter().enumerate() {
                layers.pair(Name(layer_name(number).as_bytes()), *group);
            }
        }
        for (layer, group) in self.drawing.layers.iter().zip(&groups) {
            let mut own = pdf.indirect(*group).dict();
            own.pair(Name(b"Type"), Name(b"OCG")).pair(Name(b"Name"), TextStr(&layer.label));
        }
        pdf.type1_font(font).base_font(Name(b"Courier")).encoding_predefined(Name(b"WinAnsiEncoding"));
        pdf.stream(contents, &packed).filter(pdf_writer::Filter::FlateDecode);
        pdf.document_info(info)
            .title(TextStr(&self.drawing.title))
            .subject(TextStr(&self.drawing.description))
            .creator(TextStr(concat!("hachure ", env!("CARGO_PKG_VERSION"))));
        if let Some(imprint) = imprint {
            pdf.stream(next.bump(), imprint.as_bytes()).pair(Name(b"Type"), Name(IMPRINT));
        }
        Ok(pdf.finish())
    }

    /// Returns the operators that draw the page, and the steps of opacity that they use.
    fn content(&self) -> (Vec<u8>, Vec<u16>) {
        let mut content = Content::new();
        let mut opacities = BTreeSet::new();
        content.set_line_cap(LineCapStyle::RoundCap).set_line_join(LineJoinStyle::RoundJoin);
        for (number, layer) in self.drawing.layers.iter().enumerate() {
            let name = layer_name(number);
            content.begin_marked_content_with_properties(Name(b"OC")).properties_named(Name(name.as_bytes()));
            self.layer(layer, &mut content, &mut opacities);
            content.end_marked_content();
        }
        (content.finish().to_vec(), opacities.into_iter().collect())
    }

    fn layer(&self, layer: &Layer, content: &mut Content, opacities: &mut BTreeSet<u16>) {
        // The page's y runs up.
        let place = Affine::new([self.points_per_unit, 0.0, 0.0, -self.points_per_unit, 0.0, self.size[1]]);
        let ink = layer.ink.as_ref().unwrap_or(&self.drawing.ink);
        let mut last = None;
        for stroke in &layer.strokes {
            let [red, green, blue] = srgb(stroke.ink.as_ref().unwrap_or(ink));
            let step = (stroke.opacity.clamp(0.0, 1.0) * OPACITY_STEPS).round() as u16;
            opacities.insert(step);
            let pen = (step, [red, green, blue]);
            if last.replace(pen) != Some(pen) {
                content.set_parameters(Name(opacity_name(step).as_bytes())).set_stroke_rgb(red, green, blue);
            }
            content.set_line_width((stroke.width * self.points_per_unit) as f32);
            draw(content, place * &stroke.path);
            content.stroke();
        }
        for fill in &layer.fills {
            let [red, green, blue] = srgb(ink);
            content.set_fill_rgb(red, green, blue);
            draw(content, place * fill);
            content.fill_nonzero();
        }
        for text in layer.texts.iter().filter(|text| text.is_drawn()) {
            invisible(content, &text.placed(place));
        }
    }
}

/// Adds words that a reader finds and copies, and does not show. `text` is in points.
fn invisible(content: &mut Content, text: &Text) {
    // A byte for each character: the encoding of the font is that of Latin-1 apart from 0x80 to 0x9f. All other characters
    // are known by `ActualText` alone.
    let is_encoded = |it: &char| matches!(it, ' '..='~' | '\u{a0}'..='\u{ff}');
    let byte = |it: char| Some(it).filter(is_encoded).and_then(|it| u8::try_from(u32::from(it)).ok()).unwrap_or(b' ');
    let shown: Vec<u8> = text.words.chars().map(byte).collect();
    let size = text.height / CAPITALS;
    let stretch = text.along.hypot() / (GLYPH_WIDTH * size * shown.len().max(1) as f64);
    let [x, y] = [text.along.x, text.along.y].map(|part| (part / text.along.hypot()) as f32);
    content.begin_marked_content_with_properties(Name(b"Span")).properties().actual_text(TextStr(&text.words));
    content.begin_text().set_font(FONT, size as f32).set_text_rendering_mode(TextRenderingMode::Invisible);
    content.set_horizontal_scaling((100.0 * stretch) as f32);
    content.set_text_matrix([x, y, -y, x, text.begin.x as f32, text.begin.y as f32]);
    content.show(pdf_writer::Str(&shown)).end_text().end_marked_content();
}

fn draw(content: &mut Content, path: kurbo::BezPath) {
    let at = |point: Point| (point.x as f32, point.y as f32);
    let mut last = Point::ZERO;
    for element in path.elements() {
        match *element {
            PathEl::MoveTo(to) => {
                content.move_to(at(to).0, at(to).1);
            }
            PathEl::LineTo(to) => {
                content.line_to(at(to).0, at(to).1);
            }
            PathEl::QuadTo(by, to) => {
                let cubic = kurbo::QuadBez::new(last, by, to).raise();
                let [a, b] = [at(cubic.p1), at(cubic.p2)];
                content.cubic_to(a.0, a.1, b.0, b.1, at(to).0, at(to).1);
            }
            PathEl::CurveTo(a, b, to) => {
                let [a, b] = [at(a), at(b)];
                content.cubic_to(a.0, a.1, b.0, b.1, at(to).0, at(to).1);
            }
            PathEl::ClosePath => {
                content.close_path();
            }
        }
        last = element.end_point().unwrap_or(last);
    }
}

fn layer_name(number: usize) -> String {
    format!("L{number}")
}

fn opacity_name(step: u16) -> String {
    format!("O{step}")
}

/// Returns the channels of a colour such as `#14120f`, 0 to 1; black for any other text.
fn srgb(ink: &str) -> [f32; 3] {
    let digits = ink.strip_prefix('#').and_then(|digits| u32::from_str_radix(digits, 16).ok()).unwrap_or_default();
    [16, 8, 0].map(|shift| f32::from((digits >> shift) as u8) / 255.0)
}

/// Compresses as the filter `FlateDecode` expects it.
fn deflated(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Reads the imprint of a PDF that hachure wrote and no other program has rewritten.
pub(super) fn imprint(path: &Path, largest_bytes: usize) -> Result<Option<String>, FileError> {
    let failed = |error: std::io::Error| FileError::read(path, error);
    let mut file = open_regular(path).map_err(failed)?;
    let Some(at) = last_imprint(&file).map_err(failed)? else { return Ok(None) };
    let begin = at.saturating_sub(DICTIONARY_BYTES);
    file.seek(SeekFrom::Start(begin)).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(2 * DICTIONARY_BYTES + largest_bytes as u64).read_to_end(&mut bytes).map_err(failed)?;
    let text = stream(&bytes, (at - begin) as usize).filter(|text| text.len() <= largest_bytes);
    let text = text.and_then(|text| std::str::from_utf8(text).ok());
    text.map(|text| Some(text.to_owned())).ok_or_else(|| FileError::read(path, "its imprint is damaged"))
}

/// Returns where the type of the imprint's stream is in a file. It is the last one: titles come before it.
fn last_imprint(file: &File) -> std::io::Result<Option<u64>> {
    let mut file = BufReader::new(file).take(LARGEST_FILE_BYTES);
    let (mut window, mut begin, mut found) = (Vec::new(), 0, None);
    loop {
        let read = (&mut file).take(PIECE_BYTES).read_to_end(&mut window)?;
        if let Some(at) = window.windows(IMPRINT_TYPE.len()).rposition(|own| own == IMPRINT_TYPE) {
            found = Some(begin + at as u64);
        }
        if read == 0 {
            return Ok(found);
        }
        // The name may continue in the next piece.
        let done = window.len().saturating_sub(IMPRINT_TYPE.len() - 1);
        window.drain(..done);
        begin += done as u64;
    }
}

/// Returns the content of the stream whose dictionary contains the position `at`.
fn stream(bytes: &[u8], at: usize) -> Option<&[u8]> {
    let position = |bytes: &[u8], wanted: &[u8]| bytes.windows(wanted.len()).position(|own| own == wanted);
    let dictionary = &bytes[bytes[..at].windows(2).rposition(|own| own == b"<<")?..];
    let word = &dictionary[position(dictionary, b"/Length ")? + b"/Length ".len()..];
    let digits = word.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let length: usize = std::str::from_utf8(&word[..digits]).ok()?.parse().ok()?;
    let rest = dictionary[position(dictionary, b"stream")?..].strip_prefix(b"stream".as_slice())?;
    let rest = rest.strip_prefix(b"\r\n".as_slice()).or_else(|| rest.strip_prefix(b"\n".as_slice()))?;
    let (text, end) = rest.split_at_checked(length)?;
    end.trim_ascii_start().starts_with(b"endstream").then_some(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use flate2::read::ZlibDecoder;
    use kurbo::BezPath;

    use super::*;
    use crate::file::svg::Stroke;

    fn drawing(unit: Unit) -> Drawing {
        let stroke = |path: &str, opacity: f64, ink: Option<&str>| Stroke {
            path: BezPath::from_svg(path).unwrap(),
            width: 0.5,
            opacity,
            ink: ink.map(str::to_owned),
        };
        let layer = |id: &str, label: &str, strokes: Vec<Stroke>| Layer {
            id: id.to_owned(),
            label: label.to_owned(),
            ink: None,
            kind: "contour",
            pen: None,
            strokes,
            fills: Vec::new(),
            texts: Vec::new(),
        };
        let layers = vec![
            layer("a", "Höhen", vec![stroke("M0,0 L10,0", 1.0, None), stroke("M0,0 C1,2 3,4 5,6", 0.5, None)]),
            layer("b", "Marks", vec![stroke("M25.4,25.4 Q0,0 25.4,0 Z", 1.0, Some("#ff0000"))]),
        ];
        let (title, description) = ("hachure: test".to_owned(), "two layers".to_owned());
        Drawing { title, description, size: [254.0, 127.0], unit, digits: 3, ink: "#000000".to_owned(), layers }
    }

    /// Returns the operators of the page.
    fn content(bytes: &[u8]) -> String {
        let position = |wanted: &[u8], from: usize| {
            from + bytes[from..].windows(wanted.len()).position(|own| own == wanted).unwrap()
        };
        let filter = position(b"FlateDecode", 0);
        let begin = position(b"stream\n", filter) + 7;
        let mut text = String::new();
        ZlibDecoder::new(&bytes[begin..]).read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn a_page_has_the_layers_and_paths_of_the_drawing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pdf");
        write_pdf(&path, &drawing(Unit::Mm), Some("style = \"ü\"\n")).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.starts_with("%PDF-1.7") && text.contains("/MediaBox [0 0 720 360]"), "{text}");
        assert_eq!(text.matches("/Type /OCG").count(), 2);
        let page = content(&bytes);
        let lines: Vec<&str> = page.lines().collect();
        // 10 mm are 28.3 points, and y runs up.
        assert!(lines.contains(&"0 360 m") && lines.contains(&"28.346457 360 l"), "{page}");
        assert!(!lines.contains(&"0 0 m"), "planted error, y downward");
        assert_eq!(lines.iter().filter(|line| **line == "S").count(), 3);
        assert_eq!(lines.iter().filter(|line| line.ends_with(" BDC")).count(), 2);
        assert!(lines.contains(&"1 0 0 RG") && lines.contains(&"/O500 gs") && lines.contains(&"h"), "{page}");
        // A quadratic curve is the same cubic one.
        let raised = kurbo::QuadBez::new((72.0, 288.0), (0.0, 360.0), (72.0, 360.0)).raise();
        let cubic = lines.iter().rev().find(|line| line.ends_with(" c")).unwrap();
        let numbers: Vec<f64> = cubic.split(' ').filter_map(|word| word.parse().ok()).collect();
        let wanted = [raised.p1.x, raised.p1.y, raised.p2.x, raised.p2.y, 72.0, 360.0];
        assert!(numbers.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3), "{cubic}");
        assert_eq!(imprint(&path, 1000).unwrap().as_deref(), Some("style = \"ü\"\n"));
        // Words are invisible, as wide as their letters, and have all characters.
        let mut named = drawing(Unit::Mm);
        let along = kurbo::Vec2::new(0.0, -30.0);
        named.layers[0].texts =
            vec![Text { words: "Höhe 12".to_owned(), begin: Point::new(25.4, 50.8), along, height: 7.0 }];
        let words = folder.path().join("words.pdf");
        write_pdf(&words, &named, None).unwrap();
        let page = content(&std::fs::read(&words).unwrap());
        let lines: Vec<&str> = page.lines().collect();
        assert!(lines.contains(&"3 Tr") && page.contains("/Span") && page.contains("/ActualText"), "{page}");
        assert!(lines.contains(&"<48F66865203132> Tj"), "{page}");
        let of = |end: &str| -> Vec<f64> {
            let line = lines.iter().find(|line| line.ends_with(end)).unwrap();
            line.split(' ').filter_map(|word| word.parse().ok()).collect()
        };
        let matrix = of(" Tm");
        assert!(matrix.iter().zip([0.0, 1.0, -1.0, 0.0, 72.0, 216.0]).all(|(a, b)| (a - b).abs() < 1e-3), "{matrix:?}");
        let long_mm = 7.0 * GLYPH_WIDTH * of(" Tf")[0] * of(" Tz")[0] / 100.0 / POINTS_PER_MM;
        assert!((long_mm - 30.0).abs() < 1e-3, "{long_mm}");
        assert!(!content(&bytes).contains("Tr"), "planted: no words");
        // Neither a title nor the imprint itself confuses the search.
        let confusing = Drawing { title: "/Type /HachureImprint".to_owned(), ..drawing(Unit::Mm) };
        let own = "a\nendstream\nb /Type /Hachure";
        let other = folder.path().join("b.pdf");
        write_pdf(&other, &confusing, Some(own)).unwrap();
        assert_eq!(imprint(&other, 1000).unwrap().as_deref(), Some(own));
        assert!(imprint(&path, 3).is_err());
        // A pixel is 1/96 inch.
        write_pdf(&path, &drawing(Unit::Px), None).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("/MediaBox [0 0 190.5 95.25]"));
        assert_eq!(imprint(&path, 1000).unwrap(), None);
        let large = Drawing { size: [6000.0, 10.0], ..drawing(Unit::Mm) };
        assert!(write_pdf(&path, &large, None).unwrap_err().to_string().contains("5080 mm"));
    }
}
