//! Small pictures of hatching marks and stroke textures, by which a recipe is chosen.

use std::path::Path;

use crate::lines::strokes::texture::{Brush, grow};
use crate::style::{StyleError, marks, texture};
use crate::tones::tonal_art_map::TonalArtMap;

/// Darkness of marks at the left and at the right of a swatch.
const TONES: [f32; 2] = [0.04, 0.96];
/// Pressure of a stroke at the left and at the right of a swatch.
const PRESSURES: [f32; 2] = [1.0, 0.1];
/// Change of darkness over which the border of a mark becomes ink.
const BORDER: f32 = 0.06;
/// Least distance of a stroke from the border of its swatch in pixels.
const MARGIN_PX: f32 = 3.0;

/// The kind of a recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum RecipeKind {
    /// Hatching marks, from light to dark.
    Marks,
    /// The texture of a stroke, from heavy to light pressure.
    Stroke,
}

impl RecipeKind {
    /// Returns the kind of the recipes that a parameter names, by the last part of its key.
    pub(crate) fn of_key(key: &str) -> Option<Self> {
        match key {
            "marks" => Some(Self::Marks),
            "texture" => Some(Self::Stroke),
            _ => None,
        }
    }

    /// Returns the names of the built-in recipes of this kind.
    pub(crate) fn names(self) -> Vec<&'static str> {
        match self {
            Self::Marks => marks::names(),
            Self::Stroke => texture::names(),
        }
    }

    /// Draws a recipe: rows of ink from top to bottom, 0 for none to 255. `name` is built in, or a file relative to
    /// `folder`.
    ///
    /// # Errors
    /// The recipe or one of its pictures cannot be read.
    pub(crate) fn draw(self, name: &str, folder: &Path, [width, height]: [usize; 2]) -> Result<Vec<u8>, StyleError> {
        let byte = |ink: f32| (255.0 * ink.clamp(0.0, 1.0)).round() as u8;
        let along = |[from, to]: [f32; 2], x: usize| from + (to - from) * (x as f32 + 0.5) / width as f32;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        match self {
            Self::Marks => {
                let map = TonalArtMap::cached(&marks::Recipe::load(name, folder)?)?;
                let side = map.side_px as usize;
                let ink = |(x, y): (usize, usize)| {
                    let threshold = f32::from(map.thresholds[y % side * side + x % side]) / 255.0;
                    byte((along(TONES, x) - threshold) / BORDER + 0.5)
                };
                Ok(places.map(ink).collect())
            }
            Self::Stroke => {
                let recipe = texture::Recipe::load(name, folder)?;
                let brush = Brush::of(&recipe);
                let levels = grow(&recipe);
                let Some(tile) = levels.first() else { return Ok(vec![0; width * height]) };
                let [tile_width, tile_height] = tile.size_px.map(|side| side as usize);
                let middle = 0.5 * height as f32;
                let half_width_px = brush.nominal_half_width_px.clamp(1.0, (middle - MARGIN_PX).max(1.0));
                let ink = |(x, y): (usize, usize)| {
                    let across_px = y as f32 + 0.5 - middle;
                    let [u, v] = brush.uv(x as f32, across_px, half_width_px, 0);
                    let place = |part: f32, side: usize| (part.rem_euclid(1.0) * side as f32) as usize % side;
                    let texel = tile.texels[place(v, tile_height) * tile_width + place(u, tile_width)];
                    let texel = texel.map(|byte| f32::from(byte) / 255.0);
                    let covered = (half_width_px + 0.5 - across_px.abs()).clamp(0.0, 1.0);
                    byte(covered * brush.ink(texel, along(PRESSURES, x), across_px.abs(), half_width_px))
                };
                Ok(places.map(ink).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::tests::common::full;

    const SIZE: [usize; 2] = [160, 28];

    fn mean(swatch: &[u8], columns: std::ops::Range<usize>) -> f64 {
        let ink = swatch.chunks(SIZE[0]).flat_map(|row| &row[columns.clone()]).map(|ink| f64::from(*ink));
        ink.sum::<f64>() / (255.0 * (SIZE[1] * columns.len()) as f64)
    }

    #[test]
    fn every_recipe_has_a_swatch_of_its_own_with_its_tones() {
        for kind in [RecipeKind::Marks, RecipeKind::Stroke] {
            // Marks take seconds to make; other tests of the fast tier need these two as well.
            let is_drawn = |name: &&str| full() || kind == RecipeKind::Stroke || ["line", "hachure"].contains(name);
            let names = kind.names().into_iter().filter(is_drawn);
            let swatches: Vec<(&str, Vec<u8>)> =
                names.map(|name| (name, kind.draw(name, Path::new(""), SIZE).unwrap())).collect();
            for (name, swatch) in &swatches {
                assert_eq!(swatch.len(), SIZE[0] * SIZE[1]);
                let [left, right] = [mean(swatch, 0..40), mean(swatch, 120..160)];
                match kind {
                    RecipeKind::Marks => assert!(right > left + 0.4, "{name}: {left} {right}"),
                    RecipeKind::Stroke => assert!(left > right && left > 0.05, "{name}: {left} {right}"),
                }
                let same = swatches.iter().filter(|(_, other)| other == swatch).count();
                assert_eq!(same, 1, "{name}: another recipe looks the same");
            }
        }
        assert!(RecipeKind::Marks.draw("no such marks", Path::new(""), SIZE).is_err());
    }
}
