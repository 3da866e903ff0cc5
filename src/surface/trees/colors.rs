//! The local colours of trees on the GPU, for frames whose style needs them.
//!
//! Vertices and pictures of trees do not depend on the style: they hold palette indices ([`crate::forest::colors`]).
//! The palettes are created when a style needs colours, and dropped when no style does.

use std::convert::Infallible;
use std::sync::Arc;

use super::DrawnTrees;
use super::shared::{Look, Shared, SpeciesModel, TreeMesh, TreePictures};
use crate::forest::colors::{of_grown, of_model};
use crate::forest::impostor::FRAMES;
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::scene::Forest;
use crate::surface::local_color::packed;

/// Hue of each vertex of a mesh.
const VERTEX_COLORS: BufferKind = BufferKind::storage("tree colors");
/// Hues of the palette of a species.
const PALETTE: BufferKind = BufferKind::storage("tree palette");
const COLOR_INDICES: &str = "tree paints";

/// The colours of the species of a forest.
pub(crate) struct TreeColors {
    shared: Arc<Shared>,
    palettes: Vec<Vec<u32>>,
    pub(super) species: Vec<SpeciesColors>,
}

/// The colours of one species.
pub(super) struct SpeciesColors {
    pub near: Buffer,
    pub middle: Buffer,
    /// Palette indices of the pictures of a tree.
    alone: wgpu::TextureView,
    canopy: wgpu::TextureView,
    palette: Buffer,
}

/// Trees with their local colours, for the passes that draw them.
pub(crate) struct Colored {
    pub(super) colors: Arc<TreeColors>,
    pub local_color: Target,
}

impl Colored {
    /// Returns the colours of the trees of a forest, which are cached.
    pub(crate) fn of(recorder: &mut Recorder<'_>, forest: &Forest, trees: &DrawnTrees, local_color: Target) -> Self {
        let shared = &trees.shared;
        let palettes: Vec<Vec<u32>> = shared
            .looks
            .iter()
            .zip(&forest.species)
            .map(|(look, species)| {
                let palette = match look {
                    Look::Grown(grown) => of_grown(*grown, species),
                    Look::Model(model) => of_model(model, species),
                };
                palette.into_iter().map(packed).collect()
            })
            .collect();
        let made = recorder.cached(
            |known: &TreeColors| Arc::ptr_eq(&known.shared, shared) && known.palettes == palettes,
            |gpu| {
                let species = shared.species.iter().zip(&palettes);
                let species = species.map(|(model, palette)| SpeciesColors::new(gpu, model, palette)).collect();
                let (shared, palettes) = (Arc::clone(shared), palettes.clone());
                Ok::<_, Infallible>(TreeColors { shared, palettes, species })
            },
        );
        let Ok(colors) = made;
        Self { colors, local_color }
    }
}

impl SpeciesColors {
    fn new(gpu: &Gpu, model: &SpeciesModel, palette: &[u32]) -> Self {
        let of_mesh = |mesh: &TreeMesh| {
            let colors: Vec<u32> = mesh.color_indices.iter().map(|index| palette[usize::from(*index)]).collect();
            Buffer::with(gpu, &VERTEX_COLORS, &colors)
        };
        Self {
            near: of_mesh(&model.near),
            middle: of_mesh(&model.middle),
            alone: color_indices(gpu, &model.alone),
            canopy: color_indices(gpu, &model.canopy),
            palette: Buffer::with(gpu, &PALETTE, palette),
        }
    }

    /// Returns the bindings of the impostor shader, for trees or for pieces of canopy.
    pub(super) fn of_pictures(&self, is_canopy: bool) -> [Named; 2] {
        let color_indices = if is_canopy { &self.canopy } else { &self.alone };
        [
            ("tree_paints", Resource::Texture(COLOR_INDICES, color_indices.clone())),
            ("tree_palette", self.palette.binding()),
        ]
    }
}

fn color_indices(gpu: &Gpu, pictures: &TreePictures) -> wgpu::TextureView {
    gpu.count_object();
    let extent = |frame_px: u32| {
        let side = FRAMES * frame_px;
        wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 }
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(COLOR_INDICES),
        size: extent(pictures.color_indices.first().map_or(1, |(frame_px, _)| *frame_px)),
        mip_level_count: pictures.color_indices.len().max(1) as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R8Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    for (number, (frame_px, color_indices)) in pictures.color_indices.iter().enumerate() {
        let size = extent(*frame_px);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(size.width), rows_per_image: None };
        let to = wgpu::TexelCopyTextureInfo { mip_level: number as u32, ..texture.as_image_copy() };
        gpu.queue.write_texture(to, color_indices, layout, size);
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
