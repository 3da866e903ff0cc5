//! Lines of a style.

use serde::Deserialize;

use super::{Color, one, within, yes};

/// Lines of a style.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lines {
    /// What finds them.
    pub detector: Detector,
    /// ε of LSA contours.
    #[serde(default)]
    pub epsilon: Epsilon,
    /// Errors at which a line begins and is full.
    pub ramp: [f32; 2],
    /// Strength of the line-density filter: 0 is off, 2 the paper's.
    #[serde(default)]
    pub density: f32,
    /// Whether stairs are smoothed.
    #[serde(default = "yes")]
    pub antialias: bool,
    /// Their colour.
    #[serde(default)]
    pub ink: Color,
    /// What is left of a line in full haze, 0 to 1.
    #[serde(default)]
    pub faintest: f32,
    /// How much farther than tones lines reach into the haze.
    #[serde(default = "one")]
    pub reach: f32,
}

/// What finds lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Detector {
    /// Local Surface Approximation contours.
    Lsa,
    /// Sobel's operator on depth.
    Sobel,
    /// Roystan's outline.
    Roystan,
}

/// ε of the planarity term of LSA contours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Epsilon {
    /// 1e-5 m, as printed.
    Paper,
    /// A part of the pixel's size in the world.
    #[default]
    Footprint,
}

impl Lines {
    pub(super) fn check(&self) -> Result<(), String> {
        if !(self.ramp[0] >= 0.0 && self.ramp[1] > self.ramp[0] && self.ramp[1].is_finite()) {
            return Err(format!("lines.ramp is {:?}; it must rise, from 0 or more", self.ramp));
        }
        if !(self.density >= 0.0 && self.density.is_finite()) {
            return Err(format!("lines.density is {}, not 0 or more", self.density));
        }
        if !(self.reach > 0.0 && self.reach.is_finite()) {
            return Err(format!("lines.reach is {}, not above 0", self.reach));
        }
        within("lines.faintest", self.faintest, 0.0, 1.0)
    }
}
