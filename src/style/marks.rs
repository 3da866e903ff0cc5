//! Marks: what a tone is hatched with. A recipe is TOML; the tonal art map is made from it
//! (`tones/tonal_art_map`). Thirteen come with the program, and a style may name a file of its own, which may in turn name
//! pictures that somebody drew.

pub(crate) mod pictures;

use std::path::{Path, PathBuf};

use super::StyleError;
use super::parameters::{self, Range, choices, parameters};
use super::recipes::Recipes;
use crate::file::toml_text::Wrong;

pub use pictures::check as check_pictures;

/// The recipes that come with the program, by name.
const RECIPES: Recipes = Recipes {
    built_in: &[
        ("line", include_str!("../../textures/marks/line.toml")),
        ("dash", include_str!("../../textures/marks/dash.toml")),
        ("hachure", include_str!("../../textures/marks/hachure.toml")),
        ("stipple", include_str!("../../textures/marks/stipple.toml")),
        ("dots", include_str!("../../textures/marks/dots.toml")),
        ("cross", include_str!("../../textures/marks/cross.toml")),
        ("scribble", include_str!("../../textures/marks/scribble.toml")),
        ("dab", include_str!("../../textures/marks/dab.toml")),
        ("halftone", include_str!("../../textures/marks/halftone.toml")),
        ("charcoal", include_str!("../../textures/marks/charcoal.toml")),
        ("pencil", include_str!("../../textures/marks/pencil.toml")),
        ("dry-brush", include_str!("../../textures/marks/dry-brush.toml")),
        ("engraving", include_str!("../../textures/marks/engraving.toml")),
    ],
    unknown: |name| StyleError::UnknownMarks { name },
    unreadable: |path, source| StyleError::ReadMarks { path, source },
};

/// Sides that a tile may have: powers of two between these.
pub const SIDES_PX: [u32; 2] = [64, 1024];

/// Pictures of a stack, at most.
const MOST_IMAGES: usize = 32;

choices! {
    /// What the marks are.
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
        /// Round dots of one size; by `scale = "add"` each keeps its distance from all others.
        Dots,
        /// Pictures that somebody drew.
        Stack,
    }
}

impl Kind {
    /// Whether marks are as long as wide.
    pub fn is_of_dots(self) -> bool {
        matches!(self, Self::Stipple | Self::Halftone | Self::Dots)
    }
}

parameters! {
    /// How a tonal art map is made. Everything that has no unit is a part of something, 0 to 1.
    ///
    /// *Mid tone* is the darkness at which marks of `width_px` stand `spacing_px` apart: [`Recipe::mid_darkness`].
    pub struct Recipe, whole Recipe::fits {
        /// What the marks are, in a line.
        description: String;
        /// Kind of the marks.
        kind: Kind;
        /// Of a stack: 1 to 32 pictures (PNG) from light to dark, beside the recipe.
        images: Vec<PathBuf> = Vec::new();
        /// Side of the square that repeats; pictures have their own.
        side_px: u32 = 512 => Range::PowerOfTwo(SIDES_PX[0], SIDES_PX[1]);
        /// Another number gives another tile of the same kind.
        seed: u32 = 0;
        /// Length of a mark; lines have none, nor have dots.
        length_px: f32 = 36.0 => Range::Within(1.0, 400.0);
        /// Mean width of a mark at mid tone.
        width_px: f32 = 2.0 => Range::Within(1.0, 32.0);
        /// Mean distance across marks, from middle to middle, at mid tone.
        spacing_px: f32 = 8.0 => Range::Within(2.0, 64.0);
        /// How far the hand wanders to the sides, slowly.
        wobble_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Part of a mark's length over which it thins at its ends.
        taper: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How irregularly marks are placed.
        jitter: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much of the darkening comes from marks that widen rather than from more marks; 1 is an engraver's line.
        swell: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much pressure, and so width, differs from mark to mark and along a mark.
        pressure: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much the paper's tooth breaks marks up.
        grain: f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

/// The names of the recipes that come with the program.
pub fn names() -> Vec<&'static str> {
    RECIPES.names()
}

/// The file that a name of marks means, from `folder` on; none for those that come with the program.
pub(super) fn file(name: &str, folder: &Path) -> Option<PathBuf> {
    RECIPES.file(name, folder)
}

impl Recipe {
    /// One of [`names`], or a file (`.toml`), whose path is taken from `folder`.
    ///
    /// # Errors
    /// [`StyleError`] with the file's name.
    pub fn load(name: &str, folder: &Path) -> Result<Self, StyleError> {
        let (shown, text) = RECIPES.text(name, folder)?;
        let mut recipe = Self::parse(&shown, &text)?;
        if let Some(path) = RECIPES.file(name, folder) {
            let beside = path.parent().unwrap_or(Path::new(""));
            recipe.images.iter_mut().for_each(|image| *image = beside.join(&*image));
        }
        Ok(recipe)
    }

    /// A recipe from its text; `name` is for errors.
    ///
    /// # Errors
    /// [`StyleError::Parse`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        Ok(parameters::read(name, text)?)
    }

    /// The darkness at which marks have their width and their spacing, were none to lie on another.
    pub fn mid_darkness(&self) -> f32 {
        let part = self.width_px / self.spacing_px;
        match self.kind {
            // Round dots, apart in both directions.
            Kind::Stipple | Kind::Dots => std::f32::consts::FRAC_PI_4 * part * part,
            Kind::Halftone | Kind::Stack => 0.5,
            _ => part,
        }
    }

    /// What must hold for several parameters together.
    fn fits(&self, _: &str) -> Result<(), Wrong> {
        let (is_stack, images) = (self.kind == Kind::Stack, self.images.len());
        if is_stack && !(1..=MOST_IMAGES).contains(&images) {
            return Err(Wrong::new("images", format!(" has {images} entries, not 1 to {MOST_IMAGES}")));
        }
        if !is_stack && images > 0 {
            return Err(Wrong::new("images", " are given, but kind is not \"stack\""));
        }
        let Self { width_px, spacing_px, .. } = self;
        // Denser marks would leave no paper at mid tone, so their spacing would not be seen.
        if *width_px > 0.9 * spacing_px {
            let words = format!(" is {width_px}, more than 9 tenths of spacing_px, which is {spacing_px}");
            return Err(Wrong::new("width_px", words));
        }
        Ok(())
    }
}
