//! How light becomes tone and colour.

use serde::Deserialize;

use super::{Color, one, within};

/// How light becomes colour.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase", tag = "kind")]
pub enum Tone {
    /// Blinn-Phong over an elevation tint.
    Plain,
    /// Steps.
    Toon(Toon),
}

/// Steps of light.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Toon {
    /// 2 to 64; 0 is smooth.
    pub steps: u32,
    /// Tone of the darkest step, 0 to 1.
    pub darkest: f32,
    /// Tone of the lightest step, 0 to 1.
    #[serde(default = "one")]
    pub lightest: f32,
    /// How much of the tone is colour, 0 to 1: marks can do the rest.
    #[serde(default = "one")]
    pub wash: f32,
    /// Colours of the tones; without them they are greys.
    pub ramp: Option<Ramp>,
    /// Part of a step in which it fades to the next, 0 to 1.
    #[serde(default)]
    pub softness: f32,
}

/// Colours by tone and by something else of the place (X-toon: Barla, Thollot and Markosian 2006).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// What else counts.
    #[serde(default)]
    pub by: Attribute,
    /// In rising order, 1 to 16 of them; between them colours are mixed.
    pub stops: Vec<Stop>,
}

/// What a ramp goes by, beside the tone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Attribute {
    /// 0 at the lowest place of the land, 1 at the highest.
    #[default]
    Height,
    /// Degrees.
    Slope,
    /// Metres from the eye.
    Distance,
}

/// Colours at a value of the attribute.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Of the attribute.
    pub at: f32,
    /// From the darkest tone to the lightest, 1 to 16, at even distances.
    pub colors: Vec<Color>,
}

/// Tones that run and settle as water and pigment do (Bousseau, Kaplan, Thollot and Sillion 2006).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Watercolor {
    /// How much darker pigment is where a wash ends, 0 to 4.
    pub edge: f32,
    /// Width of that edge, 1 to 16 pixels.
    pub edge_px: f32,
    /// How much pigment settles in the paper's valleys, 0 to 2.
    pub granulation: f32,
    /// How unevenly water carries it, 0 to 2.
    pub flow: f32,
    /// How far washes stray from what they fill, 0 to 32 pixels.
    pub warp_px: f32,
}

impl Default for Watercolor {
    fn default() -> Self {
        Self { edge: 1.2, edge_px: 3.0, granulation: 0.5, flow: 0.6, warp_px: 5.0 }
    }
}

/// How light falls.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Shading {
    /// How far light reaches around, 0 to 1: 0 is Lambert's cosine, 1 keeps form in the shade.
    pub wrap: f32,
    /// What is left where the sun does not shine, 0 to 1.
    pub ambient: f32,
    /// How much of the sun cast shadows take, 0 to 1.
    pub shadow: f32,
    /// How much of the ambient light the land around takes, 0 to 1.
    pub occlusion: f32,
    /// How much of the darkness is the slope's own, 0 to 1: 45 degrees are black.
    pub slope: f32,
    /// What light is multiplied by, 0.25 to 4: above 1 more of the land is white.
    pub exposure: f32,
    /// Exponent of the tone, 0.2 to 5: above 1 is darker.
    pub contrast: f32,
}

impl Default for Shading {
    fn default() -> Self {
        Self { wrap: 1.0, ambient: 0.0, shadow: 0.0, occlusion: 0.0, slope: 0.0, exposure: 1.0, contrast: 1.0 }
    }
}

impl Toon {
    pub(super) fn check(&self) -> Result<(), String> {
        if self.steps != 0 && !(2..=64).contains(&self.steps) {
            return Err(format!("tone.steps is {}, neither 0 nor between 2 and 64", self.steps));
        }
        within("tone.darkest", self.darkest, 0.0, 1.0)?;
        within("tone.softness", self.softness, 0.0, 1.0)?;
        within("tone.lightest", self.lightest, 0.0, 1.0)?;
        within("tone.wash", self.wash, 0.0, 1.0)?;
        self.ramp.as_ref().map_or(Ok(()), Ramp::check)
    }
}

impl Ramp {
    fn check(&self) -> Result<(), String> {
        if !(1..=16).contains(&self.stops.len()) {
            return Err(format!("tone.ramp.stops has {} entries, not 1 to 16", self.stops.len()));
        }
        for pair in self.stops.windows(2) {
            if !(pair[1].at > pair[0].at && pair[1].at - pair[0].at < f32::INFINITY) {
                return Err(format!("tone.ramp.stops must rise, and do not from {} to {}", pair[0].at, pair[1].at));
            }
        }
        for (number, stop) in self.stops.iter().enumerate() {
            within(&format!("tone.ramp.stops[{number}].at"), stop.at, -1e9, 1e9)?;
            if !(1..=16).contains(&stop.colors.len()) {
                return Err(format!("tone.ramp.stops[{number}].colors has {} entries, not 1 to 16", stop.colors.len()));
            }
        }
        Ok(())
    }
}

impl Shading {
    pub(super) fn check(&self) -> Result<(), String> {
        within("light.wrap", self.wrap, 0.0, 1.0)?;
        within("light.ambient", self.ambient, 0.0, 1.0)?;
        within("light.shadow", self.shadow, 0.0, 1.0)?;
        within("light.occlusion", self.occlusion, 0.0, 1.0)?;
        within("light.slope", self.slope, 0.0, 1.0)?;
        within("light.exposure", self.exposure, 0.25, 4.0)?;
        within("light.contrast", self.contrast, 0.2, 5.0)
    }
}

impl Watercolor {
    pub(super) fn check(&self) -> Result<(), String> {
        within("watercolor.edge", self.edge, 0.0, 4.0)?;
        within("watercolor.edge_px", self.edge_px, 1.0, 16.0)?;
        within("watercolor.granulation", self.granulation, 0.0, 2.0)?;
        within("watercolor.flow", self.flow, 0.0, 2.0)?;
        within("watercolor.warp_px", self.warp_px, 0.0, 32.0)
    }
}
