//! Recipes of stroke textures: how a drawing tool leaves ink along a stroke. A recipe is a TOML file from which
//! `lines/strokes/texture` generates a tile. Five recipes are built in, and a style may name a file of its own.

use std::path::{Path, PathBuf};

use super::StyleError;
use super::parameters::{self, Range, parameters};
use super::recipes::Recipes;

/// The built-in recipes, by name.
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
    /// How a stroke texture is generated and used. Values without a unit are fractions, 0 to 1.
    pub struct Recipe {
        /// One-line description of the texture.
        description: String;
        /// The tile that repeats along strokes, and across them where they are wider than the tile.
        tile: Tile;
        /// How the drawing tool touches the paper.
        touch: Touch;
        /// The pigment that the tool leaves where it touches.
        pigment: Pigment;
        /// Noises whose sum is a height field; the highest parts take ink first.
        marks: Vec<Marks> => Range::Entries(1, 8);
    }
}

parameters! {
    /// The tile that repeats along strokes, and across them where they are wider than the tile. A texel is a pixel.
    #[derive(Copy, Eq)]
    pub struct Tile {
        /// Length of the tile along the stroke.
        along_px called "Length along stroke": u32 => Range::PowerOfTwo(64, 2048);
        /// Width of the tile across the stroke.
        across_px called "Width across stroke": u32 => Range::PowerOfTwo(16, 512);
        /// Seed of the noise; another number gives another tile of the same kind.
        seed: u32;
    }
}

parameters! {
    /// How the drawing tool touches the paper.
    #[derive(Copy)]
    pub struct Touch {
        /// Width of a stroke for which the sizes below apply.
        nominal_width_px called "Nominal stroke width": f32 => Range::Within(1.0, 64.0);
        /// How much marks widen with the stroke: 0 is not at all, like the grain of paper; 1 is fully, like brush
        /// hairs.
        spread called "Widening with stroke": f32 => Range::Within(0.0, 1.0), zero "none";
        /// How gradually a mark takes ink as pressure increases.
        softness called "Softness of ink": f32 => Range::Within(0.01, 0.5);
        /// Exponent of the pressure; below 1 light pressure already leaves much ink.
        response called "Pressure exponent": f32 => Range::Within(0.05, 4.0);
        /// Fraction of the paper that takes ink at full pressure.
        fill called "Largest ink cover": f32 => Range::Within(0.05, 1.0);
        /// Width of the border of a stroke in which pressure decreases.
        border_px: f32 => Range::Within(0.0, 32.0);
        /// Largest width of the border, as a fraction of half the stroke's width, so that thin strokes keep a core.
        border_part called "Largest border part": f32 => Range::Within(0.0, 1.0);
        /// Fraction of the pressure that remains at the outer edge of the border.
        border_pressure: f32 => Range::Within(0.0, 1.0);
    }
}

parameters! {
    /// The pigment that the tool leaves where it touches.
    #[derive(Copy)]
    pub struct Pigment {
        /// Mean darkness of a full mark.
        density called "Mean darkness": f32 => Range::Within(0.05, 1.0);
        /// Largest deviation of the darkness from its mean.
        variation called "Variation of darkness": f32 => Range::Within(0.0, 1.0);
        /// Length of a variation of darkness along the stroke.
        along_px called "Variation along stroke": f32 => Range::Within(1.0, 256.0);
        /// Length of a variation of darkness across the stroke.
        across_px called "Variation across stroke": f32 => Range::Within(1.0, 64.0);
    }
}

parameters! {
    /// White noise, blurred to the size of a mark.
    #[derive(Copy)]
    pub struct Marks {
        /// Length of a mark along the stroke.
        along_px called "Mark length": f32 => Range::Within(1.0, 256.0);
        /// Width of a mark across the stroke.
        across_px called "Mark width": f32 => Range::Within(1.0, 64.0);
        /// Weight of this noise in the sum.
        weight: f32 => Range::Within(1e-3, 16.0);
        /// How far marks swerve sideways along the stroke.
        wander_px: f32 = 0.0 => Range::Within(0.0, 16.0);
    }
}

/// Returns the names of the built-in recipes.
pub fn names() -> Vec<&'static str> {
    RECIPES.names()
}

/// Returns the file that `name` refers to, relative to `folder`; `None` for a built-in recipe.
pub(super) fn file(name: &str, folder: &Path) -> Option<PathBuf> {
    RECIPES.file(name, folder)
}

impl Recipe {
    /// Loads one of [`names`], or a file (`.toml`) whose path is relative to `folder`.
    ///
    /// # Errors
    /// [`StyleError`] with the file's name.
    pub fn load(name: &str, folder: &Path) -> Result<Self, StyleError> {
        let (shown, text) = RECIPES.text(name, folder)?;
        Self::parse(&shown, &text)
    }

    /// Parses a recipe; errors begin with `name`.
    ///
    /// # Errors
    /// [`StyleError::Parse`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        Ok(parameters::read(name, text)?)
    }
}
