//! The `[image]` section of a style: what is made of images on the land.

use super::parameters::{Range, parameters};

parameters! {
    /// What is made of images on the land (`--drape`): colour, and darker tones.
    pub struct Image {
        /// How strongly the hues of images colour the tones; styles that draw no tones as colour show none.
        color called "Colour of images": f32 = 0.7 => Range::Within(0.0, 1.0);
        /// How much dark places of images darken the tone, which hatching, dots, cuts and steps then draw.
        tone called "Tone of images": f32 = 0.6 => Range::Within(0.0, 1.0);
        /// Contrast of the red channel, about its middle.
        contrast_red called "Contrast of red": f32 = 1.0 => Range::Within(0.0, 8.0);
        /// Contrast of the green channel, about its middle.
        contrast_green called "Contrast of green": f32 = 1.0 => Range::Within(0.0, 8.0);
        /// Contrast of the blue channel, about its middle.
        contrast_blue called "Contrast of blue": f32 = 1.0 => Range::Within(0.0, 8.0);
        /// Added to each channel of images; 1 makes them white.
        brightness called "Brightness of images": f32 = 0.0 => Range::Within(-1.0, 1.0);
    }
}

impl Image {
    /// Returns whether images change the drawing.
    pub(crate) fn is_used(&self) -> bool {
        self.color > 0.0 || self.tone > 0.0
    }
}
