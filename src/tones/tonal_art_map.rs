//! Tonal art maps: tiles of marks for every tone, generated from a recipe.
//!
//! Praun and others (*Real-time hatching*, 2001) draw a column of pictures from light to dark in which every mark of a
//! lighter tone is in all darker ones, and each mark is at the place that makes the tone most even. Nested pictures can
//! be stored as one picture of *thresholds* (Webb and others, *Fine tone control in hardware hatching*, 2002): a texel
//! is ink where the darkness is above its threshold. So one byte holds all tones, nothing is blended, and every
//! intermediate tone exists.
//!
//! What we changed: thresholds are a function of *ink*, the total area of all marks, so a mark may begin at some ink
//! and widen with more of it (`growth`); a recipe sets how much of either. Then thresholds are replaced by their rank
//! over the tile and in every neighbourhood (`equalise`), so that the mean tone is exact, and correct within small
//! windows too, whatever the marks are. There are no mip levels for distance: hatching is scaled in steps of its own,
//! so that marks keep their width.
//!
//! A map is bit-identical on every machine: only sums, products, quotients and roots are used, in one order.
//!
//! Why: `docs/decisions/tonal-art-maps.md`.

mod cache;
mod chance;
mod equalise;
mod evenness;
mod growth;
mod halftone;
mod ink_map;
mod rows;
mod stack;
mod strokes;
mod whole;

pub(crate) use cache::read_or_make;

use self::equalise::Windows;
use self::growth::Growth;
use self::ink_map::InkMap;
use self::rows::Family;
use crate::lines::strokes::texture::field::Field;
use crate::style::StyleError;
use crate::style::marks::{Kind, Recipe};

/// Cached maps of another version are regenerated. Raise the version whenever a change here changes a bit of any map.
const GENERATOR_VERSION: u32 = 4;

/// Subfolder of the cache folder.
const FOLDER: &str = "marks";

/// The ink at which lines begin to be crossed; from there on they only widen.
const CROSSED_AT: f32 = 0.38;

/// Thresholds of a tile that repeats in both directions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TonalArtMap {
    /// Side of the tile, which is a square, in texels.
    pub side_px: u32,
    /// Rows from top to bottom; x is along the marks. A texel is ink where the darkness, 0 to 1, is above (threshold +
    /// 0.5) / 256.
    pub thresholds: Vec<u8>,
}

impl TonalArtMap {
    /// Generates a recipe's map, or reads its pictures.
    ///
    /// # Errors
    /// [`StyleError::Image`].
    pub(crate) fn make(recipe: &Recipe) -> Result<Self, StyleError> {
        let side = recipe.side_px as usize;
        let ink = match recipe.kind {
            Kind::Stack => return stack::read(recipe),
            Kind::Halftone => halftone::ink(recipe),
            Kind::Line | Kind::Cross => lines(recipe),
            Kind::Dash | Kind::Stipple | Kind::Dots | Kind::Scribble | Kind::Dab => {
                let mut map = InkMap::new(side);
                strokes::draw(recipe, &mut map);
                map.close_up();
                map.ink
            }
        };
        let windows = windows(recipe.kind);
        let mut even = equalise::everywhere(&ink, side, windows);
        if recipe.grain > 0.0 {
            even = equalise::everywhere(&grained(&even, recipe), side, windows);
        }
        if recipe.kind == Kind::Line && recipe.grain == 0.0 {
            even = equalise::everywhere(&whole::smooth(even, side), side, windows);
            even = equalise::ranks(&whole::without_fragments(even, side));
        }
        Ok(Self::of_ranks(recipe.side_px, &even))
    }

    /// Returns the map of a recipe from hachure's cache folder, or generates and caches it.
    ///
    /// # Errors
    /// The errors of [`TonalArtMap::make`]. If the cache folder cannot be read or written, the map is generated without
    /// it.
    pub(crate) fn cached(recipe: &Recipe) -> Result<Self, StyleError> {
        match crate::pyramid::store::cache_folder(None) {
            Ok(folder) => read_or_make(recipe, &folder.join(FOLDER)),
            Err(_) => Self::make(recipe),
        }
    }

    /// Returns whether a texel is ink at `darkness`, 0 to 1.
    #[cfg(test)]
    pub(crate) fn is_ink(&self, place: usize, darkness: f32) -> bool {
        darkness > (f32::from(self.thresholds[place]) + 0.5) / 256.0
    }

    /// Creates a map from ranks of 0 to 1.
    fn of_ranks(side_px: u32, ranks: &[f32]) -> Self {
        Self { side_px, thresholds: ranks.iter().map(|rank| (rank * 256.0).min(255.0) as u8).collect() }
    }
}

/// Returns the windows in which tones are equalised: long for marks that are long.
fn windows(kind: Kind) -> Windows {
    let (narrow_px, wide_px) = match kind {
        Kind::Line => ([16.0, 6.0], [22.0, 12.0]),
        Kind::Dash => ([14.0, 8.0], [20.0, 13.0]),
        Kind::Cross => ([13.0, 13.0], [18.0, 18.0]),
        _ => ([9.0, 9.0], [16.0, 16.0]),
    };
    Windows { narrow_px, wide_px }
}

/// Returns the ink of lines through the tile, and of those that cross them.
fn lines(recipe: &Recipe) -> Vec<f32> {
    let side_px = recipe.side_px as f32;
    let mut map = InkMap::new(recipe.side_px as usize);
    let growth = |period_px: f32| {
        Growth::new(recipe.mid_darkness(), period_px / recipe.spacing_px, recipe.width_px, recipe.swell)
    };
    if recipe.kind == Kind::Line {
        let family = Family { direction: [1, 0], most: usize::MAX, after: 0.0, stream: 1 };
        rows::draw(recipe, &growth(side_px), &family, &mut map);
        map.close_up();
        return map.ink;
    }
    // Crossing lines rise by one in two: an acute angle makes diamonds, a right angle the bars of a window.
    for (direction, after, stream) in [([1, 0], 0.0, 1), ([1, 2], CROSSED_AT, 2)] {
        let norm = ((direction[0] * direction[0] + direction[1] * direction[1]) as f32).sqrt();
        let growth = growth(side_px / norm);
        // Only the lines that exist when crossing begins.
        let most = (0..growth.count()).take_while(|before| growth.begin(*before) < CROSSED_AT).count();
        rows::draw(recipe, &growth, &Family { direction, most, after, stream }, &mut map);
    }
    map.close_up();
    map.ink
}

/// Returns thresholds with the paper's tooth: ink stays on its peaks.
fn grained(thresholds: &[f32], recipe: &Recipe) -> Vec<f32> {
    let side = recipe.side_px as usize;
    let noise = |mark_px: f32, stream: u32| Field::noise([side, side], [mark_px; 2], recipe.seed, stream);
    let mut tooth = noise(1.3, 90);
    tooth.add(&noise(2.6, 91), 0.6);
    let tooth = equalise::ranks(tooth.values());
    thresholds.iter().zip(tooth).map(|(threshold, tooth)| threshold + recipe.grain * (tooth - 0.5)).collect()
}
