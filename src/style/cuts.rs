//! Cut lines of a style.

use super::Color;
use super::parameters::{Range, parameters};

/// Families of planes, at most.
pub const MOST_CUTS: usize = 3;

parameters! {
    /// Lines that families of parallel planes cut out of the land, as many as there is room for, wider where it is darker.
    pub struct Cuts {
        /// Colour of the lines.
        ink: Color = Color::default();
        /// Lines follow the land's form at this scale, and not each of its samples.
        form_px: f32 = 6.0 => Range::Within(1.0, 256.0);
        /// The part of the land that lines cover where the tone is darkest.
        darkest: f32 = 0.9 => Range::Within(0.0, 0.98);
        /// What is left of the ink of lines in full haze; that they are thinner is `haze.faintest_tone`.
        faintest: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Families of planes; they are sorted by `from`.
        layers: Vec<CutLayer> => Range::Entries(1, MOST_CUTS);
    }
}

parameters! {
    /// A family of parallel planes.
    pub struct CutLayer {
        /// Distance of lines from each other on the picture, in the mean.
        spacing_px: f32 = 5.0 => Range::Within(2.0, 64.0);
        /// How far the planes lean from level: 0 is lines of equal height, 90 planes that stand upright.
        tilt_deg: f32 = 0.0 => Range::Within(0.0, 90.0);
        /// Azimuth to which they rise, clockwise from north.
        azimuth_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Land that lies nearer to the planes than this has no lines: of level planes, level land.
        level_deg: f32 = 2.0 => Range::Within(0.1, 45.0);
        /// Darkness from which on the family takes part.
        from: f32 = 0.0 => Range::Within(0.0, 0.99);
    }
}
