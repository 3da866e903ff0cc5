//! Readback of pictures of ink, in any of their formats.

use crate::gpu::readback::read_as;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError};

/// Reads back the texels of a part of a picture of ink. A picture has up to four channels; absent ones are 0.
///
/// # Errors
/// [`GpuError::Readback`] if the device is lost or out of memory, or if the picture has a format that no ink has.
pub(super) fn channels(
    gpu: &Gpu,
    target: &Target,
    origin_px: [u32; 2],
    size_px: [u32; 2],
) -> Result<Vec<[f32; 4]>, GpuError> {
    use wgpu::TextureFormat::{R16Float, R32Float, Rg32Float, Rgba16Float, Rgba32Float};
    let half = |bits: u16| half::f16::from_bits(bits).to_f32();
    match target.texture.format() {
        R16Float => Ok(padded(&read_as::<[u16; 1]>(gpu, target, origin_px, size_px)?, half)),
        Rgba16Float => Ok(padded(&read_as::<[u16; 4]>(gpu, target, origin_px, size_px)?, half)),
        R32Float => Ok(padded(&read_as::<[f32; 1]>(gpu, target, origin_px, size_px)?, |value| value)),
        Rg32Float => Ok(padded(&read_as::<[f32; 2]>(gpu, target, origin_px, size_px)?, |value| value)),
        Rgba32Float => Ok(padded(&read_as::<[f32; 4]>(gpu, target, origin_px, size_px)?, |value| value)),
        format => Err(GpuError::Readback(format!("{}: no ink has the format {format:?}", target.name))),
    }
}

/// Converts texels to four channels; absent channels are 0.
fn padded<T: Copy, const N: usize>(texels: &[[T; N]], value: impl Fn(T) -> f32) -> Vec<[f32; 4]> {
    let channel = |texel: &[T; N], i: usize| texel.get(i).map_or(0.0, |channel| value(*channel));
    texels.iter().map(|texel| std::array::from_fn(|i| channel(texel, i))).collect()
}
