//! Tiles of heights on the GPU: one texture array whose layers are slots, and the tile in each slot.

use std::cell::Cell;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::gpu::Gpu;
use crate::gpu::upload_ring::UploadRing;
use crate::pyramid::surface::occluder_minima::OccluderMinima;
use crate::pyramid::surface::statistics::{PatchPage, TileStatistics};
use crate::pyramid::tile::TILE_STRIDE;
use crate::pyramid::{LoadedTile, TileAddress};

/// Format of heights in metres; the lowest bit of a sample is set for no-data.
pub(crate) const HEIGHTS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// Size of a slot in bytes.
pub(crate) const SLOT_BYTES: u64 = TILE_STRIDE as u64 * TILE_STRIDE as u64 * 4;

/// A tile on the GPU, with its statistics.
pub(crate) struct Resident {
    /// The layer of the texture that contains its heights.
    pub slot: u32,
    /// Height range, errors and no-data of the tile.
    pub statistics: TileStatistics,
    /// Height range, mesh error and no-data of the mesh patches of the tile's page.
    pub patches: PatchPage,
    /// Lower bounds of the tile's land, by blocks, for occlusion culling.
    pub occluder_minima: Arc<OccluderMinima>,
    /// Time of arrival on the GPU, in seconds of the terrain's clock.
    pub arrived_s: f64,
    last_wanted: Cell<u64>,
}

/// The tiles on the GPU: a texture array, and the tile in each of its layers.
pub(crate) struct Atlas {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    ring: UploadRing,
    slots: u32,
    used: FxHashMap<TileAddress, Resident>,
    free: Vec<u32>,
    evicted: u64,
}

impl Atlas {
    /// Creates an atlas for `tiles` tiles, or as many as fit in `memory_bytes` and the device's limits.
    pub(crate) fn new(gpu: &Gpu, tiles: u64, memory_bytes: u64) -> Self {
        let limits = gpu.device.limits();
        let slots = tiles
            .min(memory_bytes / SLOT_BYTES)
            .min(u64::from(limits.max_texture_array_layers))
            .min(limits.max_buffer_size / SLOT_BYTES)
            .max(1) as u32;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tile atlas"),
            size: wgpu::Extent3d { width: TILE_STRIDE, height: TILE_STRIDE, depth_or_array_layers: slots },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: HEIGHTS_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            // By default, the view of a texture of one layer would not be an array.
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let (ring, used) = (UploadRing::default(), FxHashMap::default());
        Self { texture, view, ring, slots, used, free: (0..slots).rev().collect(), evicted: 0 }
    }

    /// Returns all heights: an array with a layer for each slot.
    pub(crate) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Returns the number of slots, which never changes.
    pub(crate) fn slots(&self) -> u32 {
        self.slots
    }

    /// Returns a tile that is on the GPU, without marking it as used.
    pub(crate) fn get(&self, tile: TileAddress) -> Option<&Resident> {
        self.used.get(&tile)
    }

    /// Returns a tile that is on the GPU, and marks it as used in frame `frame`.
    pub(crate) fn want(&self, tile: TileAddress, frame: u64) -> Option<&Resident> {
        let resident = self.used.get(&tile)?;
        resident.last_wanted.set(resident.last_wanted.get().max(frame));
        Some(resident)
    }

    /// Uploads tiles in the given order, into free slots or those of the least recently used tiles, but never of a tile
    /// that is used in frame `frame`. Returns the uploaded tiles. The others have to be offered again: there was no
    /// free slot, or the byte budget of a frame of `frame_s` seconds is used up.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        tiles: &[(TileAddress, &LoadedTile)],
        frame: u64,
        now_s: f64,
        frame_s: f64,
    ) -> Vec<TileAddress> {
        if tiles.is_empty() || !self.ring.is_ready(gpu) {
            return Vec::new();
        }
        let mut oldest = self.by_age(frame);
        let mut placed = Vec::new();
        for (address, tile) in tiles {
            let Some(slot) = self.free.pop().or_else(|| self.evict(&mut oldest)) else { break };
            placed.push((*address, slot, *tile));
        }
        let layers: Vec<_> = placed.iter().map(|(_, slot, tile)| (*slot, tile.tile.samples.as_slice())).collect();
        let sent = self.ring.send(gpu, &self.texture, TILE_STRIDE, &layers, frame_s);
        self.free.extend(placed[sent..].iter().map(|(_, slot, _)| *slot));
        placed.truncate(sent);
        placed
            .into_iter()
            .map(|(address, slot, tile)| {
                let LoadedTile { statistics, patches, occluder_minima, .. } = tile;
                let resident = Resident {
                    slot,
                    statistics: *statistics,
                    patches: patches.clone(),
                    occluder_minima: Arc::clone(occluder_minima),
                    arrived_s: now_s,
                    last_wanted: Cell::new(frame),
                };
                self.used.insert(address, resident);
                address
            })
            .collect()
    }

    /// Returns the tiles that may be evicted, the most recently used first.
    fn by_age(&self, frame: u64) -> Vec<(u64, TileAddress)> {
        if !self.free.is_empty() && self.free.len() >= 64 {
            return Vec::new();
        }
        let age = |(address, resident): (&TileAddress, &Resident)| (resident.last_wanted.get(), *address);
        let mut oldest: Vec<_> = self.used.iter().map(age).filter(|(wanted, _)| *wanted < frame).collect();
        // The address breaks ties, so that runs are deterministic.
        oldest.sort_unstable_by(|a, b| b.cmp(a));
        oldest
    }

    fn evict(&mut self, oldest: &mut Vec<(u64, TileAddress)>) -> Option<u32> {
        let (_, address) = oldest.pop()?;
        let resident = self.used.remove(&address)?;
        self.evicted += 1;
        Some(resident.slot)
    }

    /// Returns the number of tiles on the GPU.
    pub(crate) fn len(&self) -> usize {
        self.used.len()
    }

    /// Returns the number of tiles evicted so far.
    pub(crate) fn evicted(&self) -> u64 {
        self.evicted
    }

    /// Returns the GPU memory in bytes, staging buffers included.
    pub(crate) fn bytes(&self) -> u64 {
        u64::from(self.slots) * SLOT_BYTES + self.ring.bytes()
    }
}
