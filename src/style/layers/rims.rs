//! Rims: dashed outlines of no-data areas. Their pass is `src/surface/rims.rs`.

use super::{Channels, Fading, Ink, LayerBehaviour, Trace};
use crate::style::Color;
use crate::style::parameters::{Range, parameters};

parameters! {
    /// Dashed outlines of no-data areas of the DEM that are not filled.
    pub struct Rims {
        /// Colour of the lines; the default is that of the topmost ink with enough contrast to the paper.
        ink called "Ink colour": Option<Color>;
        /// Width of a line; 0 draws none.
        width_px called "Line width": f32 = 0.8 => Range::Within(0.0, 8.0), zero "none";
        /// Approximate length of a dash.
        dash_px called "Dash length": f32 = 6.0 => Range::Within(1.0, 64.0);
        /// Approximate length of the gap between dashes; 0 draws solid lines.
        gap_px called "Gap length": f32 = 5.0 => Range::Within(0.0, 64.0), zero "none";
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.3 => Range::Within(0.0, 1.0);
    }
}

impl LayerBehaviour for Rims {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "rims",
            label: "Outlines of no-data areas".to_owned(),
            color: self.ink,
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: false },
            makes_tone: false,
            is_main: false,
            trace: Trace::Picture,
        }]
    }
}
