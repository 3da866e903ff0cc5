//! Styles for paper: pixel lengths in a style are meant for a screen of 96 dots per inch, and a print has more.
//!
//! Lengths are the parameters with the unit `px`. They are multiplied by a factor and clamped to their ranges, as their
//! definitions give them. Hatching marks are scaled by the size of their
//! layer, so that the same tonal art maps serve screens and prints. Pixel lengths inside shaders are not scaled: the
//! width of lines that are detected in images of the surface, the grain of the paper, and the noises of watercolour and
//! of hand-drawn wobble (`docs/limits.md`).

use super::parameters::{Range, Setting};
use super::{Style, texture};

/// Dots per inch for which pixel lengths in styles are meant, as in CSS.
pub(crate) const REFERENCE_DPI: f64 = 96.0;

impl Style {
    /// Returns the style with all pixel lengths multiplied by `factor` and clamped to their ranges.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut style = self.clone();
        if factor == 1.0 {
            return style;
        }
        let factor = factor as f32;
        style.scale_lengths(factor, None, &Range::Any);
        style
    }

    /// Returns a phrase that lists the parts of this style that [`Style::scaled`] cannot scale; `None` if it scales
    /// everything.
    pub(crate) fn unscaled(&self) -> Option<String> {
        let of_layers = self.layers.iter().filter_map(|layer| Some((layer.behaviour().unscaled()?, true)));
        let of_style = [
            ("the grain of the paper", self.paper.grain > 0.0),
            ("the grain of watercolour", self.watercolor.as_ref().is_some_and(|water| water.granulation > 0.0)),
        ];
        let parts: Vec<&str> =
            of_layers.chain(of_style).filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect();
        let (last, others) = parts.split_last()?;
        Some(if others.is_empty() { (*last).to_owned() } else { format!("{} and {last}", others.join(", ")) })
    }
}

impl texture::Recipe {
    /// Returns the recipe for strokes that are `factor` times as wide. Sides of the tile stay powers of two, and the
    /// tile has room for at least as many marks.
    pub(super) fn scaled(&self, factor: f32) -> Self {
        let mut recipe = self.clone();
        recipe.scale_lengths(factor, None, &Range::Any);
        let grown = |side: u32, most: u32| ((side as f32 * factor).ceil() as u32).next_power_of_two().clamp(side, most);
        recipe.tile.along_px = grown(recipe.tile.along_px, 2048);
        recipe.tile.across_px = grown(recipe.tile.across_px, 512);
        recipe
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::style::parameters::{Parameter, find, parameters_of};

    #[test]
    fn lengths_of_every_preset_stay_within_their_ranges() {
        for name in crate::style::names() {
            let style = Style::load(name).unwrap();
            assert_eq!(style.scaled(1.0), style);
            for factor in [0.25, 2.0, 300.0 / 96.0, 100.0] {
                let scaled = style.scaled(factor);
                Style::parse("scaled.toml", &scaled.text()).unwrap();
                let texture = scaled.strokes().and_then(|strokes| strokes.texture.as_ref());
                texture.into_iter().for_each(|recipe| {
                    texture::Recipe::parse("scaled.toml", &crate::style::parameters::text(recipe)).unwrap();
                });
            }
        }
        // Lengths within their range are scaled exactly.
        let [pen, print] = [1.0, 3.125].map(|factor| Style::load("wash").unwrap().scaled(factor));
        let widths = [&pen, &print].map(|style| style.strokes().unwrap().width_px);
        assert_eq!(widths[1], 3.125 * widths[0]);
        assert_ne!(print.watercolor, pen.watercolor);
    }

    #[test]
    fn every_length_is_scaled_as_its_definition_says() {
        let style = Style::load("crosshatch").unwrap();
        let number = |style: &Style, key: &str| {
            let text: toml_edit::DocumentMut = style.text().parse().unwrap();
            find(text.as_item(), key).and_then(|item| item.as_float())
        };
        let wrong = |scaled: &Style| -> Vec<String> {
            let text: toml_edit::DocumentMut = style.text().parse().unwrap();
            let parameters = parameters_of(&Style::kind(), Some(text.as_item()));
            let lengths = parameters.into_iter().filter(|parameter| parameter.definition.unit == Some("px"));
            let is_wrong = |parameter: &Parameter| {
                let [low, high] = parameter.definition.range.ends().map(|end| f64::from(end.unwrap()));
                let before = number(&style, &parameter.key)?;
                let after = number(scaled, &parameter.key)?;
                Some((after - (2.0 * before).clamp(low, high)).abs() > 1e-4 * after)
            };
            lengths.filter(|parameter| is_wrong(parameter) == Some(true)).map(|parameter| parameter.key).collect()
        };
        let scaled = style.scaled(2.0);
        assert_eq!(wrong(&scaled), [""; 0]);
        // Planted errors: a length that stays, as `light.crests_px` once did, and one in a list.
        let mut planted = scaled.clone();
        planted.light.crests_px = style.light.crests_px;
        assert_eq!(wrong(&planted), ["light.crests_px"]);
        // The largest total length of strokes is not a length on the picture.
        assert_eq!(Style::load("pen").unwrap().scaled(2.0).strokes().unwrap().budget_px, 400_000.0);
    }

    #[test]
    fn what_stays_in_pixels_is_reported() {
        let reported = |name: &str| Style::load(name).unwrap().unscaled();
        assert!(reported("lsa").unwrap().starts_with("detected lines"), "{:?}", reported("lsa"));
        let mut bare = Style::load("strokes").unwrap();
        bare.paper.grain = 0.0;
        assert_eq!(bare.unscaled(), None);
    }
}
