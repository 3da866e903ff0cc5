//! Points, meshes and pictures on the GPU, shared by all forests of the same species.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::edges::EdgesOfSpecies;
use super::place::TreePoint;
use super::raster::TreeVertex;
use crate::forest::colors::color_index_of;
use crate::forest::hull::hulls;
use crate::forest::impostor::{FRAMES, Impostor, ImpostorCorner, Level, levels_of};
use crate::forest::model::{TreeCorner, TreeModel};
use crate::forest::points::Points;
use crate::forest::species::{Corner, Detail, Grown, Part, canopy};
use crate::gpu::Gpu;
use crate::gpu::buffer::{Buffer, BufferKind};

/// The [`TreePoint`]s of a tile, level by level.
const POINTS: BufferKind = BufferKind::storage("tree points");
/// The indices of a mesh.
const INDICES: BufferKind = BufferKind::index("tree indices");
/// The [`TreeVertex`]s of a mesh.
const VERTICES: BufferKind = BufferKind::storage("tree vertices");
const PICTURES: &str = "tree pictures";
const OUTLINES: &str = "tree outlines";
/// For each species and level, the hull of each picture.
const HULLS: BufferKind = BufferKind::storage("tree hulls");
/// Sides of the pictures of a tree, and of a piece of canopy, in pixels.
const TREE_PX: u32 = 64;
const CANOPY_PX: u32 = 32;

/// An indexed triangle list on the GPU.
pub(super) struct TreeMesh {
    pub vertices: Buffer,
    /// Three u16 for each triangle.
    pub indices: Buffer,
    pub index_count: u32,
    /// Palette index of each vertex.
    pub color_indices: Vec<u8>,
}

/// The meshes and pictures of a species.
pub(super) struct SpeciesModel {
    pub near: TreeMesh,
    pub middle: TreeMesh,
    pub alone: SpeciesPictures,
    pub canopy: SpeciesPictures,
    /// Radius of the crown, as a fraction of the tree's height.
    pub crown: f32,
}

/// The pictures of the impostors of all species on the GPU: each species has a layer.
pub(super) struct TreePictures {
    /// [`Level::texels`].
    pub texels: wgpu::TextureView,
    /// [`Level::outlines`].
    pub outlines: wgpu::TextureView,
    /// Interpolates between texels and between mip levels.
    pub sampler: wgpu::Sampler,
    pub hulls: Buffer,
}

/// The properties of the pictures of one species.
pub(super) struct SpeciesPictures {
    /// The species' layer of [`TreePictures::texels`].
    pub of_species: wgpu::TextureView,
    /// Middle and radius of the bounding sphere, in tree units (height and width 1).
    pub middle: [f32; 3],
    pub radius: f32,
    /// Radius, bottom and top of the upright cylinder that holds the tree; the last number is unused.
    pub cylinder: [f32; 4],
    /// For each mip level, the side of a picture in pixels and
    /// [`Level::color_indices`](crate::forest::impostor::Level::color_indices).
    pub color_indices: Vec<(u32, Vec<u8>)>,
}

/// The source of a species' meshes.
#[derive(Clone)]
pub(super) enum Look {
    Grown(Grown),
    Model(Arc<TreeModel>),
}

impl PartialEq for Look {
    /// Two models are equal only if they are the same object.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Grown(one), Self::Grown(other)) => one == other,
            (Self::Model(one), Self::Model(other)) => Arc::ptr_eq(one, other),
            (Self::Grown(_), Self::Model(_)) | (Self::Model(_), Self::Grown(_)) => false,
        }
    }
}

pub(super) struct Shared {
    pub looks: Vec<Look>,
    pub points: Points,
    pub point_buffer: Buffer,
    pub species: Vec<SpeciesModel>,
    /// The pictures of trees.
    pub alone: TreePictures,
    /// The pictures of pieces of canopy.
    pub canopy: TreePictures,
    /// Edges of the near meshes.
    pub edges: EdgesOfSpecies,
}

impl Shared {
    /// Grows the species and uploads them.
    pub(super) fn new(gpu: &Gpu, looks: Vec<Look>) -> Self {
        let points = Points::new();
        let packed: Vec<TreePoint> = points
            .points
            .iter()
            .map(|point| TreePoint { at: point.at.map(|along| along as f32), number: point.number, padding: 0 })
            .collect();
        let meshes: Vec<[Vec<TreeCorner>; 3]> = looks.iter().map(Look::meshes).collect();
        let pictures = |mesh: usize, frame_px: u32| {
            let corners: Vec<&[TreeCorner]> = meshes.iter().map(|meshes| meshes[mesh].as_slice()).collect();
            TreePictures::new(gpu, &corners, frame_px)
        };
        let ((alone, of_alone), (canopy, of_canopy)) = (pictures(0, TREE_PX), pictures(2, CANOPY_PX));
        let species = meshes.iter().zip(of_alone.into_iter().zip(of_canopy));
        let species = species.map(|(meshes, (alone, canopy))| SpeciesModel::new(gpu, meshes, alone, canopy)).collect();
        let edges = EdgesOfSpecies::new(gpu, meshes.iter().map(|[near, ..]| near.as_slice()));
        Self { point_buffer: Buffer::with(gpu, &POINTS, &packed), points, species, alone, canopy, edges, looks }
    }
}

impl Look {
    /// Returns the near mesh, the mesh of the middle distance, and that of a piece of canopy.
    fn meshes(&self) -> [Vec<TreeCorner>; 3] {
        match self {
            Self::Grown(grown) => [grown.grow(Detail::Near), grown.grow(Detail::Middle), canopy(*grown)]
                .map(|corners| corners.iter().map(|corner| toned(*grown, corner)).collect()),
            Self::Model(model) => [model.near.clone(), model.middle.clone(), model.canopy.clone()],
        }
    }
}

impl SpeciesModel {
    fn new(
        gpu: &Gpu,
        [near, middle, _]: &[Vec<TreeCorner>; 3],
        alone: SpeciesPictures,
        canopy: SpeciesPictures,
    ) -> Self {
        // The radius that holds nine tenths of the vertices; those farther out belong to single twigs.
        let mut reaches: Vec<f64> = near.iter().map(|corner| corner.at.truncate().length()).collect();
        reaches.sort_by(f64::total_cmp);
        let crown = reaches.get(reaches.len() * 9 / 10).copied().unwrap_or(0.2);
        Self { near: TreeMesh::new(gpu, near), middle: TreeMesh::new(gpu, middle), alone, canopy, crown: crown as f32 }
    }
}

impl TreeMesh {
    fn new(gpu: &Gpu, corners: &[TreeCorner]) -> Self {
        let vertex = |corner: &TreeCorner| TreeVertex {
            at: corner.at.as_vec3().extend(corner.sway as f32).to_array(),
            normal: corner.normal.as_vec3().extend(corner.lightness as f32).to_array(),
        };
        let corners = corners.iter().map(|corner| (vertex(corner), corner.color_index));
        let (vertices, mut indices) = indexed(corners);
        let index_count = indices.len() as u32;
        // A copy to a buffer has a multiple of four bytes.
        indices.resize(indices.len().next_multiple_of(2), 0);
        let color_indices = vertices.iter().map(|(_, color_index)| *color_index).collect();
        let vertices: Vec<TreeVertex> = vertices.into_iter().map(|(vertex, _)| vertex).collect();
        Self {
            vertices: Buffer::with(gpu, &VERTICES, &vertices),
            indices: Buffer::with(gpu, &INDICES, &indices),
            index_count,
            color_indices,
        }
    }
}

/// Merges the corners that are equal, bit for bit. A mesh has a few thousand.
fn indexed(corners: impl Iterator<Item = (TreeVertex, u8)>) -> (Vec<(TreeVertex, u8)>, Vec<u16>) {
    let mut known: FxHashMap<([u32; 8], u8), u16> = FxHashMap::default();
    let mut vertices = Vec::new();
    let indices = corners
        .map(|(vertex, color_index)| {
            *known.entry((bytemuck::cast(vertex), color_index)).or_insert_with(|| {
                vertices.push((vertex, color_index));
                (vertices.len() - 1) as u16
            })
        })
        .collect();
    (vertices, indices)
}

/// Returns the corner with the lightness of its material, where bare land is 1.
fn toned(grown: Grown, corner: &Corner) -> TreeCorner {
    let Corner { at, normal, part, sway } = *corner;
    let lightness = match (grown, part) {
        (Grown::Conifer, Part::Leaf) => 0.5,
        (Grown::Broadleaf, Part::Leaf) => 0.62,
        (Grown::Birch, Part::Leaf) => 0.74,
        (Grown::Birch, Part::Bark) => 0.97,
        (Grown::Snag, _) => 0.75,
        (Grown::Conifer | Grown::Broadleaf, Part::Bark) => 0.45,
    };
    TreeCorner { at, normal, lightness, color_index: color_index_of(part), sway }
}

impl TreePictures {
    /// Draws the pictures of all species, given by their meshes.
    fn new(gpu: &Gpu, meshes: &[&[TreeCorner]], frame_px: u32) -> (Self, Vec<SpeciesPictures>) {
        let layers = meshes.len() as u32;
        let texels = texture(gpu, PICTURES, wgpu::TextureFormat::Rgba16Float, [frame_px, layers]);
        let outlines = texture(gpu, OUTLINES, wgpu::TextureFormat::Rg16Float, [frame_px, layers]);
        let mut all_hulls = Vec::new();
        let species = (0..layers).zip(meshes).map(|(layer, corners)| {
            let impostor = drawn(corners, frame_px);
            for (number, level) in (0..).zip(&impostor.levels) {
                write(gpu, (&texels, layer, number), level, &level.texels);
                write(gpu, (&outlines, layer, number), level, &level.outlines);
                all_hulls.extend(hulls(level));
            }
            let of_species = texels.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            SpeciesPictures::new(impostor, corners, of_species)
        });
        let species = species.collect();
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(OUTLINES),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let [texels, outlines] = [texels, outlines].map(|texture| array_view(&texture));
        (Self { texels, outlines, sampler, hulls: Buffer::with(gpu, &HULLS, &all_hulls) }, species)
    }
}

/// Draws the pictures of a mesh.
fn drawn(corners: &[TreeCorner], frame_px: u32) -> Impostor {
    let pictured = |corner: &TreeCorner| {
        let TreeCorner { at, normal, lightness, color_index, .. } = *corner;
        ImpostorCorner { at, normal, lightness, color_index }
    };
    Impostor::draw(&corners.iter().map(pictured).collect::<Vec<_>>(), frame_px)
}

impl SpeciesPictures {
    fn new(impostor: Impostor, corners: &[TreeCorner], of_species: wgpu::TextureView) -> Self {
        let middle = impostor.middle.as_vec3().to_array();
        let reach = corners.iter().map(|corner| corner.at.truncate().length()).fold(0.0, f64::max);
        let (low, high) = corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
            (low.min(corner.at.z), high.max(corner.at.z))
        });
        // One texel wider, because a picture covers up to one texel more than the mesh.
        let more = 2.0 * impostor.radius / f64::from(impostor.frame_px);
        let cylinder = [reach + more, low - more, high + more, 0.0].map(|along| along as f32);
        let radius = impostor.radius as f32;
        let color_indices = impostor.levels.into_iter().map(|level| (level.frame_px, level.color_indices)).collect();
        Self { of_species, middle, radius, cylinder, color_indices }
    }
}

/// Returns the extent of the pictures of all species at a level whose pictures have this side.
pub(super) fn extent_px(frame_px: u32, layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d { width: FRAMES * frame_px, height: FRAMES * frame_px, depth_or_array_layers: layers }
}

/// Creates the texture of the pictures of all species.
pub(super) fn texture(
    gpu: &Gpu,
    name: &'static str,
    format: wgpu::TextureFormat,
    [frame_px, layers]: [u32; 2],
) -> wgpu::Texture {
    gpu.count_object();
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: extent_px(frame_px, layers),
        mip_level_count: levels_of(frame_px),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Returns the view of all layers. A single layer would be a picture without layers otherwise.
pub(super) fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let dimension = Some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
}

/// Writes a level of a layer of a texture.
fn write<const CHANNELS: usize>(
    gpu: &Gpu,
    (texture, layer, number): (&wgpu::Texture, u32, u32),
    level: &Level,
    texels: &[[half::f16; CHANNELS]],
) {
    let bits: Vec<u16> = texels.iter().flatten().map(|value| value.to_bits()).collect();
    write_bytes(gpu, (texture, layer, number), level.frame_px, bytemuck::cast_slice(&bits));
}

/// Writes the texels of a level of a layer, row by row.
pub(super) fn write_bytes(
    gpu: &Gpu,
    (texture, layer, number): (&wgpu::Texture, u32, u32),
    frame_px: u32,
    texels: &[u8],
) {
    let size = extent_px(frame_px, 1);
    let bytes_per_row = Some(texels.len() as u32 / size.height);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    let origin = wgpu::Origin3d { z: layer, ..wgpu::Origin3d::ZERO };
    let to = wgpu::TexelCopyTextureInfo { mip_level: number, origin, ..texture.as_image_copy() };
    gpu.queue.write_texture(to, texels, layout, size);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_that_are_equal_are_shaded_once() {
        for grown in [Grown::Conifer, Grown::Broadleaf, Grown::Birch, Grown::Snag] {
            for detail in [Detail::Near, Detail::Middle] {
                let corners = grown.grow(detail);
                let vertex = |corner: &Corner| {
                    let corner = toned(grown, corner);
                    let at = corner.at.as_vec3().extend(corner.sway as f32).to_array();
                    let normal = corner.normal.as_vec3().extend(corner.lightness as f32).to_array();
                    (TreeVertex { at, normal }, corner.color_index)
                };
                let all: Vec<(TreeVertex, u8)> = corners.iter().map(vertex).collect();
                let (vertices, indices) = indexed(all.iter().copied());
                // Every corner is unchanged.
                assert!(indices.iter().zip(&all).all(|(index, corner)| vertices[usize::from(*index)] == *corner));
                assert!(vertices.len() as f64 <= 0.7 * all.len() as f64, "{grown:?} {detail:?}: {}", vertices.len());
                // Planted error: a colour that differs keeps corners apart.
                let other = all.iter().enumerate().map(|(i, (vertex, _))| (*vertex, (i % 250) as u8));
                assert!(indexed(other).0.len() > vertices.len());
            }
        }
    }
}
