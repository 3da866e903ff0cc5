//! The `[rims]` section of a style: lines around no-data areas.

use super::parameters::{Range, parameters};
use super::{Color, Style};

parameters! {
    /// Dashed lines around no-data areas of the DEM that are not filled.
    pub struct Rims {
        /// Colour of the lines; the default is the ink of the lettering, taken from strokes, marks or lines.
        ink: Option<Color>;
        /// Width of a line; 0 draws none.
        width_px: f32 = 0.8 => Range::Within(0.0, 8.0);
        /// Approximate length of a dash.
        dash_px: f32 = 6.0 => Range::Within(1.0, 64.0);
        /// Approximate length of the gap between dashes; 0 draws solid lines.
        gap_px: f32 = 5.0 => Range::Within(0.0, 64.0);
        /// Fraction of the ink that remains in full haze.
        faintest: f32 = 0.3 => Range::Within(0.0, 1.0);
    }
}

impl Rims {
    /// Returns whether the lines have a width.
    pub fn are_drawn(&self) -> bool {
        self.width_px > 0.0
    }
}

impl Style {
    /// Returns the colour of the lines around no-data areas.
    pub fn rim_ink(&self) -> Color {
        self.rims.ink.unwrap_or_else(|| self.lettering_ink())
    }
}
