//! Letters that the table of the lettering lacks, from the fonts of the machine: filled outlines.
//!
//! `fontdb` lists the fonts, `harfrust` (a port of HarfBuzz) joins letters as their script requires, and `skrifa` reads
//! the outlines. Fonts are only looked for if a text needs one.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use fontdb::{Database, FaceInfo, ID, Style};
use glam::DVec2;
use harfrust::{Direction, ShapeOptions, ShaperData, UnicodeBuffer};
use kurbo::{BezPath, PathEl};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// Largest number of different characters of a text that are searched for in fonts. No title needs as many.
const MAX_SOUGHT: usize = 512;
/// Height of capitals in units of a font's em square, if the font does not say.
const USUAL_CAPITALS: f32 = 0.7;
/// Largest distance of a polygon from the curve of an outline, in heights of capitals.
const TOLERANCE: f64 = 0.005;

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
    pub outlines: Vec<Vec<DVec2>>,
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
        let of = |data: &[u8], index: u32| {
            let font = FontRef::from_index(data, index).ok()?;
            let shapes = ShaperData::new(&font);
            let mut buffer = UnicodeBuffer::new();
            buffer.push_str(text);
            buffer.set_direction(if is_leftward { Direction::RightToLeft } else { Direction::LeftToRight });
            buffer.guess_segment_properties();
            let shaped = shapes.shaper(&font).build().shape(buffer, ShapeOptions::new());
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
                let offset = DVec2::new(place.x_offset.into(), place.y_offset.into()) * scale;
                Glyph {
                    advance: f64::from(place.x_advance) * scale,
                    outlines: polygons(&path.0, scale, offset),
                    begin: info.cluster as usize,
                }
            });
            Some(glyph.collect())
        };
        self.database.with_face_data(id, of).flatten().unwrap_or_default()
    }
}

/// Flattens the outlines of a letter.
fn polygons(path: &BezPath, scale: f64, offset: DVec2) -> Vec<Vec<DVec2>> {
    let mut polygons: Vec<Vec<DVec2>> = Vec::new();
    kurbo::flatten(path, TOLERANCE / scale, |element| match element {
        PathEl::MoveTo(at) => polygons.push(vec![DVec2::new(at.x, at.y) * scale + offset]),
        PathEl::LineTo(at) => {
            polygons.last_mut().into_iter().for_each(|polygon| polygon.push(DVec2::new(at.x, at.y) * scale + offset));
        }
        _ => {}
    });
    polygons.retain(|polygon| polygon.len() > 2);
    polygons
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
