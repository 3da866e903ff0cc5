//! Lakes and the sea. Their passes are `src/surface/water.rs` and `src/tones/water.rs`.

use super::{Channels, Fading, Ink, LayerBehaviour, Margins, Trace};
use crate::gpu::wgsl::tones::water::MIRROR_REACH_PX;
use crate::style::Color;
use crate::style::parameters::{Range, parameters};

parameters! {
    /// Lakes and the sea: a tint, a line along the shore, and water lines or ruled lines.
    pub struct Water {
        /// Colour of water, multiplied by the paper colour.
        tint called "Water colour": Color = Color::WHITE;
        /// Colour of deep water, multiplied by the water colour.
        deep called "Deep water colour": Color = Color::WHITE;
        /// Distance from the shore at which water has its deep colour; 0 draws one colour everywhere.
        deep_px called "Shallow water width": f32 = 0.0 => Range::Within(0.0, 90.0), zero "none";
        /// Colour of the shoreline and of water lines.
        ink called "Ink colour": Color = Color::default();
        /// Width of the shoreline.
        shore_px called "Shoreline width": f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Number of water lines, which run parallel to the shore.
        lines called "Number of lines": u32 = 0 => Range::Within(0.0, 8.0);
        /// Width of water lines and of ruled lines.
        line_px called "Line width": f32 = 0.7 => Range::Within(0.1, 8.0);
        /// Distance of the first water line from the shore, or between ruled lines.
        spacing_px called "Line spacing": f32 = 4.0 => Range::Within(2.0, 32.0);
        /// Factor by which each gap between water lines is wider than the one before.
        growth called "Growth of gaps": f32 = 1.35 => Range::Within(1.0, 2.0);
        /// Factor of the ink of each water line relative to the one before.
        paler called "Ink ratio per line": f32 = 0.75 => Range::Within(0.0, 1.0);
        /// Whether water has horizontal ruled lines instead of water lines.
        rules called "Ruled lines": bool = false;
        /// Strength of reflections in water: horizontal strokes where it has lines or ruled lines, colour elsewhere.
        mirror called "Reflections": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.3 => Range::Within(0.0, 1.0);
    }
}

/// Largest distance from the shore, in pixels, at which lines are drawn.
const FARTHEST_PX: f32 = 96.0;
/// Number of gaps from the shore over which ruled lines become lighter.
const RULES_FADE: f32 = 6.0;

impl LayerBehaviour for Water {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "water",
            label: "Shores and water lines".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: false },
            makes_tone: false,
            is_main: false,
            trace: Trace::Picture,
        }]
    }

    fn margins(&self) -> Margins {
        let added_px = if self.mirror > 0.0 { MIRROR_REACH_PX as u32 } else { 0 };
        Margins { added_px, ..Margins::default() }
    }

    fn missing_in_vectors(&self) -> Option<&'static str> {
        (self.tint != Color::WHITE).then_some("water tint")
    }

    fn summary(&self) -> Option<String> {
        Some("water".to_owned())
    }
}

impl Water {
    /// Returns whether the ink is only that of shorelines.
    pub(crate) fn has_only_shores(&self) -> bool {
        self.lines == 0 && !self.rules && self.mirror == 0.0
    }

    /// Returns the largest distance of a line from the shore, in pixels. Distances to the shore are needed up to there.
    pub(crate) fn reach_px(&self) -> f32 {
        let lines = if self.rules { 0 } else { self.lines };
        let of_lines: f32 = (0..lines).map(|line| self.spacing_px * self.growth.powi(line as i32)).sum();
        let of_rules = if self.rules { RULES_FADE * self.spacing_px } else { 0.0 };
        (of_lines.max(of_rules).max(self.deep_px) + self.line_px.max(self.shore_px) + 2.0).min(FARTHEST_PX)
    }
}
