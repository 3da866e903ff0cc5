//! Stroke textures: how a tool leaves its ink along a stroke. A recipe is TOML; the tile is grown from it
//! (`lines/strokes/texture`). Five come with the program, and a style may name a file of its own.

use std::path::{Path, PathBuf};

use super::StyleError;
use super::parameters::{self, Range, parameters};
use super::recipes::Recipes;

/// The recipes that come with the program, by name.
const RECIPES: Recipes = Recipes {
    built_in: &[
        ("pen", include_str!("../../textures/strokes/pen.toml")),
        ("brush", include_str!("../../textures/strokes/brush.toml")),
        ("pencil", include_str!("../../textures/strokes/pencil.toml")),
        ("charcoal", include_str!("../../textures/strokes/charcoal.toml")),
        ("dry-ink", include_str!("../../textures/strokes/dry-ink.toml")),
    ],
    unknown: |name| StyleError::UnknownTexture { name },
    unreadable: |path, source| StyleError::ReadTexture { path, source },
};

parameters! {
    /// How a stroke texture is made and used. Everything that has no unit is a part of something, 0 to 1.
    pub struct Recipe {
        /// What the texture is, in a line.
        description: String;
        /// The piece that repeats along strokes, and across them where they are wider.
        tile: Tile;
        /// How the tool touches the paper.
        touch: Touch;
        /// What the tool leaves where it touches.
        pigment: Pigment;
        /// What is high and takes ink first: noises that are added.
        marks: Vec<Marks> => Range::Entries(1, 8);
    }
}

parameters! {
    /// The piece that repeats along strokes, and across them where they are wider. A texel is a pixel.
    #[derive(Copy, Eq)]
    pub struct Tile {
        /// Length along the stroke.
        along_px: u32 => Range::PowerOfTwo(64, 2048);
        /// Width across the stroke.
        across_px: u32 => Range::PowerOfTwo(16, 512);
        /// Another number gives another tile of the same kind.
        seed: u32;
    }
}

parameters! {
    /// How the tool touches the paper.
    #[derive(Copy)]
    pub struct Touch {
        /// The width of a stroke whose marks have the sizes below.
        nominal_width_px: f32 => Range::Within(1.0, 64.0);
        /// How much marks widen with the stroke: 0 not at all, as the grain of paper; 1 fully, as the hairs of a brush.
        spread: f32 => Range::Within(0.0, 1.0);
        /// How gradually a mark takes ink as pressure grows.
        softness: f32 => Range::Within(0.01, 0.5);
        /// Exponent of the pressure; below 1 a light hand already leaves much.
        response: f32 => Range::Within(0.05, 4.0);
        /// Which part of the paper takes ink at full pressure.
        fill: f32 => Range::Within(0.05, 1.0);
        /// Width of the border in which pressure falls.
        border_px: f32 => Range::Within(0.0, 32.0);
        /// The border's widest share of half the stroke, so that thin strokes keep a middle.
        border_part: f32 => Range::Within(0.0, 1.0);
        /// What is left of the pressure at the very border.
        border_pressure: f32 => Range::Within(0.0, 1.0);
    }
}

parameters! {
    /// What the tool leaves where it touches.
    #[derive(Copy)]
    pub struct Pigment {
        /// How dark a full mark is in the mean.
        density: f32 => Range::Within(0.05, 1.0);
        /// How far the darkness goes up and down at most.
        variation: f32 => Range::Within(0.0, 1.0);
        /// Length of a change along the stroke.
        along_px: f32 => Range::Within(1.0, 256.0);
        /// Length of a change across the stroke.
        across_px: f32 => Range::Within(1.0, 64.0);
    }
}

parameters! {
    /// A noise: white, blurred to this size.
    #[derive(Copy)]
    pub struct Marks {
        /// Length of a mark along the stroke.
        along_px: f32 => Range::Within(1.0, 256.0);
        /// Width of a mark across the stroke.
        across_px: f32 => Range::Within(1.0, 64.0);
        /// The noise's part in the sum.
        weight: f32 => Range::Within(1e-3, 16.0);
        /// How far marks swerve to the sides along the stroke.
        wander_px: f32 = 0.0 => Range::Within(0.0, 16.0);
    }
}

/// The names of the recipes that come with the program.
pub fn names() -> Vec<&'static str> {
    RECIPES.names()
}

/// The file that a name of a stroke texture means, from `folder` on; none for those that come with the program.
pub(super) fn file(name: &str, folder: &Path) -> Option<PathBuf> {
    RECIPES.file(name, folder)
}

/// What a style's parameter names, from `folder` on.
pub(super) fn named(name: Option<&str>, folder: &Path) -> Result<Option<Recipe>, StyleError> {
    name.map(|name| Recipe::load(name, folder)).transpose()
}

impl Recipe {
    /// One of [`names`], or a file (`.toml`), whose path is taken from `folder`.
    ///
    /// # Errors
    /// [`StyleError`] with the file's name.
    pub fn load(name: &str, folder: &Path) -> Result<Self, StyleError> {
        let (shown, text) = RECIPES.text(name, folder)?;
        Self::parse(&shown, &text)
    }

    /// A recipe from its text; `name` is for errors.
    ///
    /// # Errors
    /// [`StyleError::Parse`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        Ok(parameters::read(name, text)?)
    }
}
