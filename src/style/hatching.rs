//! Hatching of a style: which marks, where they point, and from which darkness on.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::marks::{self, Recipe};
use super::{Color, StyleError, within};

/// Layers, at most.
pub const MOST_LAYERS: usize = 4;

/// Tones made of marks.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hatching {
    /// Their colour.
    #[serde(default)]
    pub ink: Color,
    /// How marks keep their size while the camera comes nearer.
    #[serde(default)]
    pub scale: Scale,
    /// Width of a mark's border in tones, 0 to 0.5: 0 is a pen's, 0.1 a pencil's.
    #[serde(default)]
    pub softness: f32,
    /// Whether marks grow or shrink a little, so that their mean ink is the tone wherever one looks.
    #[serde(default = "yes")]
    pub balance: bool,
    /// 1 to [`MOST_LAYERS`]; they are sorted by `from`.
    pub layers: Vec<Layer>,
}

/// How marks keep their size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Marks of two scales hand over to each other.
    #[default]
    Blend,
    /// Coming nearer only ever adds marks.
    Add,
}

/// Marks of one kind.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// One of [`super::marks::names`], or a file beside the style's (`.toml`).
    pub marks: String,
    /// What `marks` means.
    #[serde(skip)]
    pub recipe: Option<Recipe>,
    /// Where marks point.
    #[serde(default)]
    pub direction: Direction,
    /// For fixed marks their azimuth, clockwise from north; for others how far they turn from what they follow.
    #[serde(default)]
    pub angle_deg: f32,
    /// Azimuth of slope marks where the land is level.
    #[serde(default)]
    pub level_deg: f32,
    /// Darkness from which on the layer takes part, 0 to 1.
    #[serde(default)]
    pub from: f32,
    /// Marks are this much larger than their recipe has them, 0.25 to 8.
    #[serde(default = "super::one")]
    pub size: f32,
    /// On slopes from so many degrees to so many.
    #[serde(default = "every_slope")]
    pub slope_deg: [f32; 2],
}

impl Layer {
    /// The files that the layer is read from, if the style's lies in `folder`.
    pub(super) fn files(&self, folder: &Path) -> impl Iterator<Item = PathBuf> {
        let images = self.recipe.iter().flat_map(|recipe| recipe.images.iter().cloned());
        marks::file(&self.marks, folder).into_iter().chain(images)
    }
}

/// Where marks point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// To a fixed azimuth.
    #[default]
    Fixed,
    /// Down the slope, as hachures on a map.
    Slope,
    /// Along the contour lines of height.
    Contour,
    /// Away from the eye: dots stay round on land that is seen at a flat angle.
    Sight,
}

fn yes() -> bool {
    true
}

fn every_slope() -> [f32; 2] {
    [0.0, 90.0]
}

impl Hatching {
    /// Loads what the layers name; files lie in `folder`.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        self.layers.sort_by(|a, b| a.from.total_cmp(&b.from));
        for layer in &mut self.layers {
            layer.recipe = Some(Recipe::load(&layer.marks, folder)?);
        }
        Ok(())
    }

    pub(super) fn check(&self) -> Result<(), String> {
        if !(1..=MOST_LAYERS).contains(&self.layers.len()) {
            return Err(format!("hatching.layers has {} entries, not 1 to {MOST_LAYERS}", self.layers.len()));
        }
        within("hatching.softness", self.softness, 0.0, 0.5)?;
        for (number, layer) in self.layers.iter().enumerate() {
            let within =
                |key: &str, value, low, high| within(&format!("hatching.layers[{number}].{key}"), value, low, high);
            within("from", layer.from, 0.0, 0.99)?;
            within("size", layer.size, 0.25, 8.0)?;
            within("angle_deg", layer.angle_deg, -360.0, 360.0)?;
            within("level_deg", layer.level_deg, -360.0, 360.0)?;
            within("slope_deg", layer.slope_deg[1], 0.0, 90.0)?;
            within("slope_deg", layer.slope_deg[0], 0.0, layer.slope_deg[1])?;
        }
        Ok(())
    }
}
