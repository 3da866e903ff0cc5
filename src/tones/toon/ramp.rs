//! The colour table of a toon style: the tone across, the attribute down.

use crate::gpu::Gpu;
use crate::style::{Attribute, Ramp, Stop};

/// Texels across: steps of the tone.
const TONES: usize = 256;
/// Texels down: steps of the attribute.
const ROWS: usize = 128;

/// A ramp on the GPU.
pub(super) struct RampTable {
    ramp: Option<Ramp>,
    pub view: wgpu::TextureView,
    /// Row of an attribute: row = first number + second number × attribute.
    pub row_px: [f32; 2],
    /// The attribute, numbered as in the shader: 0 height, 1 slope, 2 distance.
    pub by: u32,
}

/// Returns the interpolated colour of a list at `place`, 0 to 1.
fn between(colors: &[[f32; 3]], place: f32) -> [f32; 3] {
    let at = place.clamp(0.0, 1.0) * (colors.len() - 1) as f32;
    let first = (at as usize).min(colors.len() - 1);
    let next = (first + 1).min(colors.len() - 1);
    let t = at - first as f32;
    std::array::from_fn(|i| colors[first][i] + (colors[next][i] - colors[first][i]) * t)
}

fn linear(stop: &Stop) -> Vec<[f32; 3]> {
    stop.colors.iter().map(|color| color.linear()).collect()
}

/// Returns the colour of a tone at an attribute.
fn color_at(stops: &[(f32, Vec<[f32; 3]>)], attribute: f32, tone: f32) -> [f32; 3] {
    let after = stops.partition_point(|(at, _)| *at <= attribute);
    let (low, high) = (after.saturating_sub(1), after.min(stops.len() - 1));
    let span = stops[high].0 - stops[low].0;
    let t = if span > 0.0 { ((attribute - stops[low].0) / span).clamp(0.0, 1.0) } else { 0.0 };
    let (a, b) = (between(&stops[low].1, tone), between(&stops[high].1, tone));
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

impl RampTable {
    /// Creates the table of a ramp; `None` gives greys.
    pub(super) fn new(gpu: &Gpu, ramp: Option<&Ramp>) -> Self {
        let greys = || vec![(0.0, vec![[0.0; 3], [1.0; 3]])];
        let stops = ramp.map_or_else(greys, |ramp| ramp.stops.iter().map(|stop| (stop.at, linear(stop))).collect());
        let rows = if stops.len() > 1 { ROWS } else { 1 };
        let (first, last) = (stops[0].0, stops[stops.len() - 1].0);
        let scale = if rows > 1 { (rows - 1) as f32 / (last - first) } else { 0.0 };
        let mut texels = Vec::with_capacity(rows * TONES);
        for row in 0..rows {
            let attribute = if rows > 1 { first + row as f32 / scale } else { first };
            for tone in 0..TONES {
                let [r, g, b] = color_at(&stops, attribute, tone as f32 / (TONES - 1) as f32);
                texels.push([r, g, b, 1.0].map(|value| half::f16::from_f32(value).to_bits()));
            }
        }
        let size = wgpu::Extent3d { width: TONES as u32, height: rows as u32, depth_or_array_layers: 1 };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("ramp"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        gpu.queue.write_texture(
            texture.as_image_copy(),
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * size.width), rows_per_image: None },
            size,
        );
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let by = match ramp.map(|ramp| ramp.by) {
            Some(Attribute::Height) => 0,
            Some(Attribute::Slope) => 1,
            Some(Attribute::Distance) | None => 2,
        };
        Self { ramp: ramp.cloned(), view, row_px: [-first * scale, scale], by }
    }

    /// Returns whether this is the table of `ramp`.
    pub(super) fn is_of(&self, ramp: Option<&Ramp>) -> bool {
        self.ramp.as_ref() == ramp
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]
    use super::*;

    #[test]
    fn colors_lie_between_their_neighbours() {
        let stops = [(10.0, vec![[0.0; 3], [1.0, 0.0, 0.0]]), (20.0, vec![[0.0, 0.0, 1.0]])];
        assert_eq!(color_at(&stops, 0.0, 1.0), [1.0, 0.0, 0.0]);
        assert_eq!(color_at(&stops, 10.0, 0.5), [0.5, 0.0, 0.0]);
        assert_eq!(color_at(&stops, 15.0, 1.0), [0.5, 0.0, 0.5]);
        assert_eq!(color_at(&stops, 99.0, 0.1), [0.0, 0.0, 1.0]);
    }
}
