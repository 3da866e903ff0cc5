//! Water of a style.

use super::Color;
use super::parameters::{Range, parameters};

parameters! {
    /// Lakes and the sea: a tint, a line along the shore, and water lines or rules.
    pub struct Water {
        /// Colour of water, which the paper multiplies.
        tint: Color = Color::WHITE;
        /// Colour of the shore and of water lines.
        ink: Color = Color::default();
        /// Width of the line along the shore.
        shore_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Number of water lines, which run along the shore.
        lines: u32 = 0 => Range::Within(0.0, 8.0);
        /// Width of water lines and of rules.
        line_px: f32 = 0.7 => Range::Within(0.1, 8.0);
        /// Distance of the first water line from the shore; of rules from each other.
        spacing_px: f32 = 4.0 => Range::Within(2.0, 32.0);
        /// How many times wider each gap between water lines is than the one before.
        growth: f32 = 1.35 => Range::Within(1.0, 2.0);
        /// What each water line has of the ink of the one before.
        paler: f32 = 0.75 => Range::Within(0.0, 1.0);
        /// Whether water has level rules in place of water lines.
        rules: bool = false;
        /// How much water takes the tone of what it mirrors: as level strokes where it has lines or rules, else as colour.
        mirror: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// What is left of shores and water lines in full haze.
        faintest: f32 = 0.3 => Range::Within(0.0, 1.0);
    }
}

/// Farther from the shore than this no line is looked for.
const FARTHEST_PX: f32 = 96.0;
/// Rules are darkest at the shore, over so many gaps.
const RULES_FADE: f32 = 6.0;

impl Water {
    /// How far from the shore its lines reach; as far tints need at least.
    pub fn reach_px(&self) -> f32 {
        let lines = if self.rules { 0 } else { self.lines };
        let of_lines: f32 = (0..lines).map(|line| self.spacing_px * self.growth.powi(line as i32)).sum();
        let of_rules = if self.rules { RULES_FADE * self.spacing_px } else { 0.0 };
        (of_lines.max(of_rules) + self.line_px.max(self.shore_px) + 2.0).min(FARTHEST_PX)
    }
}
