//! Lines that are detected in images of the surface. Their passes are in `src/lines`.

use super::{Channels, Fading, Ink, LayerBehaviour, Margins, Strokes, Trace};
use crate::style::Color;
use crate::style::parameters::{Range, choices, parameters};

parameters! {
    /// Lines that are detected in images of the surface.
    pub struct Lines {
        /// Method that detects the lines.
        detector: Detector;
        /// Value of ε in the planarity term of LSA contours.
        epsilon called "Planarity tolerance": Epsilon = Epsilon::Footprint;
        /// Whether LSA contours are also tested at twice the pixel distance, which steadies details smaller than a
        /// pixel.
        geometric_antialias called "Steady fine detail": bool = false;
        /// Whether opposite neighbours share the greater of their errors; otherwise the density filter uses eight
        /// directions.
        halved called "Four directions only": bool = true;
        /// Two values of the detector: a line starts to appear at the first and is full from the second.
        ramp called "Line thresholds": [f32; 2] => Range::Rising(0.0);
        /// Strength of the filter that thins out crowded lines; 0 turns it off, 2 is the value of the paper.
        density called "Thinning strength": f32 = 0.0 => Range::AtLeast(0.0), soft 10.0, zero "off";
        /// Largest fraction of the area that lines may cover; above it the weakest lines are removed first; 1 is no
        /// limit.
        crowd called "Largest covered area": f32 = 1.0 => Range::Within(0.005, 1.0);
        /// Side of the square window in which the covered area is measured for `crowd`.
        crowd_px called "Cover window": f32 = 32.0 => Range::Within(8.0, 512.0);
        /// How the lines of the two eyes of a stereo pair are made to agree.
        stereo called "Stereo agreement": Stereo = Stereo::Full;
        /// Where contours of a stereo pair begin to fade out, as a distance from the contour in angles between the two
        /// eyes.
        fade_start called "Start of stereo fade": f32 = 1.75 => Range::Within(0.0, 100.0);
        /// Where that fade reaches full strength, in the same unit.
        fade_end called "End of stereo fade": f32 = 0.4375 => Range::Within(0.0, 100.0);
        /// Whether the staircase edges of lines are smoothed.
        antialias called "Smooth edges": bool = true;
        /// Colour of the lines.
        ink called "Ink colour": Color = Color::default();
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Lines fade in haze this many times farther away than tones.
        reach called "Reach in haze": f32 = 1.0 => Range::Above(0.0), soft 8.0;
    }
}

impl Lines {
    /// Returns the settings for contours of trees in a style that draws all other contours as strokes.
    pub(crate) fn of_trees(strokes: &Strokes) -> Self {
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

    /// Returns whether the density filter treats each of the eight directions separately.
    pub(crate) fn has_eight_directions(&self) -> bool {
        self.detector.measure() == Measure::AxisErrors && !self.halved && self.density > 0.0
    }
}

/// Largest distance at which ink influences a line's rank among crowded lines, in sides of the window: half a window, a
/// cell, and the distance between two cells.
const CROWD_REACH: f32 = 1.25;

impl LayerBehaviour for Lines {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "lines",
            label: "Detected lines".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnNearest { faintest: self.faintest, reach: self.reach },
            makes_tone: false,
            is_main: true,
            trace: Trace::LeftOut("pixel lines"),
        }]
    }

    fn margins(&self) -> Margins {
        let reach_px = if self.crowd < 1.0 { (self.crowd_px * CROWD_REACH).ceil() as u32 } else { 0 };
        Margins { added_px: reach_px, ..Margins::default() }
    }

    fn summary(&self) -> Option<String> {
        Some(format!("lines by {}", self.detector.name()))
    }

    fn unscaled(&self) -> Option<&'static str> {
        Some("detected lines")
    }
}

choices! {
    /// Method that detects lines.
    pub enum Detector {
        /// Local Surface Approximation contours.
        Lsa,
        /// Sobel's operator on depth.
        Sobel,
        /// Roystan's outline shader.
        Roystan,
        /// Contours and suggestive contours by the curvature of the land, with the settings of `[curvature]`.
        Curvature,
    }
}

/// The quantity that a detector computes at a pixel, which decides how its result becomes lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    /// An error along each of four axes.
    AxisErrors,
    /// One error, without a direction.
    Error,
    /// The ink of lines. It needs surfaces with curvature, so trees are drawn by LSA contours.
    Ink,
}

impl Detector {
    /// Returns what the detector computes at a pixel.
    pub(crate) fn measure(self) -> Measure {
        match self {
            Self::Lsa => Measure::AxisErrors,
            Self::Sobel | Self::Roystan => Measure::Error,
            Self::Curvature => Measure::Ink,
        }
    }
}

choices! {
    /// How the lines of the two eyes of a stereo pair are made to agree.
    pub enum Stereo {
        /// Each eye draws its own lines, independent of the other.
        Alone,
        /// Lines that the other eye should also see, but does not draw, are removed.
        Suppressed,
        /// Like `suppressed`; contours also fade out toward their position in the other eye.
        Full,
    }
}

choices! {
    /// Value of ε in the planarity term of LSA contours.
    pub enum Epsilon {
        /// The value printed in the paper, 1e-5 m.
        Paper,
        /// A fraction of the size of a pixel in the world.
        Footprint,
    }
}
