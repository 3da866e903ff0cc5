//! Lines by curvature of a style.

use std::path::{Path, PathBuf};

use super::parameters::{Range, parameters};
use super::{StyleError, texture};

parameters! {
    /// Lines by the land's curvature (Pietrok 2021, section 4.1), for `detector = "curvature"` of the lines.
    pub struct Curvature {
        /// Width of contours.
        width_px: f32 = 2.5 => Range::Within(0.5, 32.0);
        /// Size of a feature: the land bends as its form at this scale.
        feature_px: f32 = 8.0 => Range::Within(1.0, 256.0);
        /// Width of suggestive contours, as a part of that of contours; 0 draws none.
        suggestive: f32 = 0.6 => Range::Within(0.0, 1.0);
        /// How fast curvature rises toward the eye at a suggestive contour, at least: by turns of the normal, over a feature.
        rise: f32 = 0.05 => Range::Within(0.0, 10.0);
        /// Land that faces the eye by less than this from face on has no suggestive contours.
        facing_deg: f32 = 35.0 => Range::Within(0.0, 90.0);
        /// Which part of a line's width is a soft border.
        taper: f32 = 0.3 => Range::Within(0.0, 1.0);
        /// How far lines swing to and fro.
        warp_px: f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Length of a swing.
        warp_length_px: f32 = 40.0 => Range::Within(4.0, 1000.0);
        /// What lines are drawn with: a texture of the program, or a recipe beside the style (`.toml`); without it they are
        /// solid.
        texture_name as "texture": Option<String>;
    } beside {
        /// What `texture_name` means.
        texture: Option<texture::Recipe>;
    }
}

impl Curvature {
    /// Loads the texture; a file lies in `folder`.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        self.texture = texture::named(self.texture_name.as_deref(), folder)?;
        Ok(())
    }

    /// The file that the texture is read from, if the style's lies in `folder`.
    pub(super) fn file(&self, folder: &Path) -> Option<PathBuf> {
        self.texture_name.as_ref().and_then(|name| texture::file(name, folder))
    }
}
