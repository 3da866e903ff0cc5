//! Numbers on the contour lines of a map: where they are, their letters, and the gaps of the lines for them.
//!
//! The GPU draws contour lines pixel by pixel and has no list of them. So the same form of the land is computed here
//! ([`form`]), its contour lines are traced ([`trace`]), and [`crate::labels::numbers`] places the numbers on those. The
//! GPU then leaves out the ink in the boxes of the numbers ([`LineGap`]).
//!
//! Why: `docs/decisions/contour-numbers.md`.

mod form;
mod trace;

use std::sync::Arc;

use glam::DVec2;

use self::form::Form;
use self::trace::{Cell, Traced};
use super::legend::drawn_area;
use super::names::{HALO, halo};
use super::title::{Block, pen_px};
use crate::drainage::Land;
use crate::file::svg::Text;
use crate::frame::LineGap;
use crate::labels::numbers::{Contour, Number, Page, Rules, metres, place};
use crate::lettering;
use crate::lettering::ink::PenStroke;
use crate::pyramid::PyramidError;
use crate::scene::map::Map;
use crate::style::layers::LINES_PER_INDEX;
use crate::style::{Color, HeightLines, HeightsOf, Layer, Style, Typeface};
use crate::world::Surfaces;

/// Lines whose distance is smaller than this many times their width, but at least pixels, fade out, and so do lines whose
/// distance is larger than `FARTHEST_PX`: the middles of the transitions in `shaders/layers/height_lines.wgsl`.
const NEAREST: f64 = 3.0;
const FARTHEST_PX: f64 = 600.0;
/// The steepest land with lines, as a fraction of the tangent at which they have faded out.
const GENTLE: f64 = 0.9;
/// Height of a gap above and below the digits, in heights of digits.
const ABOVE: f64 = 0.2;
/// Distance of a level from whole tenths of a metre, in tenths, beyond which its number would be wrong.
const ROUNDED: f64 = 1e-3;

/// The map whose contour lines have numbers.
pub(crate) struct Inputs<'a> {
    pub map: &'a Map,
    pub surfaces: &'a Surfaces,
    /// The style as it is drawn on the map ([`Style::for_map`]).
    pub style: &'a Style,
    /// Boxes that numbers must not touch: lower and upper corners, in pixels.
    pub obstacles_px: &'a [[DVec2; 2]],
    /// Pixels per pixel of the style.
    pub px: f64,
}

/// The numbers on the contour lines of a map.
#[derive(Clone, Debug)]
pub(crate) struct Numbers {
    pub placed: Vec<Number>,
    /// Index into `layers` of each number.
    layer_of: Vec<usize>,
    layers: Vec<NumberedLayer>,
    /// Colour of the halo around the letters; `None` if the style has no marks that would hide them.
    halo: Option<Color>,
    typeface: Typeface,
    /// Pixels per pixel of the style.
    px: f64,
}

/// A layer whose lines have numbers.
#[derive(Clone, Copy, Debug)]
struct NumberedLayer {
    /// Whether its numbers are depths of the sea.
    is_depth: bool,
    ink: Color,
}

/// Returns the layers whose lines have numbers: the lowest with heights of the land, then the lowest with depths of the sea.
fn numbered(style: &Style) -> Vec<&HeightLines> {
    let lines = || {
        style.layers.iter().filter_map(|layer| match layer {
            Layer::HeightLines(lines) => (lines.number_px > 0.0 && lines.interval_m > 0.0).then_some(lines),
            _ => None,
        })
    };
    [HeightsOf::Land, HeightsOf::Sea].into_iter().filter_map(|of| lines().find(|lines| lines.of == of)).collect()
}

/// Returns whether a style draws shade as marks or lines, in which digits are hard to read.
fn has_marks(style: &Style) -> bool {
    style.layers.iter().any(|layer| match layer {
        Layer::Hatching(hatching) => hatching.share > 0.0,
        Layer::Rows(_) | Layer::Cuts(_) | Layer::ToneLines(_) => true,
        _ => false,
    })
}

/// A contour line, and what its number says.
struct Line {
    /// Index of its layer among those with numbers.
    layer: usize,
    traced: Traced,
    text: String,
}

/// Places the numbers of a map; `None` if its style has none. Those of all layers have the size of the first one.
///
/// # Errors
/// The first tile that cannot be read.
pub(crate) fn numbers(inputs: &Inputs<'_>) -> Result<Option<Numbers>, PyramidError> {
    let Inputs { map, surfaces, style, obstacles_px, px } = *inputs;
    let layers = numbered(style);
    let Some(first) = layers.first() else { return Ok(None) };
    let [columns, rows] = drawn_area(&style.paper, map.size_px);
    let corners_px = [0, 1].map(|i| DVec2::new(columns[i] as f64, rows[i] as f64));
    let terrain = &surfaces.terrain;
    let land = Land { store: Arc::clone(terrain.store()), projection: terrain.grid_projection().clone() };
    let mut forms = Vec::new();
    let mut all: Vec<Line> = Vec::new();
    for (index, lines) in layers.iter().enumerate() {
        let is_depth = lines.of == HeightsOf::Sea;
        let sea_level_m = surfaces.sea_level_m().filter(|_| is_depth || style.water().is_some());
        let mut form = Form::read(&land, map, corners_px, lines.form_px.into())?;
        let drawn_interval_m = f64::from(lines.interval_m) * surfaces.exaggeration();
        // Depths count from the surface of the sea, and heights above it have no lines there.
        let shore_m = match (is_depth, sea_level_m) {
            (true, Some(sea_level_m)) => {
                form.heights_m.iter_mut().for_each(|height_m| *height_m -= sea_level_m);
                0.0
            }
            (true, None) => continue,
            (false, sea_level_m) => sea_level_m.unwrap_or(f64::NEG_INFINITY),
        };
        let has_lines = |cell: &Cell| cell.heights_m.iter().all(|height_m| (*height_m > shore_m) != is_depth);
        let is_drawn = |cell: &Cell, level: i64| has_lines(cell) && is_inked(lines, map, drawn_interval_m, cell, level);
        let traced = trace::lines(&form, drawn_interval_m, is_drawn);
        all.extend(traced.into_iter().map(|traced| {
            // A depth of 0 is the shore.
            let is_shore = is_depth && traced.level == 0;
            let level_m = traced.level as f64 * f64::from(lines.interval_m);
            let text = if is_shore { String::new() } else { text(level_m, is_depth) };
            Line { layer: index, traced, text }
        }));
        forms.push(form);
    }
    let contours = all.iter().map(|Line { layer, traced, text }| Contour {
        points: &traced.points,
        is_closed: traced.is_closed,
        level_m: traced.level as f64 * f64::from(layers[*layer].interval_m),
        is_index: is_index(traced.level),
        is_depth: layers[*layer].of == HeightsOf::Sea,
        text,
    });
    let contours: Vec<Contour<'_>> = contours.collect();
    let letter_px = f64::from(first.number_px);
    let typeface = style.paper.typeface;
    let page = Page {
        corners_px,
        obstacles_px,
        letter_px,
        width_px: &|text| letter_px * lettering::Line::small(text, typeface).width(),
        uphill: &|at_px| forms.first().and_then(|form| form.gradient(at_px)),
    };
    let rules = Rules::default();
    let placed = place(&contours, &page, &Rules { spacing_px: px * rules.spacing_px, ..rules });
    let layer_of = placed.iter().map(|number| all[number.line].layer).collect();
    let layer = |lines: &&HeightLines| NumberedLayer { is_depth: lines.of == HeightsOf::Sea, ink: lines.ink };
    let layers = layers.iter().map(layer).collect();
    let halo = has_marks(style).then_some(style.paper.color);
    Ok(Some(Numbers { placed, layer_of, layers, halo, typeface, px }))
}

fn is_index(level: i64) -> bool {
    level.rem_euclid(LINES_PER_INDEX as i64) == 0
}

/// Returns the number of a level; empty if whole tenths of a metre cannot express it. Depths have no sign.
fn text(level_m: f64, is_depth: bool) -> String {
    let tenths = 10.0 * level_m;
    let tolerance = ROUNDED * tenths.abs().max(1.0);
    if (tenths - tenths.round()).abs() > tolerance.min(0.1) { String::new() } else { metres(level_m, is_depth) }
}

/// Returns whether the line of a level has ink in a cell.
fn is_inked(lines: &HeightLines, map: &Map, interval_m: f64, cell: &Cell, level: i64) -> bool {
    let is_shown = |every: f64, width_px: f32| {
        let gap_px = every * interval_m / cell.rise_m;
        gap_px > NEAREST * f64::from(width_px).max(1.0) && gap_px < FARTHEST_PX
    };
    let slope = cell.rise_m / map.pixel_m;
    let is_gentle = lines.steepest_deg >= 90.0 || slope < GENTLE * f64::from(lines.steepest_deg).to_radians().tan();
    let as_index = || is_index(level) && is_shown(LINES_PER_INDEX, lines.index_px);
    is_gentle && (is_shown(1.0, lines.line_px) || as_index())
}

impl Numbers {
    /// Returns the letters, a block in the ink of each layer, and whether they are those of depths.
    pub(crate) fn letters(&self) -> Vec<(bool, Block)> {
        let of_layer = |(index, layer): (usize, &NumberedLayer)| (layer.is_depth, self.letters_of(index));
        self.layers.iter().enumerate().map(of_layer).collect()
    }

    fn letters_of(&self, layer: usize) -> Block {
        let mut block = Block::empty(self.layers[layer].ink);
        for (number, _) in self.placed.iter().zip(&self.layer_of).filter(|(_, own)| **own == layer) {
            let height_px = number.size_px.y;
            let line = self.line(number);
            let (strokes, areas) = line.along(height_px, |from_px, advance_px| {
                let letter = number.letter(from_px, advance_px);
                (letter.left_px, letter.angle)
            });
            let width_px = pen_px(height_px, self.px);
            block.strokes.extend(strokes.into_iter().map(|points| PenStroke { points, width_px }));
            block.areas.extend(areas);
            // The words are straight, along the chord of the letters.
            let long_px = height_px * line.width();
            let [begin, end] = [0.0, long_px].map(|from_px| number.letter(from_px, 0.0).left_px);
            let along = kurbo::Vec2::new(end.x - begin.x, end.y - begin.y);
            let text = line.words(begin, height_px).map(|text| Text { along, ..text });
            block.texts.extend(text);
        }
        block
    }

    /// Returns the halo under the letters, in the colour of the paper, if the style has marks around them.
    pub(crate) fn halo(&self) -> Option<Block> {
        let around = |block: &Block| halo(&block.strokes, &block.areas, HALO * self.px);
        let strokes = self.letters().iter().flat_map(|(_, block)| around(block)).collect();
        self.halo.map(|paper| Block { strokes, ..Block::empty(paper) })
    }

    /// Returns all that is drawn over a picture: first the halo, if there is one, then the letters.
    pub(crate) fn blocks(&self) -> Vec<Block> {
        self.halo().into_iter().chain(self.letters().into_iter().map(|(_, block)| block)).collect()
    }

    /// Returns the boxes in which the lines are interrupted: one for a straight number, otherwise one for each letter.
    pub(crate) fn gaps(&self) -> Vec<LineGap> {
        self.placed.iter().flat_map(|number| self.gaps_of(number)).collect()
    }

    fn gaps_of(&self, number: &Number) -> Vec<LineGap> {
        let size_px = number.size_px;
        let beside_px = (0.5 * (number.gap_px[1] - number.gap_px[0] - size_px.x)).max(0.0);
        let gap = |[from_px, advance_px]: [f64; 2]| {
            let letter = number.letter(from_px, advance_px);
            let along = DVec2::from_angle(letter.angle);
            LineGap {
                centre_px: letter.left_px + 0.5 * advance_px * along - 0.5 * size_px.y * along.perp(),
                along,
                half_px: DVec2::new(0.5 * advance_px + beside_px, (0.5 + ABOVE) * size_px.y),
            }
        };
        if number.is_straight() {
            return vec![gap([0.0, size_px.x])];
        }
        self.line(number).advances().map(|letter| gap(letter.map(|length| size_px.y * length))).collect()
    }

    fn line(&self, number: &Number) -> lettering::Line {
        lettering::Line::small(&number.text, self.typeface)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_their_levels() {
        let height = |level_m| text(level_m, false);
        assert_eq!([height(1200.0), height(-40.0), height(2.5), height(0.1_f32.into())], ["1200", "−40", "2.5", "0.1"]);
        assert_eq!([height(0.25), height(12.34)], [""; 2]);
        // An interval in single precision.
        assert_eq!(height(73.0 * f64::from(0.1_f32)), "7.3");
        assert_eq!([-40.0, -2.5].map(|level_m| text(level_m, true)), ["40", "2.5"]);
    }
}
