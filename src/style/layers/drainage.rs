//! Streams and ridge lines. Their pass is `src/lines/drainage.rs`, and `src/drainage` finds them.

use super::{Channels, Fading, Ink, LayerBehaviour, Trace};
use crate::style::Color;
use crate::style::parameters::{Range, choices, parameters};

parameters! {
    /// Streams or ridge lines: lines along which the land drains, wider where a larger area drains through them.
    pub struct Drainage {
        /// Which lines are drawn.
        of called "Kind of lines": DrainageLines = DrainageLines::Streams;
        /// Views in which the lines are drawn.
        views called "Drawn in": DrainageViews = DrainageViews::Maps;
        /// Colour of the lines.
        ink called "Ink colour": Color = Color::default();
        /// Side of the square on the picture that must drain through a line; smaller values draw more lines, down to 40
        /// samples of the land.
        spacing_px called "Line spacing": f32 = 40.0 => Range::Within(4.0, 1024.0);
        /// Width of a line where it begins.
        line_px called "Line width": f32 = 0.6 => Range::Within(0.1, 8.0);
        /// Width of a line through which 256 times as much land drains as where it begins.
        widest_px called "Largest width": f32 = 1.6 => Range::Within(0.1, 16.0);
        /// Lines between gentler slopes, averaged over some samples beside them, are not drawn; 0 draws all lines.
        gentlest_deg called "Gentlest sides": f32 = 0.0 => Range::Within(0.0, 45.0);
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.2 => Range::Within(0.0, 1.0);
    }
}

choices! {
    /// Kind of lines of drainage.
    pub enum DrainageLines {
        /// Streams: where water of a large area flows together.
        Streams,
        /// Ridge lines: where land falls to both sides.
        Ridges,
    }
}

choices! {
    /// Views in which lines of drainage are drawn.
    pub enum DrainageViews {
        /// Only maps.
        Maps,
        /// All views.
        All,
    }
}

impl Drainage {
    /// Returns the kind of lines that are drawn; `None` in views without lines.
    pub(crate) fn drawn_lines(&self) -> Option<DrainageLines> {
        (self.views == DrainageViews::All).then_some(self.of)
    }
}

impl LayerBehaviour for Drainage {
    fn inks(&self) -> Vec<Ink> {
        let (id, label) = match self.of {
            DrainageLines::Streams => ("streams", "Streams"),
            DrainageLines::Ridges => ("ridges", "Ridge lines"),
        };
        let ink = Ink {
            id,
            label: label.to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: false },
            makes_tone: false,
            is_main: false,
            trace: Trace::Picture,
        };
        if self.views == DrainageViews::All { vec![ink] } else { Vec::new() }
    }

    fn prepare_for_map(&mut self, _pixel_m: f64) {
        self.views = DrainageViews::All;
    }

    fn summary(&self) -> Option<String> {
        let lines = match self.of {
            DrainageLines::Streams => "streams",
            DrainageLines::Ridges => "ridge lines",
        };
        Some(format!("{lines}{}", if self.views == DrainageViews::All { "" } else { " (on maps)" }))
    }
}
