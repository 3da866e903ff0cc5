//! Rows of hachures. Their passes are in `src/surface/rows`.

use super::{Channels, Fading, Ink, LayerBehaviour, Trace};
use crate::style::Color;
use crate::style::parameters::{Range, parameters};

parameters! {
    /// Rows of hachures: each row fills the land between two heights, and each mark runs down the slope.
    pub struct Rows {
        /// Colour of the marks.
        ink called "Ink colour": Color = Color::default();
        /// Distance between the centre lines of neighbouring marks in a row.
        spacing_px called "Mark spacing": f32 = 6.0 => Range::Within(2.0, 64.0);
        /// Approximate length of a mark, as a multiple of `spacing_px`.
        length called "Mark length": f32 = 5.0 => Range::Within(3.0, 16.0);
        /// Distance between the ends of neighbouring marks of a row, as a fraction of the row; at 0 they are in one line.
        stagger called "Stagger of marks": f32 = 0.3 => Range::Within(0.0, 0.4);
        /// Gentler slopes have no marks.
        level_deg called "Gentlest slope": f32 = 2.0 => Range::Within(0.5, 45.0);
        /// Fraction of the land that the marks cover where the tone is darkest.
        darkest called "Cover in darkest tone": f32 = 0.8 => Range::Within(0.0, 0.9);
        /// Fraction of a mark's length over which it tapers at each end.
        taper called "Taper of marks": f32 = 0.3 => Range::Within(0.0, 0.5);
        /// Fraction of the ink that remains in full haze; how much thinner the marks become is set by
        /// `haze.faintest_tone`.
        faintest called "Ink in full haze": f32 = 1.0 => Range::Within(0.0, 1.0);
    }
}

impl LayerBehaviour for Rows {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "hachures",
            label: "Hachures".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: true },
            makes_tone: true,
            is_main: true,
            trace: Trace::Rows { spacing_px: self.spacing_px },
        }]
    }

    fn summary(&self) -> Option<String> {
        Some("rows of hachures".to_owned())
    }
}
