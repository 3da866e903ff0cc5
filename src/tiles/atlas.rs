//! Tiles of heights on the GPU: one texture array whose layers are slots, and who is in which.

use std::collections::HashMap;

use crate::gpu::Gpu;
use crate::pyramid::{TILE_SAMPLES, Tile, TileAddress};

/// Samples on each side of a tile that belong to its neighbours: what the bicubic kernel reaches for.
pub const TILE_BORDER: u32 = 2;
const SIDE: u32 = TILE_SAMPLES + 2 * TILE_BORDER;
/// Heights in metres; the lowest bit of a sample says whether it is void.
pub const HEIGHTS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// Bytes of one slot.
pub const SLOT_BYTES: u64 = SIDE as u64 * SIDE as u64 * 4;

/// The slots.
pub struct Atlas {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    slots: u32,
    used: HashMap<TileAddress, Slot>,
    free: Vec<u32>,
    evicted: u64,
}

#[derive(Clone, Copy)]
struct Slot {
    index: u32,
    last_wanted: u64,
}

impl Atlas {
    /// Room for `tiles` tiles, or as many as fit in `memory_bytes` and the device's limits.
    pub fn new(gpu: &Gpu, tiles: u64, memory_bytes: u64) -> Self {
        let limits = gpu.device.limits();
        let slots = tiles
            .min(memory_bytes / SLOT_BYTES)
            .min(u64::from(limits.max_texture_array_layers))
            .min(limits.max_buffer_size / SLOT_BYTES)
            .max(1) as u32;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tile atlas"),
            // A texture of one layer would not be an array.
            size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: slots },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: HEIGHTS_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { texture, view, slots, used: HashMap::new(), free: (0..slots).rev().collect(), evicted: 0 }
    }

    /// For bindings.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// How many tiles fit.
    pub fn slots(&self) -> u32 {
        self.slots
    }

    /// The slot of a tile that is there.
    pub fn slot(&self, tile: TileAddress) -> Option<u32> {
        self.used.get(&tile).map(|slot| slot.index)
    }

    /// Tells that a tile is wanted in frame `frame`; whether it is there.
    pub fn want(&mut self, tile: TileAddress, frame: u64) -> bool {
        self.used.get_mut(&tile).map(|slot| slot.last_wanted = frame).is_some()
    }

    /// Puts a tile into a free slot, or in the place of the one that has not been wanted for longest. False when every
    /// slot holds a tile that frame `frame` wants.
    pub fn insert(&mut self, gpu: &Gpu, address: TileAddress, tile: &Tile, frame: u64) -> bool {
        let Some(index) = self.free.pop().or_else(|| self.evict(frame)) else { return false };
        self.used.insert(address, Slot { index, last_wanted: frame });
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: 0, z: index },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(&tile.samples),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIDE * 4), rows_per_image: Some(SIDE) },
            wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
        );
        true
    }

    /// Tiles there.
    pub fn len(&self) -> usize {
        self.used.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.used.is_empty()
    }

    /// Tiles that made room for others so far.
    pub fn evicted(&self) -> u64 {
        self.evicted
    }

    /// Bytes on the GPU.
    pub fn bytes(&self) -> u64 {
        u64::from(self.slots) * SLOT_BYTES
    }

    fn evict(&mut self, frame: u64) -> Option<u32> {
        let (&address, &slot) = self.used.iter().min_by_key(|(address, slot)| (slot.last_wanted, **address))?;
        if slot.last_wanted == frame {
            return None;
        }
        self.used.remove(&address);
        self.evicted += 1;
        Some(slot.index)
    }
}
