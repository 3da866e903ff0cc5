//! The `[water]` section of a style: lakes and the sea.

use super::Color;
use super::parameters::{Range, parameters};

parameters! {
    /// Lakes and the sea: a tint, a line along the shore, and water lines or ruled lines.
    pub struct Water {
        /// Colour of water, multiplied by the paper colour.
        tint: Color = Color::WHITE;
        /// Colour of the shoreline and of water lines.
        ink: Color = Color::default();
        /// Width of the shoreline.
        shore_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Number of water lines, which run parallel to the shore.
        lines: u32 = 0 => Range::Within(0.0, 8.0);
        /// Width of water lines and of ruled lines.
        line_px: f32 = 0.7 => Range::Within(0.1, 8.0);
        /// Distance of the first water line from the shore, or between ruled lines.
        spacing_px: f32 = 4.0 => Range::Within(2.0, 32.0);
        /// Factor by which each gap between water lines is wider than the one before.
        growth: f32 = 1.35 => Range::Within(1.0, 2.0);
        /// Factor of the ink of each water line relative to the one before.
        paler: f32 = 0.75 => Range::Within(0.0, 1.0);
        /// Whether water has horizontal ruled lines instead of water lines.
        rules: bool = false;
        /// Strength of reflections in water: horizontal strokes where it has lines or ruled lines, colour elsewhere.
        mirror: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Fraction of the ink that remains in full haze.
        faintest: f32 = 0.3 => Range::Within(0.0, 1.0);
    }
}

/// Largest distance from the shore, in pixels, at which lines are drawn.
const FARTHEST_PX: f32 = 96.0;
/// Number of gaps from the shore over which ruled lines become lighter.
const RULES_FADE: f32 = 6.0;

impl Water {
    /// Returns how far from the shore the lines reach, in pixels; the water map must reach at least as far.
    pub fn reach_px(&self) -> f32 {
        let lines = if self.rules { 0 } else { self.lines };
        let of_lines: f32 = (0..lines).map(|line| self.spacing_px * self.growth.powi(line as i32)).sum();
        let of_rules = if self.rules { RULES_FADE * self.spacing_px } else { 0.0 };
        (of_lines.max(of_rules) + self.line_px.max(self.shore_px) + 2.0).min(FARTHEST_PX)
    }
}
