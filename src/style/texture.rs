//! Stroke textures: how a tool leaves its ink along a stroke. A recipe is TOML; the tile is grown from it
//! (`lines/strokes/texture`). Five come with the program, and a style may name a file of its own.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::StyleError;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::toml_text;

/// The recipes that come with the program, by name.
const RECIPES: &[(&str, &str)] = &[
    ("pen", include_str!("../../textures/strokes/pen.toml")),
    ("brush", include_str!("../../textures/strokes/brush.toml")),
    ("pencil", include_str!("../../textures/strokes/pencil.toml")),
    ("charcoal", include_str!("../../textures/strokes/charcoal.toml")),
    ("dry-ink", include_str!("../../textures/strokes/dry-ink.toml")),
];

/// How a stroke texture is made and used. Everything that has no unit is a part of something, 0 to 1.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// In a line.
    pub description: String,
    /// The piece that repeats.
    pub tile: Tile,
    /// How the tool touches the paper.
    pub touch: Touch,
    /// What it leaves where it touches.
    pub pigment: Pigment,
    /// What is high and takes ink first: noises that are added, 1 to 8 of them.
    pub marks: Vec<Marks>,
}

/// The piece that repeats along strokes, and across them where they are wider. A texel is a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tile {
    /// A power of two, 64 to 2048.
    pub along_px: u32,
    /// A power of two, 16 to 512.
    pub across_px: u32,
    /// Another one gives another tile of the same kind.
    pub seed: u32,
}

/// How the tool touches the paper.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// The width of a stroke whose marks have the sizes below, 1 to 64.
    pub nominal_width_px: f32,
    /// How much the marks widen with the stroke: 0 not at all, as the grain of paper; 1 fully, as the hairs of a brush.
    pub spread: f32,
    /// How gradually a mark takes ink as pressure grows, 0.01 to 0.5.
    pub softness: f32,
    /// Exponent of the pressure, 0.05 to 4: below 1 a light hand already leaves much.
    pub response: f32,
    /// Which part of the paper takes ink at full pressure, 0.05 to 1.
    pub fill: f32,
    /// Width of the border in which pressure falls, 0 to 32.
    pub border_px: f32,
    /// The border's widest share of half the stroke, so that thin strokes keep a middle.
    pub border_part: f32,
    /// What is left of the pressure at the very border.
    pub border_pressure: f32,
}

/// What the tool leaves where it touches.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pigment {
    /// The mean, 0.05 to 1.
    pub density: f32,
    /// How far it goes up and down at most.
    pub variation: f32,
    /// Length of a change along the stroke, 1 to 256.
    pub along_px: f32,
    /// And across it, 1 to 64.
    pub across_px: f32,
}

/// A noise: white, blurred to this size.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marks {
    /// Length of a mark along the stroke, 1 to 256.
    pub along_px: f32,
    /// And across it, 1 to 64.
    pub across_px: f32,
    /// Its part in the sum, above 0, at most 16.
    pub weight: f32,
    /// How far marks swerve to the sides along the stroke, 0 to 16.
    #[serde(default)]
    pub wander_px: f32,
}

/// The names of the recipes that come with the program.
pub fn names() -> Vec<&'static str> {
    RECIPES.iter().map(|(name, _)| *name).collect()
}

/// The file that a name of a stroke texture means, from `folder` on; none for those that come with the program.
pub(super) fn file(name: &str, folder: &Path) -> Option<PathBuf> {
    let is_built_in = RECIPES.iter().any(|(known, _)| *known == name);
    (!is_built_in).then(|| folder.join(name))
}

impl Recipe {
    /// One of [`names`], or a file (`.toml`), whose path is taken from `folder`.
    ///
    /// # Errors
    /// [`StyleError`] with the file's name.
    pub fn load(name: &str, folder: &Path) -> Result<Self, StyleError> {
        if let Some((_, text)) = RECIPES.iter().find(|(known, _)| *known == name) {
            return Self::parse(name, text);
        }
        if Path::new(name).extension().is_none_or(|extension| extension != "toml") {
            return Err(StyleError::UnknownTexture { name: name.to_owned() });
        }
        let path = folder.join(name);
        let shown = path.display().to_string();
        let text = read_text(&path, LARGEST_STYLE_BYTES)
            .map_err(|source| StyleError::ReadTexture { path: shown.clone(), source })?;
        Self::parse(&shown, &text)
    }

    /// A recipe from its text; `name` is for errors.
    ///
    /// # Errors
    /// [`StyleError::Parse`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        let recipe: Self = toml_text::read(name, text)?;
        recipe.check().map_err(|cause| super::misplaced(name, text, &cause))?;
        Ok(recipe)
    }

    fn check(&self) -> Result<(), String> {
        let power = |what: &str, value: u32, low: u32, high: u32| {
            let holds = value.is_power_of_two() && (low..=high).contains(&value);
            holds.then_some(()).ok_or_else(|| format!("{what} is {value}, not a power of two from {low} to {high}"))
        };
        power("tile.along_px", self.tile.along_px, 64, 2048)?;
        power("tile.across_px", self.tile.across_px, 16, 512)?;
        if !(1..=8).contains(&self.marks.len()) {
            return Err(format!("marks has {} entries, not 1 to 8", self.marks.len()));
        }
        let (touch, pigment) = (&self.touch, &self.pigment);
        let numbers = [
            ("touch.nominal_width_px", touch.nominal_width_px, 1.0, 64.0),
            ("touch.spread", touch.spread, 0.0, 1.0),
            ("touch.softness", touch.softness, 0.01, 0.5),
            ("touch.response", touch.response, 0.05, 4.0),
            ("touch.fill", touch.fill, 0.05, 1.0),
            ("touch.border_px", touch.border_px, 0.0, 32.0),
            ("touch.border_part", touch.border_part, 0.0, 1.0),
            ("touch.border_pressure", touch.border_pressure, 0.0, 1.0),
            ("pigment.density", pigment.density, 0.05, 1.0),
            ("pigment.variation", pigment.variation, 0.0, 1.0),
            ("pigment.along_px", pigment.along_px, 1.0, 256.0),
            ("pigment.across_px", pigment.across_px, 1.0, 64.0),
        ];
        for (what, value, low, high) in numbers {
            super::within(what, value, low, high)?;
        }
        for (number, marks) in self.marks.iter().enumerate() {
            let within =
                |key: &str, value, low, high| super::within(&format!("marks[{number}].{key}"), value, low, high);
            within("along_px", marks.along_px, 1.0, 256.0)?;
            within("across_px", marks.across_px, 1.0, 64.0)?;
            within("weight", marks.weight, 1e-3, 16.0)?;
            within("wander_px", marks.wander_px, 0.0, 16.0)?;
        }
        Ok(())
    }
}
