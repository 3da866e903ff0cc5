//! The colours that trees and models have of their own (painters' local colours), as styles with colours take them.
//!
//! A style that asks for them ([`Style::asks_for_local_colors`](crate::style::Style::asks_for_local_colors)) has a
//! picture of them, which those who draw trees and models write beside the normal; no other style has the picture or
//! anything that fills it. It holds hues: how light a place is says the lightness that the normal has, in all styles.
//!
//! Why: `docs/decisions/forests.md`.

use crate::gpu::target::TargetKind;

/// As it is drawn on: of all attachments of trees it is the one for which four bytes are left.
pub(super) const LOCAL_COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// [`packed`], where the surface id says that there is a tree or a model; elsewhere it means nothing.
pub const LOCAL_COLOR: TargetKind = TargetKind {
    name: "local color",
    format: LOCAL_COLOR_FORMAT,
    usage: wgpu::TextureUsages::STORAGE_BINDING.union(wgpu::TextureUsages::RENDER_ATTACHMENT),
};

/// The hue of a colour in linear light, as `shaders/shared/local_color.wgsl` reads it: in 8 bits each the roots of red,
/// green and blue, of which the greatest is 1, and 255. Black is grey to it.
pub fn packed(color: [f32; 3]) -> u32 {
    let most = color.into_iter().fold(0.0, f32::max);
    let channel =
        |value: f32| if most > 0.0 { (255.0 * (value / most).clamp(0.0, 1.0).sqrt()).round() as u8 } else { 255 };
    let [red, green, blue] = color.map(channel);
    u32::from_le_bytes([red, green, blue, 255])
}

/// What has no colour of its own: it is coloured as the land.
pub const NONE: u32 = 0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hues_are_packed_without_their_lightness() {
        assert_eq!(packed([1.0, 0.25, 0.0]).to_le_bytes(), [255, 128, 0, 255]);
        assert_eq!(packed([0.1, 0.025, 0.0]), packed([1.0, 0.25, 0.0]), "it is as light as it is elsewhere");
        assert_eq!(packed([0.0; 3]), packed([1.0; 3]));
        // Planted: another hue, and none.
        assert!(packed([0.25, 1.0, 0.0]) != packed([1.0, 0.25, 0.0]) && packed([0.0; 3]) != NONE);
    }
}
