//! Points, meshes and pictures on the GPU, shared by all forests of the same species.

use std::sync::Arc;

use super::edges::EdgesOfSpecies;
use super::place::TreePoint;
use super::raster::TreeVertex;
use crate::forest::colors::color_index_of;
use crate::forest::impostor::{FRAMES, Impostor, ImpostorCorner, Level};
use crate::forest::model::{TreeCorner, TreeModel};
use crate::forest::points::Points;
use crate::forest::species::{Corner, Detail, Grown, Part, canopy};
use crate::gpu::Gpu;
use crate::gpu::buffer::{Buffer, BufferKind};

/// The [`TreePoint`]s of a tile, level by level.
const POINTS: BufferKind = BufferKind::storage("tree points");
/// The [`TreeVertex`]s of a mesh.
const VERTICES: BufferKind = BufferKind::storage("tree vertices");
const PICTURES: &str = "tree pictures";
const OUTLINES: &str = "tree outlines";
/// Sides of the pictures of a tree, and of a piece of canopy, in pixels.
const TREE_PX: u32 = 64;
const CANOPY_PX: u32 = 32;

/// A triangle list on the GPU.
pub(super) struct TreeMesh {
    pub vertices: Buffer,
    pub count: u32,
    /// Palette index of each vertex.
    pub color_indices: Vec<u8>,
}

/// The meshes and pictures of a species.
pub(super) struct SpeciesModel {
    pub near: TreeMesh,
    pub middle: TreeMesh,
    pub alone: TreePictures,
    pub canopy: TreePictures,
    /// Radius of the crown, as a fraction of the tree's height.
    pub crown: f32,
}

/// The pictures of an impostor on the GPU.
pub(super) struct TreePictures {
    /// [`Level::texels`].
    pub view: wgpu::TextureView,
    /// [`Level::outlines`].
    pub outlines: wgpu::TextureView,
    /// Interpolates between texels and between mip levels.
    pub sampler: wgpu::Sampler,
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
        let species = meshes.iter().map(|meshes| SpeciesModel::new(gpu, meshes)).collect();
        let edges = EdgesOfSpecies::new(gpu, meshes.iter().map(|[near, ..]| near.as_slice()));
        Self { point_buffer: Buffer::with(gpu, &POINTS, &packed), points, species, edges, looks }
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
    fn new(gpu: &Gpu, [near, middle, canopy]: &[Vec<TreeCorner>; 3]) -> Self {
        // The radius that holds nine tenths of the vertices; those farther out belong to single twigs.
        let mut reaches: Vec<f64> = near.iter().map(|corner| corner.at.truncate().length()).collect();
        reaches.sort_by(f64::total_cmp);
        let crown = reaches.get(reaches.len() * 9 / 10).copied().unwrap_or(0.2);
        Self {
            near: TreeMesh::new(gpu, near),
            middle: TreeMesh::new(gpu, middle),
            alone: TreePictures::new(gpu, near, TREE_PX),
            canopy: TreePictures::new(gpu, canopy, CANOPY_PX),
            crown: crown as f32,
        }
    }
}

impl TreeMesh {
    fn new(gpu: &Gpu, corners: &[TreeCorner]) -> Self {
        let vertex = |corner: &TreeCorner| TreeVertex {
            at: corner.at.as_vec3().extend(corner.sway as f32).to_array(),
            normal: corner.normal.as_vec3().extend(corner.lightness as f32).to_array(),
        };
        let vertices: Vec<TreeVertex> = corners.iter().map(vertex).collect();
        let color_indices = corners.iter().map(|corner| corner.color_index).collect();
        Self { vertices: Buffer::with(gpu, &VERTICES, &vertices), count: vertices.len() as u32, color_indices }
    }
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
    fn new(gpu: &Gpu, corners: &[TreeCorner], frame_px: u32) -> Self {
        let pictured = |corner: &TreeCorner| {
            let TreeCorner { at, normal, lightness, color_index, .. } = *corner;
            ImpostorCorner { at, normal, lightness, color_index }
        };
        let impostor = Impostor::draw(&corners.iter().map(pictured).collect::<Vec<_>>(), frame_px);
        let middle = impostor.middle.as_vec3().to_array();
        let reach = corners.iter().map(|corner| corner.at.truncate().length()).fold(0.0, f64::max);
        let (low, high) = corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
            (low.min(corner.at.z), high.max(corner.at.z))
        });
        // One texel wider, because a picture covers up to one texel more than the mesh.
        let more = 2.0 * impostor.radius / f64::from(frame_px);
        let cylinder = [reach + more, low - more, high + more, 0.0].map(|along| along as f32);
        let texels = texture(gpu, (PICTURES, wgpu::TextureFormat::Rgba16Float), &impostor, |level| &level.texels);
        let outlines = texture(gpu, (OUTLINES, wgpu::TextureFormat::Rg16Float), &impostor, |level| &level.outlines);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(OUTLINES),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let radius = impostor.radius as f32;
        let color_indices = impostor.levels.into_iter().map(|level| (level.frame_px, level.color_indices)).collect();
        Self { view: texels, outlines, sampler, middle, radius, cylinder, color_indices }
    }
}

fn texture<const CHANNELS: usize>(
    gpu: &Gpu,
    (name, format): (&'static str, wgpu::TextureFormat),
    impostor: &Impostor,
    texels_of: impl Fn(&Level) -> &[[half::f16; CHANNELS]],
) -> wgpu::TextureView {
    gpu.count_object();
    let extent = |level_px: u32| wgpu::Extent3d {
        width: FRAMES * level_px,
        height: FRAMES * level_px,
        depth_or_array_layers: 1,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: extent(impostor.frame_px),
        mip_level_count: impostor.levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (number, level) in impostor.levels.iter().enumerate() {
        let bits: Vec<u16> = texels_of(level).iter().flatten().map(|value| value.to_bits()).collect();
        let size = extent(level.frame_px);
        let bytes_per_row = Some((2 * CHANNELS) as u32 * size.width);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        let to = wgpu::TexelCopyTextureInfo { mip_level: number as u32, ..texture.as_image_copy() };
        gpu.queue.write_texture(to, bytemuck::cast_slice(&bits), layout, size);
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
