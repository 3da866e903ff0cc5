//! The tiles of images in view on the GPU: layers of a texture array, of which the least recently used one is reused, and
//! a tree of the tiles of a view, by which `shaders/surface/draped_image.wgsl` finds them.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::choose::{Chosen, Sight};
use super::loader::ImageLoader;
use super::resample::Texels;
use super::{BORDER, ImageTile, Imagery, TILE_STRIDE, TILE_TEXELS};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::target::{Group, TextureName};
use crate::gpu::wgsl::surface::draped_image::{DrapedImage, ImageNode, NO_NODE, NO_SLOT};
use crate::scene::view::{Rig, View};
use crate::style::Image;
use crate::tiles::terrain::{Loading, Terrain};

/// The texels of the tiles.
const IMAGE_TILES: TextureName = TextureName {
    name: "image tiles",
    content: Group::Surface.shows("Images on the land, in tiles on the grid of heights"),
};
/// Largest number of tiles on the GPU: 277 MB.
const MOST_SLOTS: usize = 1024;
/// Least number of slots.
const LEAST_SLOTS: usize = 16;
/// Largest number of tiles that a frame uploads if it does not wait: 2 MB.
const UPLOADS: usize = 8;
/// Number of tiles that are resampled before they are uploaded, for a frame that waits: 35 MB.
const BATCH: usize = 128;
/// Time for a tile to fade in, in seconds.
const FADE_S: f64 = 0.15;

/// The tiles on the GPU.
pub(crate) struct ResidentImagery {
    imagery: Arc<Imagery>,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    nodes: GrowingBuffer,
    slots: Vec<Slot>,
    /// Slot of each tile that is on the GPU.
    slot_of: FxHashMap<ImageTile, u32>,
    /// Tiles that cannot be read.
    failed: FxHashSet<ImageTile>,
    /// Why the first of them cannot.
    failure: Option<String>,
    loader: Option<ImageLoader>,
    /// The last view and its tiles.
    seen: Option<(Sight, Chosen)>,
    /// Number of views that have been followed.
    views: u64,
    started: Instant,
    /// Where level 0 begins for the last view.
    anchor: DVec2,
    is_late: bool,
    changes: bool,
    has_warned: bool,
}

/// A layer of the texture.
#[derive(Clone, Copy, Default)]
struct Slot {
    tile: Option<ImageTile>,
    /// The last view that needed the tile.
    used_in: u64,
    /// When the tile began to fade in, in seconds; negative infinity if it does not.
    arrived_s: f64,
}

impl ResidentImagery {
    pub(crate) fn new(gpu: &Gpu, imagery: Imagery) -> Self {
        let texture = texture(gpu, LEAST_SLOTS);
        let mut nodes = GrowingBuffer::new(gpu, "image nodes", wgpu::BufferUsages::STORAGE);
        nodes.write(gpu, &[node()]);
        Self {
            imagery: Arc::new(imagery),
            view: array_view(&texture),
            texture,
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            nodes,
            slots: vec![Slot::default(); LEAST_SLOTS],
            slot_of: FxHashMap::default(),
            failed: FxHashSet::default(),
            failure: None,
            loader: None,
            seen: None,
            views: 0,
            started: Instant::now(),
            anchor: DVec2::ZERO,
            is_late: false,
            changes: false,
            has_warned: false,
        }
    }

    /// Sends the tiles to the GPU that a rig sees of the images on a terrain. A frame that waits has all of them
    /// afterwards; otherwise they arrive later, and coarser ones are drawn until then.
    pub(crate) fn follow(&mut self, gpu: &Gpu, terrain: &Terrain, rig: &Rig) {
        self.views += 1;
        let projection = terrain.grid_projection();
        self.anchor = projection.anchor(rig.origin_m.truncate());
        let sight = Sight {
            origin_m: rig.origin_m,
            eyes: rig.eyes.iter().map(|eye| (eye.pose.position_m - rig.origin_m, eye.frustum())).collect(),
            focal_px: rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max),
            earth_curvature: terrain.earth_curvature(rig.origin_m.z),
            range_m: terrain.range_m().map(f64::from),
            spacing_m: projection.spacing_m(),
        };
        let most = MOST_SLOTS.min(gpu.device.limits().max_texture_array_layers as usize);
        let is_same = self.seen.as_ref().is_some_and(|(seen, _)| *seen == sight);
        if !is_same {
            let chosen = self.imagery.choose(&sight, projection, most);
            if chosen.bias > 0.0 && !std::mem::replace(&mut self.has_warned, true) {
                tracing::warn!(
                    "the images on the land are drawn coarser, because more than {most} of their tiles are in view"
                );
            }
            self.seen = Some((sight, chosen));
        }
        let chosen = self.seen.as_ref().map(|(_, chosen)| chosen.clone()).unwrap_or_default();
        self.make_room(gpu, chosen.tiles.len());
        let mut missing = Vec::new();
        for tile in &chosen.tiles {
            match self.slot_of.get(tile).and_then(|slot| self.slots.get_mut(*slot as usize)) {
                Some(slot) => slot.used_in = self.views,
                None if self.failed.contains(tile) => {}
                None => missing.push(*tile),
            }
        }
        let now_s = self.started.elapsed().as_secs_f64();
        let waits = terrain.options().loading == Loading::Wait;
        let mut arrived = 0;
        if waits {
            for batch in missing.chunks(BATCH) {
                let made: Vec<_> = batch.par_iter().map(|tile| (*tile, self.imagery.resample(*tile))).collect();
                for (tile, texels) in made {
                    arrived +=
                        usize::from(self.take(gpu, tile, texels.map_err(|error| error.to_string()), f64::NEG_INFINITY));
                }
                // Uploads so far need not wait in memory.
                gpu.queue.submit([]);
            }
        } else if !missing.is_empty() || self.loader.is_some() {
            let loader = self.loader.get_or_insert_with(|| ImageLoader::new(&self.imagery));
            let finished: Vec<_> = (0..UPLOADS).map_while(|_| loader.take()).collect();
            for (tile, texels) in finished {
                if !self.slot_of.contains_key(&tile) {
                    arrived += usize::from(self.take(gpu, tile, texels.map_err(|error| error.to_string()), now_s));
                }
            }
            missing.retain(|tile| !self.slot_of.contains_key(tile) && !self.failed.contains(tile));
            if let Some(loader) = &self.loader {
                loader.want(&missing);
            }
        }
        let was_late = self.is_late;
        let fade_of = |slot: &Slot| if waits { 1.0 } else { ((now_s - slot.arrived_s) / FADE_S).clamp(0.0, 1.0) };
        let (nodes, fades) = self.tree(&chosen.tiles, fade_of);
        self.nodes.write(gpu, &nodes);
        self.is_late = !waits && (fades || missing.iter().any(|tile| !self.slot_of.contains_key(tile)));
        self.changes = arrived > 0 || self.is_late || was_late;
    }

    /// Returns the tree of the tiles of a view, and whether any of them fades in.
    fn tree(&self, tiles: &[ImageTile], fade_of: impl Fn(&Slot) -> f64) -> (Vec<ImageNode>, bool) {
        let mut nodes = vec![node()];
        let mut fades = false;
        let mut index_of: FxHashMap<ImageTile, usize> = FxHashMap::default();
        for tile in tiles {
            let index = if tile.level == self.imagery.top {
                0
            } else {
                let above = ImageTile { level: tile.level + 1, x: tile.x / 2, y: tile.y / 2 };
                let Some(&above) = index_of.get(&above) else { continue };
                if nodes[above].first_child == NO_NODE {
                    nodes[above].first_child = nodes.len() as i32;
                    nodes.resize(nodes.len() + 4, node());
                }
                nodes[above].first_child as usize + (tile.x % 2 + 2 * (tile.y % 2)) as usize
            };
            index_of.insert(*tile, index);
            nodes[index].is_there = 1;
            if let Some(number) = self.slot_of.get(tile)
                && let Some(slot) = self.slots.get(*number as usize)
            {
                let fade = fade_of(slot);
                fades |= fade < 1.0;
                nodes[index].slot = *number as i32;
                nodes[index].fade = fade as f32;
            }
        }
        (nodes, fades)
    }

    /// Puts a resampled tile into a slot. Returns whether it has one.
    fn take(&mut self, gpu: &Gpu, tile: ImageTile, texels: Result<Texels, String>, arrived_s: f64) -> bool {
        let texels = match texels {
            Ok(texels) => texels,
            Err(error) => {
                if self.failure.is_none() {
                    tracing::warn!("an image on the land is incomplete: {error}");
                    self.failure = Some(error);
                }
                self.failed.insert(tile);
                return false;
            }
        };
        let is_free = |slot: &Slot| slot.tile.is_none() || slot.used_in < self.views;
        let oldest = self.slots.iter().enumerate().filter(|(_, slot)| is_free(slot));
        let Some((number, _)) = oldest.min_by_key(|(number, slot)| (slot.used_in, *number)) else { return false };
        if let Some(evicted) = self.slots[number].tile.replace(tile) {
            self.slot_of.remove(&evicted);
        }
        (self.slots[number].used_in, self.slots[number].arrived_s) = (self.views, arrived_s);
        self.slot_of.insert(tile, number as u32);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: 0, z: number as u32 },
                aspect: wgpu::TextureAspect::All,
            },
            texels.as_flattened(),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * TILE_STRIDE),
                rows_per_image: Some(TILE_STRIDE),
            },
            wgpu::Extent3d { width: TILE_STRIDE, height: TILE_STRIDE, depth_or_array_layers: 1 },
        );
        true
    }

    /// Makes sure that there are slots for so many tiles. Those that are there stay.
    fn make_room(&mut self, gpu: &Gpu, needed: usize) {
        if needed <= self.slots.len() {
            return;
        }
        let most = MOST_SLOTS.min(gpu.device.limits().max_texture_array_layers as usize);
        let count = needed.next_power_of_two().min(most).max(needed);
        let larger = texture(gpu, count);
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("image tiles") });
        let depth_or_array_layers = self.slots.len() as u32;
        let size = wgpu::Extent3d { width: TILE_STRIDE, height: TILE_STRIDE, depth_or_array_layers };
        encoder.copy_texture_to_texture(self.texture.as_image_copy(), larger.as_image_copy(), size);
        gpu.queue.submit([encoder.finish()]);
        self.view = array_view(&larger);
        self.texture = larger;
        self.slots.resize(count, Slot::default());
    }

    /// Returns whether tiles of the last view are missing or fade in.
    pub(crate) fn is_late(&self) -> bool {
        self.is_late
    }

    /// Returns whether the last view shows more of the images than the one before.
    pub(crate) fn changes(&self) -> bool {
        self.changes
    }

    /// Returns why a tile could not be read, if one could not.
    pub(crate) fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Returns the memory on the GPU, in bytes.
    #[cfg(test)]
    pub(crate) fn gpu_bytes(&self) -> u64 {
        self.slots.len() as u64 * u64::from(TILE_STRIDE * TILE_STRIDE) * 4 + self.nodes.buffer().size()
    }

    /// Returns the number of tiles of the last view, and the levels by which it is coarser.
    #[cfg(test)]
    pub(crate) fn in_view(&self) -> (usize, f64) {
        self.seen.as_ref().map_or((0, 0.0), |(_, chosen)| (chosen.tiles.len(), chosen.bias))
    }

    /// Returns what the shader binds, apart from its uniform.
    pub(crate) fn resources(&self) -> [Named; 3] {
        [
            ("image_tiles", Resource::Texture(IMAGE_TILES, self.view.clone())),
            ("image_sampler", Resource::Sampler(self.sampler.clone())),
            ("image_nodes", self.nodes.binding()),
        ]
    }

    /// Returns the uniform of the shader for the last view and a style.
    pub(crate) fn uniform(&self, style: &Image) -> DrapedImage {
        let texels = self.imagery.texels_per_sample;
        let begin = (self.anchor + 0.5) * texels;
        let cell = begin.floor();
        let (focal_px, spacing_m, bias) = self
            .seen
            .as_ref()
            .map_or((1.0, 1.0, 0.0), |(sight, chosen)| (sight.focal_px, sight.spacing_m, chosen.bias));
        DrapedImage {
            cell: cell.as_ivec2().to_array(),
            fraction: (begin - cell).as_vec2().to_array(),
            texels_per_sample: texels as f32,
            texel_m: (spacing_m / texels) as f32,
            focal_px: focal_px as f32,
            bias: bias as f32,
            top: self.imagery.top as i32,
            color: style.color,
            tone: style.tone,
            brightness: style.brightness,
            contrast: [style.contrast_red, style.contrast_green, style.contrast_blue],
            pad: 0.0,
        }
    }
}

fn node() -> ImageNode {
    ImageNode { first_child: NO_NODE, slot: NO_SLOT, fade: 0.0, is_there: 0 }
}

fn texture(gpu: &Gpu, slots: usize) -> wgpu::Texture {
    const { assert!(TILE_STRIDE == TILE_TEXELS + 2 * BORDER) };
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image tiles"),
        size: wgpu::Extent3d { width: TILE_STRIDE, height: TILE_STRIDE, depth_or_array_layers: slots as u32 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}
