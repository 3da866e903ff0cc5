//! Rims of holes of a style.

use super::parameters::{Range, parameters};
use super::{Color, Style};

parameters! {
    /// Dashed lines around holes in the heights: land that nobody measured, where such voids are not filled.
    pub struct Rims {
        /// Colour of the lines; without it that of strokes, marks or lines, or what letters have.
        ink: Option<Color>;
        /// Width of a line; 0 draws none.
        width_px: f32 = 0.8 => Range::Within(0.0, 8.0);
        /// Length of a dash, about.
        dash_px: f32 = 6.0 => Range::Within(1.0, 64.0);
        /// Length of the gap after it, about; 0 makes the lines whole.
        gap_px: f32 = 5.0 => Range::Within(0.0, 64.0);
        /// What is left of the lines in full haze.
        faintest: f32 = 0.3 => Range::Within(0.0, 1.0);
    }
}

impl Rims {
    /// Whether there are any.
    pub fn are_drawn(&self) -> bool {
        self.width_px > 0.0
    }
}

impl Style {
    /// Of the lines around holes.
    pub fn rim_ink(&self) -> Color {
        self.rims.ink.unwrap_or_else(|| self.lettering_ink())
    }
}
