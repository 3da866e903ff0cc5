//! Whether a picture shows anything: a camera may look at the sky or at no-data, and a style may draw nothing on what
//! it sees.

use super::Band;
use crate::frame::Renderer;
use crate::gpu::{Gpu, GpuError};
use crate::style::color::srgb_from_linear;
use crate::surface::id::Kind;

/// Range of lightness, 0 to 1 in sRGB, up to which a picture is nearly blank: more than the grain of paper.
const PALE: f32 = 0.1;

/// The contents of the parts of a picture that were looked at so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Whether any pixel shows a surface.
    pub surface: bool,
    /// Darkest and lightest pixel, 0 to 1 in sRGB.
    range: [f32; 2],
}

impl Seen {
    pub(super) const NOTHING: Self = Self { surface: false, range: [f32::INFINITY, f32::NEG_INFINITY] };

    /// Looks for a surface in the part that was drawn last, unless one has been found.
    pub(super) fn look(&mut self, gpu: &Gpu, renderer: &Renderer) -> Result<(), GpuError> {
        if !self.surface {
            self.surface = shows_surface(gpu, renderer)?;
        }
        Ok(())
    }

    /// Adds the pixels of a band.
    pub(super) fn add(&mut self, band: &Band) {
        for [red, green, blue, _] in &band.picture {
            if !self.is_pale() && self.range[1] > 0.0 {
                return;
            }
            let lightness = srgb_from_linear((0.2126 * red + 0.7152 * green + 0.0722 * blue).clamp(0.0, 1.0));
            self.range = [self.range[0].min(lightness), self.range[1].max(lightness)];
        }
    }

    /// Returns whether no pixel differs much from another.
    pub(super) fn is_pale(&self) -> bool {
        self.range[1] - self.range[0] <= PALE
    }
}

/// Returns whether any pixel of the first eye's last frame shows a surface.
///
/// # Errors
/// [`GpuError::Readback`] when the device is lost or out of memory.
pub(super) fn shows_surface(gpu: &Gpu, renderer: &Renderer) -> Result<bool, GpuError> {
    let [width, height] = renderer.size_px();
    let is_seen = |origin_px, size_px| {
        let kinds = renderer.kinds(gpu, 0, origin_px, size_px)?;
        Ok::<_, GpuError>(kinds.is_none_or(|kinds| kinds.iter().any(|kind| *kind != Kind::Sky)))
    };
    // Most pictures show land in a row below the middle.
    let row = (height * 3 / 4).min(height.saturating_sub(1));
    Ok(is_seen([0, row], [width, 1])? || is_seen([0, 0], [width, height])?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grain_is_pale_and_a_line_is_not() {
        let band = |picture: Vec<[f32; 4]>| Band { first_row: 0, rows: 1, picture, planes: Vec::new() };
        let paper = |i: u32| [0.85 + 0.01 * (i % 7) as f32; 4];
        let mut seen = Seen::NOTHING;
        seen.add(&band((0..100).map(paper).collect()));
        assert!(seen.is_pale(), "{seen:?}");
        seen.add(&band(vec![[0.5, 0.5, 0.5, 1.0]]));
        assert!(!seen.is_pale(), "{seen:?}");
    }
}
