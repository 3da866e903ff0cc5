//! Rows of hachures of a style.

use super::Color;
use super::parameters::{Range, parameters};

parameters! {
    /// Rows of hachures between heights of the land, each mark down the slope.
    pub struct Rows {
        /// Colour of the marks.
        ink: Color = Color::default();
        /// Distance of marks beside each other, from middle to middle.
        spacing_px: f32 = 6.0 => Range::Within(2.0, 64.0);
        /// About how many times longer than that marks are.
        length: f32 = 5.0 => Range::Within(3.0, 16.0);
        /// Land whose form slopes less has no marks.
        level_deg: f32 = 2.0 => Range::Within(0.5, 45.0);
        /// The part of the land that marks cover where the tone is darkest.
        darkest: f32 = 0.8 => Range::Within(0.0, 0.9);
        /// Part of a mark's length over which it thins out, at each end.
        taper: f32 = 0.3 => Range::Within(0.0, 0.5);
        /// What is left of the ink of marks in full haze; that they are thinner is `haze.faintest_tone`.
        faintest: f32 = 1.0 => Range::Within(0.0, 1.0);
    }
}
