//! Tones from pictures of the surface: how light each place is, and its colour before lines and haze; and the marks
//! that tones are hatched with.

pub mod balance;
pub mod fractal_hatching;
pub mod hatching;
pub mod light;
pub mod plain;
pub mod tonal_art_map;
pub mod toon;
pub mod watercolor;

use crate::gpu::target::TargetKind;

/// rgb: linear colour; a: the tone asked for, 0 black to 1 white.
pub const TONE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Colour before lines and haze, and the tone that is asked for.
pub const TONE: TargetKind = TargetKind::storage("tone", TONE_FORMAT);
