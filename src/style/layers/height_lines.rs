//! Contour lines of height (elevation contours). See `shaders/layers/height_lines.wgsl`.
//!
//! Why: `docs/decisions/maps.md`.

use super::{Channels, Fading, Ink, InkPass, LandOfPass, LayerBehaviour, Trace};
use crate::gpu::target::{Group, TargetKind};
use crate::gpu::wgsl::layers::height_lines::HeightLineRules;
use crate::style::Color;
use crate::style::parameters::{Range, choices, parameters};

/// Ink of contour lines of height, 0 to 1.
pub(crate) const HEIGHT_INK: TargetKind = TargetKind::storage(
    "height ink",
    wgpu::TextureFormat::R32Float,
    Group::Ink.shows("Ink of contour lines of height"),
);

/// The shader of contour lines, the only one that reads the gaps of numbers.
pub(crate) const HEIGHT_LINES: &str = "layers/height_lines";

/// The height of a sea that floods nothing.
const NO_SEA_M: f64 = -1e6;

/// Every fifth contour line is an index contour, which is wider.
pub(crate) const LINES_PER_INDEX: f64 = 5.0;

parameters! {
    /// Contour lines of height; every fifth line is an index contour.
    pub struct HeightLines {
        /// Heights of the land, or depths of the sea; `sea` draws nothing unless the scene or `--sea-level` names a sea.
        of called "Land or sea": HeightsOf = HeightsOf::Land;
        /// Colour of the lines.
        ink called "Ink colour": Color = Color::default();
        /// Contour interval in metres; 0 chooses a round number for the scale of a map, and draws no lines in other
        /// views.
        interval_m called "Contour interval": f32 = 0.0 => Range::Within(0.0, 10_000.0), zero "automatic";
        /// Width of a line.
        line_px called "Line width": f32 = 0.7 => Range::Within(0.1, 8.0);
        /// Width of every fifth line, the index contour.
        index_px called "Index line width": f32 = 1.3 => Range::Within(0.1, 8.0);
        /// Height of the digits of the numbers that interrupt contour lines on maps; 0 draws none.
        number_px called "Height of numbers": f32 = 0.0 => Range::Within(0.0, 40.0), zero "none";
        /// The land is smoothed to this size first, so that lines do not follow single samples.
        form_px called "Smoothing of land": f32 = 4.0 => Range::Within(1.0, 256.0);
        /// Steeper land has no lines; useful on maps with rock drawing.
        steepest_deg called "Steepest land": f32 = 90.0 => Range::Within(5.0, 90.0);
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.2 => Range::Within(0.0, 1.0);
    }
}

choices! {
    /// The surface whose heights the contour lines connect.
    pub enum HeightsOf {
        /// Heights of the land. Lakes and the sea have no lines.
        Land,
        /// Depths of the sea that the scene or `--sea-level` names, from its surface.
        Sea,
    }
}

/// Returns the smallest contour interval, in metres, of a map with pixels of `pixel_m` metres, before it is rounded. At
/// large scales, lines on a slope of 45° are about three pixels apart or more. Small scales have gentler slopes and use
/// the intervals of topographic maps from 1 : 50 000 to 1 : 1 000 000, on a screen of 96 dots per inch.
fn min_m(pixel_m: f64) -> f64 {
    (3.0 * pixel_m).min(8.4 * pixel_m.powf(0.6))
}

impl LayerBehaviour for HeightLines {
    fn inks(&self) -> Vec<Ink> {
        // Without an interval there are no lines; on a map, `prepare_for_map` chooses one.
        let (id, label) = match self.of {
            HeightsOf::Land => ("heights", "Contour lines of height"),
            HeightsOf::Sea => ("depths", "Depth contours"),
        };
        let ink = Ink {
            id,
            label: label.to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: false },
            makes_tone: false,
            is_main: true,
            trace: Trace::Picture,
        };
        if self.interval_m > 0.0 { vec![ink] } else { Vec::new() }
    }

    fn pass(&self, LandOfPass { origin_m, exaggeration, sea_level_m }: LandOfPass) -> Option<InkPass> {
        // The interval counts true metres, and the land is drawn higher.
        let interval_m = f64::from(self.interval_m) * exaggeration;
        let index_interval_m = LINES_PER_INDEX * interval_m;
        // Depths count from the surface of the sea. Without a sea there is nothing below it.
        let zero_m = if self.of == HeightsOf::Sea { sea_level_m.unwrap_or(NO_SEA_M) } else { 0.0 };
        let rules = HeightLineRules {
            interval_m: interval_m as f32,
            phase_m: (origin_m.z - zero_m).rem_euclid(index_interval_m) as f32,
            line_px: self.line_px,
            index_px: self.index_px,
            form_px: self.form_px,
            index: LINES_PER_INDEX as f32,
            in_sea: u32::from(self.of == HeightsOf::Sea),
            sea_m: (zero_m - origin_m.z) as f32,
            steepest: if self.steepest_deg < 90.0 { self.steepest_deg.to_radians().tan() } else { 1e9 },
        };
        let rules = bytemuck::bytes_of(&rules).to_vec();
        (self.interval_m > 0.0).then_some(InkPass { shader: HEIGHT_LINES, rules, ink: &HEIGHT_INK })
    }

    /// Replaces an interval of 0 with 1, 2 or 5 times a power of ten.
    fn prepare_for_map(&mut self, pixel_m: f64) {
        if self.interval_m == 0.0 {
            let min_m = min_m(pixel_m);
            let decade_m = 10.0_f64.powf(min_m.log10().floor());
            // An interval that is less than 1 % too small is also taken.
            let round = [1.0, 2.0, 5.0, 10.0].into_iter().find(|times| times * decade_m >= min_m * 0.99);
            self.interval_m = (decade_m * round.unwrap_or(10.0)) as f32;
        }
    }

    fn summary(&self) -> Option<String> {
        let of_maps = if self.interval_m > 0.0 { "" } else { " (on maps)" };
        let of = if self.of == HeightsOf::Sea { "depth contours" } else { "contour lines of height" };
        Some(format!("{of}{of_maps}"))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::style::Style;

    #[test]
    fn intervals_of_maps_are_round() {
        let style = Style::load("pen").unwrap();
        let interval_m = |pixel_m: f64| {
            let mut lines = HeightLines { interval_m: 0.0, ..style.lowest_height_lines().cloned().unwrap() };
            lines.prepare_for_map(pixel_m);
            f64::from(lines.interval_m)
        };
        for (pixel_m, wanted_m) in [(0.5, 2.0), (3.0, 10.0), (5.0, 20.0), (27.0, 100.0), (90.0, 200.0), (200.0, 200.0)]
        {
            assert!((interval_m(pixel_m) / wanted_m - 1.0).abs() < 1e-6, "{pixel_m} {}", interval_m(pixel_m));
        }
    }
}
