//! The `[curvature]` section of a style: contours and suggestive contours found by curvature.

use std::path::{Path, PathBuf};

use super::parameters::{Range, parameters};
use super::texture;

parameters! {
    /// Lines found by the curvature of the land (Pietrok 2021, section 4.1), for `detector = "curvature"` in `[lines]`.
    pub struct Curvature {
        /// Width of contours.
        width_px called "Contour width": f32 = 2.5 => Range::Within(0.5, 32.0);
        /// Smallest feature that counts: the land is smoothed to this size before its curvature is measured.
        feature_px called "Smallest feature": f32 = 8.0 => Range::Within(1.0, 256.0);
        /// Width of suggestive contours, as a fraction of the width of contours; 0 draws none.
        suggestive called "Suggestive width": f32 = 0.6 => Range::Within(0.0, 1.0), zero "none";
        /// Least increase of curvature toward the eye at a suggestive contour: turn of the normal over a feature, per
        /// feature.
        rise called "Suggestive threshold": f32 = 0.05 => Range::Within(0.0, 10.0);
        /// Suggestive contours are drawn only where the normal points away from the eye by more than this angle.
        facing_deg called "Suggestive angle": f32 = 35.0 => Range::Within(0.0, 90.0);
        /// Soft border of a line, as a fraction of half its width.
        taper called "Soft border": f32 = 0.3 => Range::Within(0.0, 1.0);
        /// Amplitude of a wave that displaces the lines sideways.
        warp_px called "Wave amplitude": f32 = 0.0 => Range::Within(0.0, 16.0);
        /// Wavelength of that wave along the line; whole waves fit in 4096 pixels, so it is rounded by up to 12 %.
        warp_length_px called "Wavelength": f32 = 40.0 => Range::Within(4.0, 1000.0);
        /// Stroke texture: a built-in name, a recipe (`.toml`) or a picture of a stroke (`.png`); without it lines are
        /// solid.
        texture_name as "texture" called "Stroke texture": Option<String>;
    } loaded {
        /// The loaded recipe of `texture_name`.
        texture: Option<texture::Recipe>;
    }
}

impl Curvature {
    /// Returns the files that the texture was read from; `folder` is the folder of the style.
    pub(super) fn files(&self, folder: &Path) -> Vec<PathBuf> {
        texture::files(self.texture_name.as_deref(), self.texture.as_ref(), folder)
    }
}
