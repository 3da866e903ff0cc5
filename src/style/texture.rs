//! Recipes of stroke textures: how a drawing tool leaves ink along a stroke. A recipe is a TOML file from which
//! `lines/strokes/texture` generates a tile. Five recipes are built in, and a style may name a file of its own, or a
//! picture of a stroke (PNG), which is a recipe with an image.

pub(crate) mod picture;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::picture::StrokePicture;
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
        /// Picture of a stroke (PNG), relative to the recipe; it takes the place of `pigment` and `marks`.
        image: Option<PathBuf>;
        /// The tile that repeats along strokes, and across them where they are wider than the tile.
        tile: Tile;
        /// How the drawing tool touches the paper.
        touch: Touch;
        /// The pigment that the tool leaves where it touches.
        pigment: Pigment;
        /// Noises whose sum is a height field; the highest parts take ink first.
        marks: Vec<Marks> => Range::Entries(1, 8);
    } loaded {
        /// The loaded picture of `image`.
        picture: Option<Arc<StrokePicture>>;
    }
}

parameters! {
    /// The tile that repeats along strokes, and across them where they are wider than it. A texel is a pixel.
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

/// Returns the files that a recipe was read from: that of its name, and its image. `folder` is the folder of the style.
pub(super) fn files(name: Option<&str>, recipe: Option<&Recipe>, folder: &Path) -> Vec<PathBuf> {
    let own = name.and_then(|name| file(name, folder));
    let image = recipe.and_then(|recipe| recipe.image.clone()).filter(|image| own.as_ref() != Some(image));
    own.into_iter().chain(image).collect()
}

/// Returns the file that `name` refers to, relative to `folder`; `None` for a built-in recipe.
pub(super) fn file(name: &str, folder: &Path) -> Option<PathBuf> {
    RECIPES.file(name, folder)
}

/// A recipe for a picture of a stroke: pressure takes away its palest parts first, and its border is that of the picture.
const OF_PICTURE: &str = include_str!("../../textures/strokes/of-picture.toml");

/// Least and largest side of a picture's tile across the stroke, in texels.
const ACROSS_PX: [u32; 2] = [16, 512];
/// Least and largest side of that tile along the stroke, in texels.
const ALONG_PX: [u32; 2] = [64, 2048];

impl Recipe {
    /// Loads one of [`names`], or a file (`.toml`, or `.png` for a picture of a stroke) whose path is relative to
    /// `folder`.
    ///
    /// # Errors
    /// [`StyleError`] with the file's name.
    pub fn load(name: &str, folder: &Path) -> Result<Self, StyleError> {
        let file = RECIPES.file(name, folder);
        let recipe = match file.as_ref().filter(|path| has_ending(path, "png")) {
            Some(path) => {
                let image = toml_edit::Value::from(path.display().to_string());
                Self::parse("of-picture.toml", &format!("image = {image}\n{OF_PICTURE}"))?
            }
            None => {
                let (shown, text) = RECIPES.text(name, folder)?;
                let mut recipe = Self::parse(&shown, &text)?;
                let own_folder = file.as_ref().and_then(|path| path.parent()).unwrap_or(Path::new(""));
                recipe.image = recipe.image.map(|image| own_folder.join(image));
                recipe
            }
        };
        recipe.with_picture()
    }

    /// Parses a recipe, without loading its image; errors begin with `name`.
    ///
    /// # Errors
    /// [`StyleError::Parse`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        Ok(parameters::read(name, text)?)
    }

    /// Returns the recipe with its image loaded. The image is relative to the working folder.
    ///
    /// # Errors
    /// [`StyleError::Image`].
    pub(super) fn with_picture(mut self) -> Result<Self, StyleError> {
        self.picture = self.image.as_deref().map(picture::read).transpose()?.map(Arc::new);
        Ok(self)
    }

    /// Returns the recipe for strokes of a width: a picture fills this width, and its tile has two texels for a pixel.
    pub(super) fn for_width(mut self, width_px: f32) -> Self {
        let Some(picture) = &self.picture else { return self };
        self.touch.nominal_width_px = width_px.clamp(1.0, 64.0);
        let across_px = 2.0 * self.touch.nominal_width_px;
        let side =
            |length_px: f32, [least, most]: [u32; 2]| (length_px.ceil() as u32).clamp(least, most).next_power_of_two();
        self.tile.across_px = side(across_px, ACROSS_PX);
        self.tile.along_px = side(across_px * picture.length_to_width(), ALONG_PX);
        self
    }
}

/// Returns whether a file name ends with `.` and `ending`, in capital letters or not.
fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending))
}
