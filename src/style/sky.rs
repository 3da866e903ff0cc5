//! The `[sky]` section of a style.

use super::Color;
use super::layers::{Channels, Fading, Ink, Trace};
use super::parameters::{Range, choices, parameters};

parameters! {
    /// The sky: a gradient with rules, clouds, a sun or moon and stars.
    pub struct Sky {
        /// Colour at the top of the gradient.
        zenith called "Zenith colour": Color = Color::WHITE;
        /// Colour at the horizon.
        horizon called "Horizon colour": Color = Color::WHITE;
        /// Width of the horizontal ruled lines; 0 draws none.
        rules_px called "Ruled line width": f32 = 0.0 => Range::Within(0.0, 8.0), zero "none";
        /// Distance between ruled lines.
        spacing_px called "Ruled line spacing": f32 = 5.0 => Range::Within(2.0, 64.0);
        /// How much thinner ruled lines are at the horizon than at the top; negative values make them thinner at the
        /// top.
        fade called "Ruled line fade": f32 = 0.7 => Range::Within(-1.0, 1.0);
        /// Colour of ruled lines and outlines.
        ink called "Ink colour": Color = Color::default();
        /// Width of the outline of clouds and the sun; 0 draws none.
        outline_px called "Outline width": f32 = 0.0 => Range::Within(0.0, 16.0), zero "none";
        /// Density of clouds: the fraction of possible positions that have one.
        clouds called "Cloud density": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Shape of clouds.
        cloud_form called "Cloud shape": CloudForm = CloudForm::Cumulus;
        /// Fill colour of clouds.
        cloud called "Cloud colour": Color = Color::WHITE;
        /// Colour of the shaded base of clouds, multiplied by their fill colour.
        cloud_shade called "Cloud shade colour": Color = Color::WHITE;
        /// Width of ruled lines that shade the base of clouds, at the distance of the sky's ruled lines; 0 draws none.
        cloud_rules_px called "Cloud ruled line width": f32 = 0.0 => Range::Within(0.0, 8.0), zero "none";
        /// Height of the graded band at the top of the picture, as a fraction of its height; 0 draws none.
        bokashi called "Top band height": f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
        /// Height of a graded band on the horizon, as a fraction of the picture's height; 0 draws none.
        horizon_bokashi called "Horizon band height": f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
        /// Colour of both graded bands.
        bokashi_color called "Band colour": Color = Color::default();
        /// Angular radius of the disc of the sun or moon; 0 draws none.
        sun_deg called "Sun radius": f32 = 0.0 => Range::Within(0.0, 45.0), zero "none";
        /// Whether each picture has the disc, on the side that light comes from, instead of where the light is.
        sun_in_view called "Sun in the picture": bool = false;
        /// Width of the glow around the disc, over which it loses half of its light; 0 draws none.
        sun_glow_deg called "Sun glow": f32 = 0.0 => Range::Within(0.0, 45.0), zero "none";
        /// Colour of the disc of the sun or moon.
        sun called "Sun colour": Color = Color::WHITE;
        /// Density of stars: the fraction of possible positions that have one.
        stars called "Star density": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Diameter of the brightest stars; the faintest have half of it.
        star_px called "Star diameter": f32 = 2.0 => Range::Within(0.5, 16.0);
        /// Colour of stars.
        star called "Star colour": Color = Color::WHITE;
    }
}

choices! {
    /// Shape of clouds.
    pub enum CloudForm {
        /// Heaps on a flat base.
        Cumulus,
        /// Long horizontal bands.
        Streaks,
    }
}

impl Sky {
    /// Returns whether the sky has more than its gradient.
    pub(crate) fn is_drawn(&self) -> bool {
        [self.rules_px, self.clouds, self.bokashi, self.horizon_bokashi, self.sun_deg, self.stars]
            .into_iter()
            .any(|amount| amount > 0.0)
    }

    /// Returns whether the sky has lines: ruled lines, or outlines of clouds or the sun.
    pub(crate) fn has_lines(&self) -> bool {
        let has_cloud_lines = self.clouds > 0.0 && self.outline_px.max(self.cloud_rules_px) > 0.0;
        self.rules_px > 0.0 || has_cloud_lines || self.outline_px > 0.0 && self.sun_deg > 0.0
    }

    /// Returns the ink of the lines of the sky, if it has any.
    pub(super) fn lines(&self) -> Option<Ink> {
        self.has_lines().then(|| Ink {
            id: "sky",
            label: "Sky".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(3),
            fading: Fading::AlreadyFaded,
            makes_tone: false,
            is_main: false,
            trace: Trace::Picture,
        })
    }

    /// Returns whether the sky has a coloured sun or coloured clouds that no outline surrounds. White ones are gaps in
    /// its ruled lines, or invisible.
    pub(crate) fn has_unlined_fills(&self) -> bool {
        let clouds = [self.cloud, self.cloud_shade].map(|color| (self.clouds, color));
        let mut fills = clouds.into_iter().chain([(self.sun_deg, self.sun)]);
        self.outline_px == 0.0 && fills.any(|(amount, color)| amount > 0.0 && color != Color::WHITE)
    }

    /// Returns whether the sky has a coloured gradient or a graded band.
    pub(crate) fn has_colors(&self) -> bool {
        let gradient = [self.zenith, self.horizon].iter().any(|color| *color != Color::WHITE);
        gradient || self.bokashi.max(self.horizon_bokashi) > 0.0
    }
}
