//! The `[height_lines]` section of a style: contour lines of height.

use super::Color;
use super::parameters::{Range, parameters};

parameters! {
    /// Contour lines of height (isohypses); every fifth line is an index contour.
    pub struct HeightLines {
        /// Colour of the lines.
        ink: Color = Color::default();
        /// Contour interval in metres; 0 chooses a round number for the scale of a map, and draws no lines in other
        /// views.
        interval_m: f32 = 0.0 => Range::Within(0.0, 10_000.0);
        /// Width of a line.
        line_px: f32 = 0.7 => Range::Within(0.1, 8.0);
        /// Width of every fifth line, the index contour.
        index_px: f32 = 1.3 => Range::Within(0.1, 8.0);
        /// The land is smoothed to this size first, so that lines do not follow single samples.
        form_px: f32 = 4.0 => Range::Within(1.0, 256.0);
        /// Steeper land has no lines; useful on maps with rock drawing.
        steepest_deg: f32 = 90.0 => Range::Within(5.0, 90.0);
        /// Fraction of the ink that remains in full haze.
        faintest: f32 = 0.2 => Range::Within(0.0, 1.0);
    }
}

/// Returns the smallest contour interval, in metres, of a map with pixels of `pixel_m` metres. At large scales, lines
/// on a slope of 45° are nearly three pixels apart. Small scales have gentler slopes and use the intervals of
/// topographic maps from 1 : 50 000 to 1 : 1 000 000, on a screen of 96 dots per inch.
fn least_m(pixel_m: f64) -> f64 {
    (3.0 * pixel_m).min(8.4 * pixel_m.powf(0.6))
}

impl HeightLines {
    /// Returns the lines for a map with pixels of `pixel_m` metres. An interval of 0 becomes 1, 2 or 5 times a power of
    /// ten.
    #[must_use]
    pub fn for_map(mut self, pixel_m: f64) -> Self {
        if self.interval_m == 0.0 {
            let least_m = least_m(pixel_m);
            let decade_m = 10.0_f64.powf(least_m.log10().floor());
            let round = [1.0, 2.0, 5.0, 10.0].into_iter().find(|times| times * decade_m >= least_m * 0.99);
            self.interval_m = (decade_m * round.unwrap_or(10.0)) as f32;
        }
        self
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
            let lines = HeightLines { interval_m: 0.0, ..style.height_lines.clone().unwrap() };
            f64::from(lines.for_map(pixel_m).interval_m)
        };
        for (pixel_m, wanted_m) in [(0.5, 2.0), (3.0, 10.0), (5.0, 20.0), (27.0, 100.0), (90.0, 200.0), (200.0, 200.0)]
        {
            assert!((interval_m(pixel_m) / wanted_m - 1.0).abs() < 1e-6, "{pixel_m} {}", interval_m(pixel_m));
        }
    }
}
