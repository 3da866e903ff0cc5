//! The `[cuts]` section of a style: lines where parallel planes cut the land.

use super::Color;
use super::parameters::{Range, parameters};

/// Largest number of families of planes.
pub const MOST_CUTS: usize = 3;

parameters! {
    /// Lines where families of parallel planes cut the land. Their density follows the spacing on the picture, and they
    /// are wider where the tone is darker.
    pub struct Cuts {
        /// Colour of the lines.
        ink: Color = Color::default();
        /// The land is smoothed to this size before it is cut, so that lines do not follow single samples.
        form_px: f32 = 6.0 => Range::Within(1.0, 256.0);
        /// Fraction of the land that the lines cover where the tone is darkest.
        darkest: f32 = 0.9 => Range::Within(0.0, 0.98);
        /// Fraction of the ink that remains in full haze; how much thinner the lines become is set by
        /// `haze.faintest_tone`.
        faintest: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// One family of parallel planes each; the families are sorted by `from`.
        layers: Vec<CutLayer> => Range::Entries(1, MOST_CUTS);
    }
}

parameters! {
    /// A family of parallel planes.
    pub struct CutLayer {
        /// Mean distance between lines on the picture.
        spacing_px: f32 = 5.0 => Range::Within(2.0, 64.0);
        /// Tilt of the planes from horizontal: 0 gives contour lines of height, 90 vertical planes.
        tilt_deg: f32 = 0.0 => Range::Within(0.0, 90.0);
        /// Azimuth toward which tilted planes rise, clockwise from north.
        azimuth_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Land at a smaller angle to the planes has no lines; for horizontal planes that is flat land.
        level_deg: f32 = 2.0 => Range::Within(0.1, 45.0);
        /// Darkness from which the family is drawn.
        from: f32 = 0.0 => Range::Within(0.0, 0.99);
    }
}
