//! Letters of fonts: filled outlines. The typefaces of a style are in the program ([`Own`]); letters that they and the
//! table of the lettering lack are taken from the fonts of the machine.
//!
//! `fontdb` lists the machine's fonts, `harfrust` (a port of HarfBuzz) kerns letters and joins them as their script
//! requires, and `skrifa` reads the outlines. Fonts of the machine are only looked for if a text needs one.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use fontdb::{Database, FaceInfo, ID, Style};
use harfrust::{Direction, Feature, ShapeOptions, ShaperData, UnicodeBuffer};
use kurbo::{Affine, BezPath};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// Largest number of different characters of a text that are searched for in fonts. No title needs as many.
const MAX_SOUGHT: usize = 512;
/// Height of capitals in units of a font's em square, if the font does not say.
const USUAL_CAPITALS: f32 = 0.7;
/// Features of typefaces: lining figures, because old-style figures look like small letters next to coordinates.
const LINING: &str = "lnum";
/// Letters that are spaced out are not joined, and marks between capitals are raised.
const SPACED_OUT: [&str; 2] = ["-liga", "case"];

/// Width of a blank between the digits of a number.
const THIN: f64 = 0.3;

/// A typeface of the program, of the folder `fonts`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Own {
    Serif,
    Sans,
    Capitals,
}

impl Own {
    /// Returns the file.
    fn data(self) -> &'static [u8] {
        match self {
            Self::Serif => include_bytes!("../../fonts/serif.otf"),
            Self::Sans => include_bytes!("../../fonts/sans.ttf"),
            Self::Capitals => include_bytes!("../../fonts/capitals.ttf"),
        }
    }

    /// Returns which of some characters the typeface has. Thin blanks are made from the usual one.
    pub(super) fn known(self, characters: impl Iterator<Item = char>) -> BTreeSet<char> {
        let Ok(font) = FontRef::new(self.data()) else { return BTreeSet::new() };
        let map = font.charmap();
        characters.filter(|character| is_thin(*character) || map.map(*character).is_some()).collect()
    }

    /// Returns the letters of a text, from left to right, with `spacing` heights of capitals between them.
    pub(super) fn shaped(self, text: &str, is_leftward: bool, spacing: f64) -> Vec<Glyph> {
        let names = SPACED_OUT.iter().filter(|_| spacing > 0.0).chain([&LINING]);
        let features: Vec<Feature> = names.filter_map(|name| name.parse().ok()).collect();
        let mut glyphs = shaped(self.data(), 0, text, (is_leftward, &features)).unwrap_or_default();
        let blank = |glyph: &Glyph| text[glyph.begin..].starts_with(is_thin);
        glyphs.iter_mut().filter(|glyph| blank(glyph)).for_each(|glyph| glyph.advance = THIN);
        // A combining mark has no advance.
        glyphs.iter_mut().filter(|glyph| glyph.advance > 0.0).for_each(|glyph| glyph.advance += spacing);
        glyphs
    }
}

/// Returns whether a character is a blank that is narrower than usual, as between the digits of a number.
pub(super) fn is_thin(character: char) -> bool {
    matches!(character, '\u{2009}' | '\u{202f}')
}

/// The fonts of a machine, the most suitable ones first.
pub(crate) struct Fonts {
    database: Database,
    order: Vec<ID>,
}

/// A letter of a font, in heights of capitals, from the left end of its baseline; y goes up.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Glyph {
    /// Distance to the start of the next letter.
    pub advance: f64,
    /// Closed outlines. Inside is where they wind around a point.
    pub outlines: BezPath,
    /// Byte offset of its characters in the shaped text.
    pub begin: usize,
}

static SYSTEM: LazyLock<Fonts> = LazyLock::new(|| {
    let mut database = Database::new();
    database.load_system_fonts();
    Fonts::of(database)
});

/// Orders fonts: upright before slanted, not monospaced, of nearly regular weight, sans serif first, and by name, so that
/// the choice does not depend on the order of files.
fn rank(face: &FaceInfo) -> (bool, bool, u16, bool, String) {
    let name = face.families.first().map(|(name, _)| name.clone()).unwrap_or_default();
    let is_sans = name.contains("Sans") || name.contains("Gothic");
    (face.style != Style::Normal, face.monospaced, face.weight.0.abs_diff(400), !is_sans, name)
}

impl Fonts {
    /// Returns the fonts of the system, which are listed once.
    pub(crate) fn system() -> &'static Self {
        &SYSTEM
    }

    pub(super) fn of(database: Database) -> Self {
        let mut faces: Vec<_> = database.faces().map(|face| (rank(face), face.id)).collect();
        faces.sort_by(|a, b| a.0.cmp(&b.0));
        Self { order: faces.into_iter().map(|(_, id)| id).collect(), database }
    }

    /// Returns a font for each character that some font has. A font that has most of them comes first, so that words
    /// are not composed from several fonts.
    pub(super) fn faces(&self, characters: &BTreeSet<char>) -> BTreeMap<char, ID> {
        let mut missing: BTreeSet<char> = characters.iter().copied().take(MAX_SOUGHT).collect();
        let known = |id: &ID| {
            let of = |data: &[u8], index: u32| {
                let font = FontRef::from_index(data, index).ok()?;
                let map = font.charmap();
                Some(missing.iter().copied().filter(|character| map.map(*character).is_some()).collect())
            };
            let known: BTreeSet<char> = self.database.with_face_data(*id, of).flatten().unwrap_or_default();
            (!known.is_empty()).then_some((*id, known))
        };
        let mut fonts: Vec<(ID, BTreeSet<char>)> = self.order.iter().filter_map(known).collect();
        let mut found = BTreeMap::new();
        while !missing.is_empty() {
            fonts.iter_mut().for_each(|(_, known)| known.retain(|character| missing.contains(character)));
            // The first of those with the most.
            let Some((id, known)) = fonts.iter().rev().max_by_key(|(_, known)| known.len()) else { break };
            if known.is_empty() {
                break;
            }
            found.extend(known.iter().map(|character| (*character, *id)));
            missing = missing.difference(known).copied().collect();
        }
        found
    }

    /// Returns the letters of a text in a font, from left to right.
    pub(super) fn shaped(&self, id: ID, text: &str, is_leftward: bool) -> Vec<Glyph> {
        let of = |data: &[u8], index: u32| shaped(data, index, text, (is_leftward, &[]));
        self.database.with_face_data(id, of).flatten().unwrap_or_default()
    }
}

/// Returns the letters of a text in a font of a file, from left to right; `None` if the font is damaged.
fn shaped(data: &[u8], index: u32, text: &str, (is_leftward, features): (bool, &[Feature])) -> Option<Vec<Glyph>> {
    let font = FontRef::from_index(data, index).ok()?;
    let shapes = ShaperData::new(&font);
    let mut buffer = UnicodeBuffer::new();
    buffer.push_str(text);
    buffer.set_direction(if is_leftward { Direction::RightToLeft } else { Direction::LeftToRight });
    buffer.guess_segment_properties();
    let shaped = shapes.shaper(&font).build().shape(buffer, ShapeOptions::new().features(features));
    let metrics = font.metrics(Size::unscaled(), LocationRef::default());
    let em = f32::from(metrics.units_per_em.max(1));
    let capitals = metrics.cap_height.filter(|height| *height > 0.2 * em && *height < 1.5 * em);
    let scale = 1.0 / f64::from(capitals.unwrap_or(USUAL_CAPITALS * em));
    let outlines = font.outline_glyphs();
    let places = shaped.glyph_infos().iter().zip(shaped.glyph_positions());
    let glyph = places.map(|(info, place)| {
        let mut path = Path(BezPath::new());
        if let Some(outline) = outlines.get(GlyphId::new(info.glyph_id)) {
            let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
            // A letter whose outline is damaged is a gap.
            let _ = outline.draw(settings, &mut path);
        }
        let offset = (f64::from(place.x_offset) * scale, f64::from(place.y_offset) * scale);
        Glyph {
            advance: f64::from(place.x_advance) * scale,
            outlines: Affine::translate(offset) * Affine::scale(scale) * path.0,
            begin: info.cluster as usize,
        }
    });
    Some(glyph.collect())
}

/// A path that is drawn by a font.
struct Path(BezPath);

impl OutlinePen for Path {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to((f64::from(x), f64::from(y)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to((f64::from(x), f64::from(y)));
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.0.quad_to((f64::from(cx), f64::from(cy)), (f64::from(x), f64::from(y)));
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        let [a, b, to] = [[ax, ay], [bx, by], [x, y]].map(|[x, y]| (f64::from(x), f64::from(y)));
        self.0.curve_to(a, b, to);
    }

    fn close(&mut self) {
        self.0.close_path();
    }
}
