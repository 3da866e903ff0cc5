//! The local colours of trees and models (a painter's term: their own colours), used by styles with colours.
//!
//! If a style needs them ([`Style::needs_local_colors`](crate::style::Style::needs_local_colors)), the passes
//! that draw trees and models write them to a target next to the normal; for other styles neither the target nor its
//! inputs exist. The target holds hues only: lightness is stored with the normal, in all styles.
//!
//! Why: `docs/decisions/forests.md`.

use crate::gpu::target::{Group, TargetKind};

/// A format of four bytes: the other colour attachments of trees leave no more of WebGPU's 32 bytes per sample.
pub(super) const LOCAL_COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// [`packed`] hues at pixels whose surface id is a tree or a model; undefined elsewhere.
pub(crate) const LOCAL_COLOR: TargetKind = TargetKind {
    name: "local color",
    content: Group::Surface.shows("Own hue of each tree and model, packed into a number"),
    format: LOCAL_COLOR_FORMAT,
    usage: wgpu::TextureUsages::STORAGE_BINDING.union(wgpu::TextureUsages::RENDER_ATTACHMENT),
};

/// Packs the hue of a linear colour as `shaders/shared/local_color.wgsl` reads it: 8 bits each for the square roots of
/// red, green and blue, scaled so that the largest is 1, and 255. Black is packed as grey.
pub(crate) fn packed(color: [f32; 3]) -> u32 {
    let most = color.into_iter().fold(0.0, f32::max);
    let channel =
        |value: f32| if most > 0.0 { (255.0 * (value / most).clamp(0.0, 1.0).sqrt()).round() as u8 } else { 255 };
    let [red, green, blue] = color.map(channel);
    u32::from_le_bytes([red, green, blue, 255])
}

/// The value of a surface without a local colour: it is coloured as the land is.
pub(crate) const NONE: u32 = 0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hues_are_packed_without_their_lightness() {
        assert_eq!(packed([1.0, 0.25, 0.0]).to_le_bytes(), [255, 128, 0, 255]);
        assert_eq!(packed([0.1, 0.025, 0.0]), packed([1.0, 0.25, 0.0]), "lightness is not packed");
        assert_eq!(packed([0.0; 3]), packed([1.0; 3]));
        // Planted errors: another hue, and a hue that equals `NONE`.
        assert!(packed([0.25, 1.0, 0.0]) != packed([1.0, 0.25, 0.0]) && packed([0.0; 3]) != NONE);
    }
}
