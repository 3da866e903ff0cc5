//! Where a style finds the recipes that it names.

use std::path::Path;

use crate::style::held::StyleFiles;
use crate::style::{StyleError, marks, texture};

/// The source of a style's recipes.
#[derive(Clone, Copy)]
pub(crate) enum RecipeSource<'a> {
    /// Built-in recipes, and files relative to a folder.
    Folder(&'a Path),
    /// Built-in recipes, and recipes that are embedded as text in a picture.
    Embedded(&'a StyleFiles),
}

impl RecipeSource<'_> {
    /// Returns the recipe of hatching marks with this name.
    pub(super) fn marks(self, name: &str) -> Result<marks::Recipe, StyleError> {
        let here = Path::new("");
        match self {
            Self::Folder(folder) => marks::Recipe::load(name, folder),
            Self::Embedded(files) => match files.marks.get(name) {
                Some(text) => marks::Recipe::parse(name, text),
                None if marks::file(name, here).is_none() => marks::Recipe::load(name, here),
                None => Err(StyleError::UnknownMarks { name: name.to_owned() }),
            },
        }
    }

    /// Returns the stroke texture with this name, if there is a name, for strokes of a width.
    pub(in crate::style) fn texture(
        self,
        name: Option<&str>,
        width_px: f32,
    ) -> Result<Option<texture::Recipe>, StyleError> {
        let Some(name) = name else { return Ok(None) };
        let here = Path::new("");
        match self {
            Self::Folder(folder) => texture::Recipe::load(name, folder),
            Self::Embedded(files) => match files.textures.get(name) {
                Some(text) => texture::Recipe::parse(name, text)?.with_picture(),
                None if texture::file(name, here).is_none() => texture::Recipe::load(name, here),
                None => Err(StyleError::UnknownTexture { name: name.to_owned() }),
            },
        }
        .map(|recipe| Some(recipe.for_width(width_px)))
    }
}
