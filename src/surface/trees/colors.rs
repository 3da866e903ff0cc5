//! The local colours of trees on the GPU, for frames whose style needs them.
//!
//! Vertices and pictures of trees do not depend on the style: they hold palette indices ([`crate::forest::colors`]).
//! The palettes are created when a style needs colours, and dropped when no style does.

use std::convert::Infallible;
use std::sync::Arc;

use super::DrawnTrees;
use super::shared::{Look, Shared, SpeciesModel, SpeciesPictures, TreeMesh, array_view, texture, write_bytes};
use crate::forest::colors::{of_grown, of_model};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TextureName};
use crate::gpu::wgsl::surface::trees::impostor::PALETTE;
use crate::scene::Forest;
use crate::surface::local_color::packed;

/// Hue of each vertex of a mesh.
const VERTEX_COLORS: BufferKind = BufferKind::storage("tree colors");
/// Hues of the palettes of all species, [`PALETTE`] each.
const PALETTES: BufferKind = BufferKind::storage("tree palette");
const COLOR_INDICES: TextureName = TextureName {
    name: "tree paints",
    content: Group::Trees.shows("Pictures of trees from all sides: number in the palette of the species"),
};

/// The colours of the species of a forest.
pub(crate) struct TreeColors {
    shared: Arc<Shared>,
    palettes: Vec<Vec<u32>>,
    pub(super) species: Vec<SpeciesColors>,
    /// Palette indices of the pictures of trees: a layer for each species.
    alone: wgpu::TextureView,
    /// Palette indices of the pictures of pieces of canopy.
    canopy: wgpu::TextureView,
    palette: Buffer,
}

/// The colours of one species.
pub(super) struct SpeciesColors {
    pub near: Buffer,
    pub middle: Buffer,
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
                let alone = color_indices(gpu, shared.species.iter().map(|model| &model.alone));
                let canopy = color_indices(gpu, shared.species.iter().map(|model| &model.canopy));
                let mut padded = vec![0; palettes.len() * PALETTE as usize];
                for (palette, own) in palettes.iter().zip(padded.chunks_exact_mut(PALETTE as usize)) {
                    own.iter_mut().zip(palette).for_each(|(own, hue)| *own = *hue);
                }
                let palette = Buffer::with(gpu, &PALETTES, &padded);
                let (shared, palettes) = (Arc::clone(shared), palettes.clone());
                Ok::<_, Infallible>(TreeColors { shared, palettes, species, alone, canopy, palette })
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
        Self { near: of_mesh(&model.near), middle: of_mesh(&model.middle) }
    }
}

impl TreeColors {
    /// Returns the bindings of the impostor shader, for trees or for pieces of canopy.
    pub(super) fn of_pictures(&self, is_canopy: bool) -> [Named; 2] {
        let color_indices = if is_canopy { &self.canopy } else { &self.alone };
        [
            ("tree_paints", Resource::Texture(COLOR_INDICES, color_indices.clone())),
            ("tree_palette", self.palette.binding()),
        ]
    }
}

/// Uploads the palette indices of the pictures of all species, of which there is at least one.
fn color_indices<'a>(gpu: &Gpu, species: impl Iterator<Item = &'a SpeciesPictures>) -> wgpu::TextureView {
    let species: Vec<&SpeciesPictures> = species.collect();
    let frame_px = species.first().and_then(|pictures| pictures.color_indices.first()).map_or(1, |(px, _)| *px);
    let texture = texture(gpu, COLOR_INDICES.name, wgpu::TextureFormat::R8Uint, [frame_px, species.len() as u32]);
    for (layer, pictures) in (0..).zip(species) {
        for (number, (frame_px, color_indices)) in (0..).zip(&pictures.color_indices) {
            write_bytes(gpu, (&texture, layer, number), *frame_px, color_indices);
        }
    }
    array_view(&texture)
}
