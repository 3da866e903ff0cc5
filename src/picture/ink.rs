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
    match target.texture.format() {
        R16Float => halves::<1>(gpu, target, origin_px, size_px),
        Rgba16Float => halves::<4>(gpu, target, origin_px, size_px),
        R32Float => floats::<1>(gpu, target, origin_px, size_px),
        Rg32Float => floats::<2>(gpu, target, origin_px, size_px),
        Rgba32Float => floats::<4>(gpu, target, origin_px, size_px),
        format => Err(GpuError::Readback(format!("{}: no ink has the format {format:?}", target.name))),
    }
}

fn floats<const N: usize>(
    gpu: &Gpu,
    target: &Target,
    origin_px: [u32; 2],
    size_px: [u32; 2],
) -> Result<Vec<[f32; 4]>, GpuError>
where
    [f32; N]: bytemuck::Pod,
{
    let texels: Vec<[f32; N]> = read_as(gpu, target, origin_px, size_px)?;
    Ok(texels.iter().map(|texel| padded(texel.iter().copied())).collect())
}

fn halves<const N: usize>(
    gpu: &Gpu,
    target: &Target,
    origin_px: [u32; 2],
    size_px: [u32; 2],
) -> Result<Vec<[f32; 4]>, GpuError>
where
    [u16; N]: bytemuck::Pod,
{
    let texels: Vec<[u16; N]> = read_as(gpu, target, origin_px, size_px)?;
    Ok(texels.iter().map(|texel| padded(texel.iter().map(|bits| half::f16::from_bits(*bits).to_f32()))).collect())
}

fn padded(channels: impl Iterator<Item = f32>) -> [f32; 4] {
    let mut texel = [0.0; 4];
    for (padded, channel) in texel.iter_mut().zip(channels) {
        *padded = channel;
    }
    texel
}
