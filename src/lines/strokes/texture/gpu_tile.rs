//! A stroke texture on the GPU: its tile with mip levels, its sampler, and the numbers of its rule.

use std::sync::Arc;

use super::{Brush, grow};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, TextureName};
use crate::style::texture::Recipe;

/// The tile of a stroke texture.
const TEXTURE: TextureName = TextureName {
    name: "stroke texture",
    content: Group::Strokes.shows("Tile of the stroke texture: pigment, and the pressure at which it takes ink"),
};

/// Pigment and threshold.
pub const TILE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg8Unorm;

/// A recipe's tile on the GPU.
pub struct StrokeTexture {
    recipe: Recipe,
    brush: GrowingBuffer,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

impl StrokeTexture {
    /// Returns the texture of a recipe, which is cached; `None` while it grows in the background.
    pub fn of(recorder: &mut Recorder<'_>, recipe: &Recipe) -> Option<Arc<Self>> {
        let made_of = recipe.clone();
        recorder.cached_in_background(|texture: &Self| texture.is_of(recipe), move |gpu| Self::new(gpu, &made_of))
    }

    /// Grows the tile and uploads it.
    pub fn new(gpu: &Gpu, recipe: &Recipe) -> Self {
        let levels = grow(recipe);
        let [width, height] = levels[0].size_px;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("stroke texture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TILE_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        for (level, mip_level) in levels.iter().zip(0..) {
            let [width, height] = level.size_px;
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(&level.texels),
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(2 * width), rows_per_image: Some(height) },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("stroke texture"),
            // The tile repeats across too: the rule makes the border, so a wide stroke shows several tiles.
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let mut brush = GrowingBuffer::new(gpu, "brush", wgpu::BufferUsages::UNIFORM);
        brush.write(gpu, &[Brush::of(recipe)]);
        Self { recipe: recipe.clone(), brush, texture, view, sampler }
    }

    /// Returns whether this is the texture of `recipe`.
    pub fn is_of(&self, recipe: &Recipe) -> bool {
        self.recipe == *recipe
    }

    /// Returns the bindings of the shader.
    pub fn resources(&self) -> [Named; 3] {
        [
            ("brush", self.brush.binding()),
            ("brush_tile", Resource::Texture(TEXTURE, self.view.clone())),
            ("brush_sampler", Resource::Sampler(self.sampler.clone())),
        ]
    }

    /// Returns the tile, for measurements.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }
}
