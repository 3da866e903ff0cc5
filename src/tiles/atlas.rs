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

/// The arrival of a tile on the GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// The slot of the tile, or [`Arrival::NO_SLOT`] for tiles that are always loaded.
    pub(super) slot: u32,
    /// The number of the arrival: another tile in that slot has another number.
    pub(super) number: u64,
    /// Time of the arrival, in seconds of the terrain's clock; negative infinity for tiles that do not fade in.
    pub(super) at_s: f64,
}

impl Arrival {
    /// The slot number of tiles that are always loaded and need no slot.
    pub(super) const NO_SLOT: u32 = u32::MAX;
    /// The arrival of tiles that are always loaded.
    pub const ALWAYS: Self = Self { slot: Self::NO_SLOT, number: 0, at_s: f64::NEG_INFINITY };
}

/// The statistics of a tile's land.
pub(crate) struct TileFacts {
    /// Height range, errors and no-data of the tile.
    pub statistics: TileStatistics,
    /// Height range, mesh error and no-data of the mesh patches of the tile's page.
    pub patches: PatchPage,
    /// Lower bounds of the tile's land, by blocks, for occlusion culling.
    pub occluder_minima: Arc<OccluderMinima>,
}

/// The tiles on the GPU at some time, for other threads.
#[derive(Default)]
pub(crate) struct Snapshot {
    /// The statistics of each of them, with its arrival.
    pub tiles: FxHashMap<TileAddress, (Arc<TileFacts>, Arrival)>,
    /// The number of the arrival of the tile in each slot; 0 if there is none.
    pub arrivals: Vec<u64>,
}

/// A tile on the GPU.
pub(crate) struct Resident {
    /// The layer of the texture that contains its heights.
    pub slot: u32,
    /// The statistics of its land.
    pub facts: Arc<TileFacts>,
    /// Time of arrival on the GPU, in seconds of the terrain's clock.
    pub arrived_s: f64,
    /// The number of its arrival: no two arrivals have the same.
    number: u64,
}

impl Resident {
    /// Returns its arrival.
    pub(crate) fn arrival(&self) -> Arrival {
        Arrival { slot: self.slot, number: self.number, at_s: self.arrived_s }
    }

    /// Returns the height range, errors and no-data of the tile.
    pub(crate) fn statistics(&self) -> &TileStatistics {
        &self.facts.statistics
    }
}

/// The use of a slot.
#[derive(Clone, Debug, Default)]
struct Use {
    /// The number of the arrival of the tile in it; 0 if there is none.
    arrival: u64,
    /// The last frame that needed the tile, and the last that needed it or expected to need it soon.
    last_needed: Cell<u64>,
    last_used: Cell<u64>,
}

impl Use {
    fn need(&self, frame: u64) {
        self.last_needed.set(self.last_needed.get().max(frame));
        self.last_used.set(self.last_used.get().max(frame));
    }
}

/// The tiles on the GPU: a texture array, and the tile in each of its layers.
pub(crate) struct Atlas {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    ring: UploadRing,
    slots: u32,
    used: FxHashMap<TileAddress, Resident>,
    uses: Vec<Use>,
    arrivals: u64,
    free: Vec<u32>,
    evicted: u64,
    evicted_needed: u64,
}

/// The tiles that an upload may not replace.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Protected {
    /// The number of a frame: tiles that were needed in it or after it are never evicted.
    pub needed_since: u64,
    /// The number of a frame: tiles that were foreseen in it or after it make room for needed tiles only.
    pub soon_since: u64,
}

/// The frame that uploads tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Upload {
    /// Number of the frame.
    pub frame: u64,
    /// Time of the frame, in seconds of the terrain's clock.
    pub now_s: f64,
    /// Time since the frame before, in seconds.
    pub frame_s: f64,
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
        let free = (0..slots).rev().collect();
        let uses = vec![Use::default(); slots as usize];
        Self { texture, view, ring, slots, used, uses, arrivals: 0, free, evicted: 0, evicted_needed: 0 }
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

    /// Returns a tile that is on the GPU, and marks it as needed in frame `frame`.
    pub(crate) fn want(&self, tile: TileAddress, frame: u64) -> Option<&Resident> {
        let resident = self.used.get(&tile)?;
        self.uses[resident.slot as usize].need(frame);
        Some(resident)
    }

    /// Marks the tile in a slot as needed in frame `frame`, if it is the one with this number of arrival. Returns
    /// whether it is.
    pub(crate) fn want_slot(&self, slot: u32, arrival: u64, frame: u64) -> bool {
        let Some(used) = self.uses.get(slot as usize).filter(|used| used.arrival == arrival) else { return false };
        used.need(frame);
        true
    }

    /// Marks a tile as needed soon in frame `frame`. Returns whether it is on the GPU.
    pub(crate) fn want_soon(&self, tile: TileAddress, frame: u64) -> bool {
        let used = self.used.get(&tile).map(|resident| &self.uses[resident.slot as usize]);
        if let Some(used) = used {
            used.last_used.set(used.last_used.get().max(frame));
        }
        used.is_some()
    }

    /// Returns what is known about all tiles on the GPU.
    pub(crate) fn snapshot(&self) -> Snapshot {
        let tile = |(address, resident): (&TileAddress, &Resident)| {
            (*address, (Arc::clone(&resident.facts), resident.arrival()))
        };
        Snapshot {
            tiles: self.used.iter().map(tile).collect(),
            arrivals: self.uses.iter().map(|used| used.arrival).collect(),
        }
    }

    /// Uploads tiles in the given order, of which the first `needed` are needed and the others will be soon, into free
    /// slots or those of the least recently used tiles, but never of those that are `protected`. Returns the uploaded
    /// tiles. The others have to be offered again: there was no free slot, or the byte budget of the frame is used up.
    pub(crate) fn insert(
        &mut self,
        gpu: &Gpu,
        tiles: &[(TileAddress, &LoadedTile)],
        needed: usize,
        protected: Protected,
        upload: Upload,
    ) -> Vec<TileAddress> {
        let Upload { frame, now_s, frame_s } = upload;
        if tiles.is_empty() || !self.ring.is_ready(gpu) {
            return Vec::new();
        }
        let mut oldest = self.oldest(tiles.len().saturating_sub(self.free.len()), protected);
        let mut placed = Vec::new();
        for (i, (address, tile)) in tiles.iter().enumerate() {
            let may_replace = |used: u64| i < needed || used < protected.soon_since;
            let Some(slot) = self.free.pop().or_else(|| {
                oldest.pop_if(|(used, _)| may_replace(*used)).and_then(|(_, old)| self.evict(old, protected))
            }) else {
                break;
            };
            placed.push((*address, slot, i < needed, *tile));
        }
        let layers: Vec<_> = placed.iter().map(|(_, slot, _, tile)| (*slot, tile.tile.samples.as_slice())).collect();
        let sent = self.ring.send(gpu, &self.texture, TILE_STRIDE, &layers, frame_s);
        self.free.extend(placed[sent..].iter().map(|(_, slot, ..)| *slot));
        placed.truncate(sent);
        placed
            .into_iter()
            .map(|(address, slot, is_needed, tile)| {
                let LoadedTile { statistics, patches, occluder_minima, .. } = tile;
                let facts = TileFacts {
                    statistics: *statistics,
                    patches: patches.clone(),
                    occluder_minima: Arc::clone(occluder_minima),
                };
                self.arrivals += 1;
                self.uses[slot as usize] = Use {
                    arrival: self.arrivals,
                    last_needed: Cell::new(if is_needed { frame } else { 0 }),
                    last_used: Cell::new(frame),
                };
                let resident = Resident { slot, facts: Arc::new(facts), arrived_s: now_s, number: self.arrivals };
                self.used.insert(address, resident);
                address
            })
            .collect()
    }

    /// Returns the number of slots that needed tiles may take: those that are free, or whose tiles are not protected.
    pub(crate) fn replaceable(&self, protected: Protected) -> usize {
        self.uses.iter().filter(|used| used.last_needed.get() < protected.needed_since).count()
    }

    /// Returns the tiles that were needed in a frame or after it.
    pub(crate) fn needed_since(&self, frame: u64) -> impl Iterator<Item = TileAddress> {
        let is_needed = move |resident: &Resident| self.uses[resident.slot as usize].last_needed.get() >= frame;
        self.used.iter().filter(move |(_, resident)| is_needed(resident)).map(|(address, _)| *address)
    }

    /// Returns up to `count` tiles that may be evicted, the least recently used last.
    fn oldest(&self, count: usize, protected: Protected) -> Vec<(u64, TileAddress)> {
        if count == 0 {
            return Vec::new();
        }
        let used = |(address, resident): (&TileAddress, &Resident)| (&self.uses[resident.slot as usize], *address);
        let mut oldest: Vec<_> = (self.used.iter().map(used))
            .filter(|(used, _)| used.last_needed.get() < protected.needed_since)
            .map(|(used, address)| (used.last_used.get(), address))
            .collect();
        // The address breaks ties, so that runs are deterministic.
        if oldest.len() > count {
            oldest.select_nth_unstable(count);
            oldest.truncate(count);
        }
        oldest.sort_unstable_by(|a, b| b.cmp(a));
        oldest
    }

    fn evict(&mut self, address: TileAddress, protected: Protected) -> Option<u32> {
        let resident = self.used.remove(&address)?;
        self.evicted += 1;
        let used = std::mem::take(&mut self.uses[resident.slot as usize]);
        self.evicted_needed += u64::from(used.last_needed.get() >= protected.needed_since);
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

    /// Returns the number of tiles evicted so far while the view needed them, which must be 0.
    pub(crate) fn evicted_needed(&self) -> u64 {
        self.evicted_needed
    }

    /// Returns the GPU memory in bytes, staging buffers included.
    pub(crate) fn bytes(&self) -> u64 {
        u64::from(self.slots) * SLOT_BYTES + self.ring.bytes()
    }
}
