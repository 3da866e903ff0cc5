//! Lines by curvature of a style.

use super::parameters::{Range, parameters};

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
    }
}
