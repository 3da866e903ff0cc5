//! Lines of a style.

use super::parameters::{Range, choices, parameters};
use super::{Color, Strokes};

parameters! {
    /// Lines of a style.
    pub struct Lines {
        /// What finds the lines.
        detector: Detector;
        /// The ε of the planarity term of LSA contours.
        epsilon: Epsilon = Epsilon::Footprint;
        /// Whether LSA contours are held against pixels twice as far, which calms lines of details smaller than a pixel.
        geometric_antialias: bool = false;
        /// Whether opposite neighbours share the greater of their errors; else the density filter has eight directions.
        halved: bool = true;
        /// Two answers of the detector: a line begins at the first, and is full from the second on.
        ramp: [f32; 2] => Range::Rising(0.0);
        /// Strength of the filter that thins out crowded lines; 0 turns it off, and 2 is the paper's.
        density: f32 = 0.0 => Range::AtLeast(0.0);
        /// The part of the paper that lines may cover about a place; beyond it the least ones go first, and 1 is no cap.
        crowd: f32 = 1.0 => Range::Within(0.005, 1.0);
        /// Side of the window in which that is counted.
        crowd_px: f32 = 32.0 => Range::Within(8.0, 512.0);
        /// What two eyes do so that their lines agree.
        stereo: Stereo = Stereo::Full;
        /// Where contours of two eyes begin to fade out, from the contour in angles between the eyes.
        fade_start: f32 = 1.75 => Range::Within(0.0, 100.0);
        /// Where the fade is full.
        fade_end: f32 = 0.4375 => Range::Within(0.0, 100.0);
        /// Whether the stairs of lines are smoothed.
        antialias: bool = true;
        /// Colour of the lines.
        ink: Color = Color::default();
        /// What is left of a line in full haze.
        faintest: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How many times farther than tones lines reach into the haze.
        reach: f32 = 1.0 => Range::Above(0.0);
    }
}

impl Lines {
    /// Contours of trees alone, in a style that has strokes for everything else.
    pub fn of_trees(strokes: &Strokes) -> Self {
        Self {
            detector: Detector::Lsa,
            ramp: [0.25, 0.5],
            density: 2.0,
            ink: strokes.ink,
            faintest: strokes.faintest,
            reach: strokes.reach,
            epsilon: Epsilon::Footprint,
            geometric_antialias: false,
            halved: true,
            crowd: 1.0,
            crowd_px: 32.0,
            stereo: Stereo::Full,
            fade_start: 1.75,
            fade_end: 0.4375,
            antialias: true,
        }
    }

    /// Whether the density filter has each of the eight directions by itself.
    pub fn has_eight_directions(&self) -> bool {
        self.detector == Detector::Lsa && !self.halved && self.density > 0.0
    }
}

choices! {
    /// What finds lines.
    pub enum Detector {
        /// Local Surface Approximation contours.
        Lsa,
        /// Sobel's operator on depth.
        Sobel,
        /// Roystan's outline.
        Roystan,
        /// Contours and suggestive contours by the curvature of the land, as `[curvature]` has them.
        Curvature,
    }
}

choices! {
    /// What two eyes do so that their lines agree.
    pub enum Stereo {
        /// Nothing: each draws its own.
        Alone,
        /// Lines that the other eye should have and has not go.
        Suppressed,
        /// Contours fade out to where the other eye sees them, too.
        Full,
    }
}

choices! {
    /// ε of the planarity term of LSA contours.
    pub enum Epsilon {
        /// As printed in the paper, 1e-5 m.
        Paper,
        /// A part of the pixel's size in the world.
        Footprint,
    }
}
