//! Styles for paper: pixel lengths in a style are meant for a screen of 96 dots per inch, and a print has more.
//!
//! Lengths are multiplied by a factor and clamped to their ranges. Hatching marks are scaled by the size of their
//! layer, so that the same tonal art maps serve screens and prints. Pixel lengths inside shaders are not scaled: the
//! width of lines that are detected in images of the surface, the grain of the paper, and the noises of watercolour and
//! of hand-drawn wobble (`docs/limits.md`).

use super::{Style, texture};

/// Dots per inch for which pixel lengths in styles are meant, as in CSS.
pub const REFERENCE_DPI: f64 = 96.0;

impl Style {
    /// Returns the style with all pixel lengths multiplied by `factor` and clamped to their ranges.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut style = self.clone();
        if factor == 1.0 {
            return style;
        }
        let factor = factor as f32;
        let scale = |length: &mut f32, least: f32, most: f32| *length = (*length * factor).clamp(least, most);
        if let Some(lines) = &mut style.lines {
            scale(&mut lines.crowd_px, 8.0, 512.0);
        }
        scale(&mut style.curvature.width_px, 0.5, 32.0);
        scale(&mut style.curvature.feature_px, 1.0, 256.0);
        scale(&mut style.curvature.warp_px, 0.0, 16.0);
        scale(&mut style.curvature.warp_length_px, 4.0, 1000.0);
        if let Some(relief) = &mut style.relief {
            scale(&mut relief.alpha_px, -1000.0, 1000.0);
            scale(&mut relief.scale_px, 0.0, 12.0);
            scale(&mut relief.finest_px, 1.0, 64.0);
        }
        if let Some(lines) = &mut style.tone_lines {
            scale(&mut lines.width_px, 1.0, 16.0);
            scale(&mut lines.shortest_px, 0.0, 256.0);
        }
        if let Some(strokes) = &mut style.strokes {
            scale(&mut strokes.width_px, 0.5, 64.0);
            scale(&mut strokes.taper_px, 0.0, 1000.0);
            scale(&mut strokes.wobble_px, 0.0, 16.0);
            scale(&mut strokes.shortest_px, 0.0, 1000.0);
            scale(&mut strokes.join_px, 1.0, 16.0);
            scale(&mut strokes.merge_px, 0.0, 8.0);
            scale(&mut strokes.crowd_px, 8.0, 512.0);
            for feature_px in [&mut strokes.suggestive_px, &mut strokes.ridge_px].into_iter().flatten() {
                scale(feature_px, 1.0, 256.0);
            }
            if let Some(texture) = &mut strokes.texture {
                *texture = texture.scaled(factor);
            }
        }
        if let Some(hatching) = &mut style.hatching {
            scale(&mut hatching.form_px, 1.0, 256.0);
            for layer in &mut hatching.layers {
                scale(&mut layer.size, 0.25, 8.0);
            }
        }
        if let Some(rows) = &mut style.rows {
            scale(&mut rows.spacing_px, 2.0, 64.0);
        }
        if let Some(cuts) = &mut style.cuts {
            scale(&mut cuts.form_px, 1.0, 256.0);
            for layer in &mut cuts.layers {
                scale(&mut layer.spacing_px, 2.0, 64.0);
            }
        }
        if let Some(water) = &mut style.water {
            scale(&mut water.shore_px, 0.0, 16.0);
            scale(&mut water.line_px, 0.1, 8.0);
            scale(&mut water.spacing_px, 2.0, 32.0);
        }
        scale(&mut style.rims.width_px, 0.0, 8.0);
        scale(&mut style.rims.dash_px, 1.0, 64.0);
        scale(&mut style.rims.gap_px, 0.0, 64.0);
        if let Some(lines) = &mut style.height_lines {
            scale(&mut lines.line_px, 0.1, 8.0);
            scale(&mut lines.index_px, 0.1, 8.0);
            scale(&mut lines.form_px, 1.0, 256.0);
        }
        if let Some(watercolor) = &mut style.watercolor {
            scale(&mut watercolor.edge_px, 1.0, 16.0);
            scale(&mut watercolor.warp_px, 0.0, 32.0);
        }
        let sky = &mut style.sky;
        scale(&mut sky.rules_px, 0.0, 8.0);
        scale(&mut sky.spacing_px, 2.0, 64.0);
        scale(&mut sky.outline_px, 0.0, 16.0);
        scale(&mut sky.star_px, 0.5, 16.0);
        scale(&mut style.light.form_px, 0.0, 256.0);
        scale(&mut style.paper.margin_px, 0.0, 1000.0);
        scale(&mut style.paper.border_px, 0.0, 64.0);
        scale(&mut style.paper.foot_px, 0.0, 4000.0);
        style
    }

    /// Returns a phrase that lists what [`Style::scaled`] cannot scale in this style; `None` if it scales everything.
    pub fn unscaled(&self) -> Option<String> {
        let parts = [
            ("detected lines", self.lines.is_some()),
            ("the grain of the paper", self.paper.grain > 0.0),
            ("the grain of watercolour", self.watercolor.as_ref().is_some_and(|water| water.granulation > 0.0)),
        ];
        let parts: Vec<&str> = parts.iter().filter(|(_, is_there)| *is_there).map(|(name, _)| *name).collect();
        let (last, others) = parts.split_last()?;
        Some(if others.is_empty() { (*last).to_owned() } else { format!("{} and {last}", others.join(", ")) })
    }
}

impl texture::Recipe {
    /// Returns the recipe for strokes that are `factor` times as wide. Sides of the tile stay powers of two, and the
    /// tile has room for at least as many marks.
    fn scaled(&self, factor: f32) -> Self {
        let mut recipe = self.clone();
        let scale = |length: &mut f32, least: f32, most: f32| *length = (*length * factor).clamp(least, most);
        let grown = |side: u32, most: u32| ((side as f32 * factor).ceil() as u32).next_power_of_two().clamp(side, most);
        recipe.tile.along_px = grown(recipe.tile.along_px, 2048);
        recipe.tile.across_px = grown(recipe.tile.across_px, 512);
        scale(&mut recipe.touch.nominal_width_px, 1.0, 64.0);
        scale(&mut recipe.touch.border_px, 0.0, 32.0);
        scale(&mut recipe.pigment.along_px, 1.0, 256.0);
        scale(&mut recipe.pigment.across_px, 1.0, 64.0);
        for marks in &mut recipe.marks {
            scale(&mut marks.along_px, 1.0, 256.0);
            scale(&mut marks.across_px, 1.0, 64.0);
            scale(&mut marks.wander_px, 0.0, 16.0);
        }
        recipe
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn lengths_of_every_preset_stay_within_their_ranges() {
        for name in crate::style::names() {
            let style = Style::load(name).unwrap();
            assert_eq!(style.scaled(1.0), style);
            for factor in [0.25, 2.0, 300.0 / 96.0, 100.0] {
                let scaled = style.scaled(factor);
                Style::parse("scaled.toml", &scaled.text()).unwrap();
                let texture = scaled.strokes.as_ref().and_then(|strokes| strokes.texture.as_ref());
                texture.into_iter().for_each(|recipe| {
                    texture::Recipe::parse("scaled.toml", &crate::style::parameters::text(recipe)).unwrap();
                });
            }
        }
        // Lengths within their range are scaled exactly.
        let [pen, print] = [1.0, 3.125].map(|factor| Style::load("wash").unwrap().scaled(factor));
        let widths = [&pen, &print].map(|style| style.strokes.as_ref().unwrap().width_px);
        assert_eq!(widths[1], 3.125 * widths[0]);
        assert_ne!(print.watercolor, pen.watercolor);
    }

    #[test]
    fn what_stays_in_pixels_is_told() {
        let told = |name: &str| Style::load(name).unwrap().unscaled();
        assert!(told("ink").unwrap().starts_with("detected lines"), "{:?}", told("ink"));
        let mut bare = Style::load("strokes").unwrap();
        bare.paper.grain = 0.0;
        assert_eq!(bare.unscaled(), None);
    }
}
