//! Recipes of hatching marks. A recipe is a TOML file from which `tones/tonal_art_map` makes a tonal art map. Thirteen
//! recipes are built in. A style may also name a file of its own, which may in turn name hand-drawn images.

pub(crate) mod pictures;

use std::path::{Path, PathBuf};

use super::StyleError;
use super::parameters::{self, Range, choices, parameters};
use super::recipes::Recipes;
use crate::file::toml_text::Wrong;

pub(crate) use pictures::check as check_pictures;

/// The built-in recipes, by name.
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

/// Smallest and largest side of a tile in pixels; the side is a power of two.
pub(crate) const SIDES_PX: [u32; 2] = [64, 1024];

/// Largest number of images in a stack.
const MAX_IMAGES: usize = 32;

choices! {
    /// Kind of hatching marks.
    pub enum Kind {
        /// Lines across the whole tile.
        Line,
        /// Short strokes in one direction.
        Dash,
        /// Dots that do not touch each other.
        Stipple,
        /// Lines, crossed by a second set where it is dark.
        Cross,
        /// Curls of a pen that stays on the paper.
        Scribble,
        /// Dabs of a brush.
        Dab,
        /// Dots on a rotated grid that grow with darkness.
        Halftone,
        /// Round dots of one size; with `scale = "add"` each keeps its distance from all others.
        Dots,
        /// Hand-drawn images from light to dark.
        Stack,
    }
}

impl Kind {
    /// Returns whether the marks are dots, as long as they are wide.
    pub(crate) fn is_of_dots(self) -> bool {
        matches!(self, Self::Stipple | Self::Halftone | Self::Dots)
    }
}

parameters! {
    /// A recipe of hatching marks, from which a tonal art map is made. Values without a unit are fractions, 0 to 1.
    ///
    /// *Mid tone* is the darkness at which marks are `width_px` wide and `spacing_px` apart: [`Recipe::mid_darkness`].
    pub struct Recipe, whole Recipe::fits {
        /// One-line description of the marks.
        description: String;
        /// Kind of the marks.
        kind called "Kind of marks": Kind;
        /// Images of a stack: 1 to 32 PNG files from light to dark, relative to the recipe.
        images called "Images of stack": Vec<PathBuf> = Vec::new();
        /// Side of the square tile that repeats; a stack uses the size of its images instead.
        side_px called "Tile side": u32 = 512 => Range::PowerOfTwo(SIDES_PX[0], SIDES_PX[1]);
        /// Seed of the random placement; another number gives another tile of the same kind.
        seed: u32 = 0;
        /// Length of a mark; lines and dots ignore it.
        length_px called "Mark length": f32 = 36.0 => Range::Within(1.0, 400.0);
        /// Mean width of a mark at mid tone, at most 90 % of `spacing_px`.
        width_px called "Mark width": f32 = 2.0 => Range::Within(1.0, 32.0);
        /// Mean distance between the centre lines of neighbouring marks at mid tone.
        spacing_px called "Mark spacing": f32 = 8.0 => Range::Within(2.0, 64.0);
        /// How far a mark slowly wanders sideways, as if drawn by hand.
        wobble_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Fraction of a mark's length over which it tapers at its ends.
        taper: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Irregularity of the placement of marks.
        jitter called "Irregularity": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much of the darkening comes from wider marks instead of more marks; 1 gives an engraver's line.
        swell called "Darkening by width": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much pressure, and therefore width, varies between marks and along a mark.
        pressure called "Pressure variation": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much the tooth of the paper breaks up the marks.
        grain called "Paper grain": f32 = 0.0 => Range::Within(0.0, 1.0);
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
        let mut recipe = Self::parse(&shown, &text)?;
        if let Some(path) = RECIPES.file(name, folder) {
            let own_folder = path.parent().unwrap_or(Path::new(""));
            recipe.images.iter_mut().for_each(|image| *image = own_folder.join(&*image));
        }
        Ok(recipe)
    }

    /// Parses a recipe; errors begin with `name`.
    ///
    /// # Errors
    /// [`StyleError::Parse`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        Ok(parameters::read(name, text)?)
    }

    /// Returns the darkness, 0 to 1, at which marks have their width and their spacing, if none overlap.
    pub(crate) fn mid_darkness(&self) -> f32 {
        let part = self.width_px / self.spacing_px;
        match self.kind {
            // Round dots are spaced in both directions.
            Kind::Stipple | Kind::Dots => std::f32::consts::FRAC_PI_4 * part * part,
            Kind::Halftone | Kind::Stack => 0.5,
            _ => part,
        }
    }

    /// Checks the rules that combine several parameters.
    fn fits(&self, _: &str) -> Result<(), Wrong> {
        let (is_stack, images) = (self.kind == Kind::Stack, self.images.len());
        if is_stack && !(1..=MAX_IMAGES).contains(&images) {
            return Err(Wrong::new("images", format!(" has {images} entries, not 1 to {MAX_IMAGES}")));
        }
        if !is_stack && images > 0 {
            return Err(Wrong::new("images", " are given, but kind is not \"stack\""));
        }
        let Self { width_px, spacing_px, .. } = self;
        // Denser marks would leave no paper at mid tone, so their spacing would not be visible.
        if *width_px > 0.9 * spacing_px {
            let words = format!(" is {width_px}, more than 90 % of spacing_px, which is {spacing_px}");
            return Err(Wrong::new("width_px", words));
        }
        Ok(())
    }
}
