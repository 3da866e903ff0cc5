//! Sky of a style.

use super::Color;
use super::parameters::{Range, choices, parameters};

parameters! {
    /// The sky: a gradient, and what is drawn on it.
    pub struct Sky {
        /// Colour of the sky high up.
        zenith: Color = Color::WHITE;
        /// Colour of the sky low down.
        horizon: Color = Color::WHITE;
        /// Width of level rules; 0 is none.
        rules_px: f32 = 0.0 => Range::Within(0.0, 8.0);
        /// Distance of rules from each other.
        spacing_px: f32 = 5.0 => Range::Within(2.0, 64.0);
        /// How much thinner rules are at the horizon than high up; below 0 they are thinner high up.
        fade: f32 = 0.7 => Range::Within(-1.0, 1.0);
        /// Colour of rules and outlines.
        ink: Color = Color::default();
        /// Width of the line around clouds and the sun; 0 is none.
        outline_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// How many places of the sky that may have a cloud have one; 0 is none.
        clouds: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// What clouds look like.
        cloud_form: CloudForm = CloudForm::Cumulus;
        /// Colour of clouds.
        cloud: Color = Color::WHITE;
        /// How much of the sheet's height the graded band at its top takes; 0 is none.
        bokashi: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// The same of a band that stands on the horizon.
        horizon_bokashi: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Colour of both bands.
        bokashi_color: Color = Color::default();
        /// Radius of a disc where the light comes from, sun or moon; 0 is none.
        sun_deg: f32 = 0.0 => Range::Within(0.0, 45.0);
        /// Colour of that disc.
        sun: Color = Color::WHITE;
        /// How many places of the sky that may have a star have one; 0 is none.
        stars: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Diameter of the brightest stars; faint ones have half of it.
        star_px: f32 = 2.0 => Range::Within(0.5, 16.0);
        /// Colour of stars.
        star: Color = Color::WHITE;
    }
}

choices! {
    /// What clouds look like.
    pub enum CloudForm {
        /// Heaps on a level base.
        Cumulus,
        /// Long level bands.
        Streaks,
    }
}

impl Sky {
    /// Whether it has more than its gradient.
    pub fn is_drawn(&self) -> bool {
        [self.rules_px, self.clouds, self.bokashi, self.horizon_bokashi, self.sun_deg, self.stars]
            .into_iter()
            .any(|amount| amount > 0.0)
    }

    /// Whether it has lines: rules, or outlines of what it has.
    pub fn has_lines(&self) -> bool {
        self.rules_px > 0.0 || self.outline_px > 0.0 && (self.clouds > 0.0 || self.sun_deg > 0.0)
    }

    /// Whether it has colours other than its ink's.
    pub fn has_colors(&self) -> bool {
        let gradient = [self.zenith, self.horizon].iter().any(|color| *color != Color::WHITE);
        gradient || self.bokashi.max(self.horizon_bokashi) > 0.0
    }
}
