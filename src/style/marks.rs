//! Marks: what a tone is hatched with. A recipe is TOML; the tonal art map is made from it
//! (`tones/tonal_art_map`). Ten come with the program, and a style may name a file of its own, which may in turn name
//! pictures that somebody drew.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::StyleError;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::toml_text;

/// The recipes that come with the program, by name.
const RECIPES: &[(&str, &str)] = &[
    ("line", include_str!("../../textures/marks/line.toml")),
    ("dash", include_str!("../../textures/marks/dash.toml")),
    ("hachure", include_str!("../../textures/marks/hachure.toml")),
    ("stipple", include_str!("../../textures/marks/stipple.toml")),
    ("cross", include_str!("../../textures/marks/cross.toml")),
    ("scribble", include_str!("../../textures/marks/scribble.toml")),
    ("dab", include_str!("../../textures/marks/dab.toml")),
    ("halftone", include_str!("../../textures/marks/halftone.toml")),
    ("pencil", include_str!("../../textures/marks/pencil.toml")),
    ("engraving", include_str!("../../textures/marks/engraving.toml")),
];

/// Sides that a tile may have: powers of two between these.
pub const SIDES_PX: [u32; 2] = [64, 1024];

/// Pictures of a stack, at most.
const MOST_IMAGES: usize = 32;

/// What the marks are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Lines that go through the whole tile.
    Line,
    /// Short strokes, all in one direction.
    Dash,
    /// Dots that stand apart.
    Stipple,
    /// Lines, and where it is dark others across them.
    Cross,
    /// Curls of a pen that is not lifted.
    Scribble,
    /// Touches of a brush.
    Dab,
    /// Dots on a turned grid, which grow.
    Halftone,
    /// Pictures that somebody drew.
    Stack,
}

/// How a tonal art map is made. Everything that has no unit is a part of something, 0 to 1.
///
/// *Mid tone* is the darkness at which marks of `width_px` stand `spacing_px` apart: [`Recipe::mid_darkness`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// In a line.
    pub description: String,
    /// What the marks are.
    pub kind: Kind,
    /// Of a stack: the pictures (PNG) from light to dark; from files, with the folder of the recipe before them.
    #[serde(default)]
    pub images: Vec<PathBuf>,
    /// The piece that repeats is a square of so many pixels, a power of two. Pictures have their own.
    #[serde(default = "side_px")]
    pub side_px: u32,
    /// Another one gives another tile of the same kind.
    #[serde(default)]
    pub seed: u32,
    /// Length of a mark, 1 to 400. Lines have none, nor have dots.
    #[serde(default = "length_px")]
    pub length_px: f32,
    /// Mean width of a mark at mid tone, 1 to 32.
    #[serde(default = "width_px")]
    pub width_px: f32,
    /// Mean distance across marks, from middle to middle, at mid tone: 2 to 64, and more than the width.
    #[serde(default = "spacing_px")]
    pub spacing_px: f32,
    /// How far the hand wanders to the sides, slowly, 0 to 16.
    #[serde(default)]
    pub wobble_px: f32,
    /// Part of a mark's length over which it thins at its ends.
    #[serde(default)]
    pub taper: f32,
    /// How irregularly marks are placed.
    #[serde(default)]
    pub jitter: f32,
    /// How much of the darkening comes from marks that widen rather than from more marks; 1 is an engraver's line.
    #[serde(default)]
    pub swell: f32,
    /// How much pressure, and so width, differs from mark to mark and along a mark.
    #[serde(default)]
    pub pressure: f32,
    /// How much the paper's tooth breaks marks up.
    #[serde(default)]
    pub grain: f32,
}

fn side_px() -> u32 {
    512
}

fn length_px() -> f32 {
    36.0
}

fn width_px() -> f32 {
    2.0
}

fn spacing_px() -> f32 {
    8.0
}

/// The names of the recipes that come with the program.
pub fn names() -> Vec<&'static str> {
    RECIPES.iter().map(|(name, _)| *name).collect()
}

/// The file that a name of marks means, from `folder` on; none for those that come with the program.
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
            return Err(StyleError::UnknownMarks { name: name.to_owned() });
        }
        let path = folder.join(name);
        let shown = path.display().to_string();
        let text = read_text(&path, LARGEST_STYLE_BYTES)
            .map_err(|source| StyleError::ReadMarks { path: shown.clone(), source })?;
        let mut recipe = Self::parse(&shown, &text)?;
        let beside = path.parent().unwrap_or(Path::new(""));
        recipe.images.iter_mut().for_each(|image| *image = beside.join(&*image));
        Ok(recipe)
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

    /// The darkness at which marks have their width and their spacing, were none to lie on another.
    pub fn mid_darkness(&self) -> f32 {
        let part = self.width_px / self.spacing_px;
        match self.kind {
            // Round dots, apart in both directions.
            Kind::Stipple => std::f32::consts::FRAC_PI_4 * part * part,
            Kind::Halftone | Kind::Stack => 0.5,
            _ => part,
        }
    }

    fn check(&self) -> Result<(), String> {
        let [least, most] = SIDES_PX;
        if !self.side_px.is_power_of_two() || !(least..=most).contains(&self.side_px) {
            return Err(format!("side_px is {}, not a power of two from {least} to {most}", self.side_px));
        }
        let (is_stack, images) = (self.kind == Kind::Stack, self.images.len());
        if is_stack && !(1..=MOST_IMAGES).contains(&images) {
            return Err(format!("images has {images} entries, not 1 to {MOST_IMAGES}"));
        }
        if !is_stack && images > 0 {
            return Err("images are given, but kind is not \"stack\"".to_owned());
        }
        let numbers = [
            ("length_px", self.length_px, 1.0, 400.0),
            ("width_px", self.width_px, 1.0, 32.0),
            ("spacing_px", self.spacing_px, 2.0, 64.0),
            ("wobble_px", self.wobble_px, 0.0, 16.0),
            ("taper", self.taper, 0.0, 1.0),
            ("jitter", self.jitter, 0.0, 1.0),
            ("swell", self.swell, 0.0, 1.0),
            ("pressure", self.pressure, 0.0, 1.0),
            ("grain", self.grain, 0.0, 1.0),
        ];
        if let Some((what, value, low, high)) =
            numbers.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value))
        {
            return Err(format!("{what} is {value}, not between {low} and {high}"));
        }
        // Denser marks would leave no paper at mid tone, so their spacing would not be seen.
        if self.width_px > 0.9 * self.spacing_px {
            return Err(format!(
                "width_px is {}, more than 9 tenths of spacing_px, which is {}",
                self.width_px, self.spacing_px
            ));
        }
        Ok(())
    }
}
