//! What all forests of the same species share: points, meshes and pictures on the GPU.

use super::place::TreePoint;
use super::raster::TreeVertex;
use crate::forest::impostor::{FRAMES, Impostor, ImpostorCorner};
use crate::forest::points::Points;
use crate::forest::species::{Corner, Detail, Grown, Part, canopy};
use crate::gpu::Gpu;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::scene::forest::Form;

/// [`TreePoint`]s of a tile, level by level.
const POINTS: BufferKind = BufferKind::storage("tree points");
/// [`TreeVertex`]s of a mesh.
const VERTICES: BufferKind = BufferKind::storage("tree vertices");
const PICTURES: &str = "tree pictures";
/// Sides of pictures of a tree, and of a piece of canopy.
const TREE_PX: u32 = 128;
const CANOPY_PX: u32 = 40;

/// Triangles on the GPU.
pub(super) struct TreeMesh {
    pub vertices: Buffer,
    pub count: u32,
}

/// A species as it is drawn.
pub(super) struct SpeciesModel {
    pub near: TreeMesh,
    pub middle: TreeMesh,
    pub alone: TreePictures,
    pub canopy: TreePictures,
    /// How far its crown reaches, by its height.
    pub crown: f32,
}

/// Pictures on the GPU.
pub(super) struct TreePictures {
    pub view: wgpu::TextureView,
    /// Of their sphere, in tree units.
    pub middle: [f32; 3],
    pub radius: f32,
}

pub(super) struct Shared {
    pub forms: Vec<Form>,
    pub points: Points,
    pub point_buffer: Buffer,
    pub species: Vec<SpeciesModel>,
}

impl Shared {
    /// Grows them.
    pub fn new(gpu: &Gpu, forms: Vec<Form>) -> Self {
        let points = Points::new();
        let packed: Vec<TreePoint> = points
            .points
            .iter()
            .map(|point| TreePoint { at: point.at.map(|along| along as f32), number: point.number, padding: 0 })
            .collect();
        let species = forms.iter().map(|form| SpeciesModel::new(gpu, *form)).collect();
        Self { point_buffer: Buffer::with(gpu, &POINTS, &packed), points, species, forms }
    }
}

impl SpeciesModel {
    fn new(gpu: &Gpu, form: Form) -> Self {
        let grown = match form {
            Form::Conifer => Grown::Conifer,
            Form::Broadleaf => Grown::Broadleaf,
            Form::Birch => Grown::Birch,
            Form::Snag => Grown::Snag,
        };
        let [near, middle] = [Detail::Near, Detail::Middle].map(|detail| grown.grow(detail));
        // What lies farther out are single twigs.
        let mut reaches: Vec<f64> = near.iter().map(|corner| corner.at.truncate().length()).collect();
        reaches.sort_by(f64::total_cmp);
        let crown = reaches.get(reaches.len() * 9 / 10).copied().unwrap_or(0.2);
        let mesh = |corners: &[Corner]| TreeMesh::new(gpu, form, corners);
        Self {
            near: mesh(&near),
            middle: mesh(&middle),
            alone: TreePictures::new(gpu, form, &near, TREE_PX),
            canopy: TreePictures::new(gpu, form, &canopy(grown), CANOPY_PX),
            crown: crown as f32,
        }
    }
}

impl TreeMesh {
    fn new(gpu: &Gpu, form: Form, corners: &[Corner]) -> Self {
        let vertex = |corner: &Corner| TreeVertex {
            at: corner.at.as_vec3().extend(corner.sway as f32).to_array(),
            normal: corner.normal.as_vec3().extend(lightness(form, corner.part) as f32).to_array(),
        };
        let vertices: Vec<TreeVertex> = corners.iter().map(vertex).collect();
        Self { vertices: Buffer::with(gpu, &VERTICES, &vertices), count: vertices.len() as u32 }
    }
}

/// Of what a tree is made of, where bare land is 1.
fn lightness(form: Form, part: Part) -> f64 {
    match (form, part) {
        (Form::Conifer, Part::Leaf) => 0.5,
        (Form::Broadleaf, Part::Leaf) => 0.62,
        (Form::Birch, Part::Leaf) => 0.74,
        (Form::Birch, Part::Bark) => 0.97,
        (Form::Snag, _) => 0.75,
        (Form::Conifer | Form::Broadleaf, Part::Bark) => 0.45,
    }
}

impl TreePictures {
    fn new(gpu: &Gpu, form: Form, corners: &[Corner], frame_px: u32) -> Self {
        let pictured = |corner: &Corner| ImpostorCorner {
            at: corner.at,
            normal: corner.normal,
            lightness: lightness(form, corner.part),
        };
        let impostor = Impostor::take(&corners.iter().map(pictured).collect::<Vec<_>>(), frame_px);
        let middle = impostor.middle.as_vec3().to_array();
        Self { view: texture(gpu, &impostor), middle, radius: impostor.radius as f32 }
    }
}

fn texture(gpu: &Gpu, impostor: &Impostor) -> wgpu::TextureView {
    gpu.count_object();
    let side = FRAMES * impostor.frame_px;
    let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(PICTURES),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let texels: Vec<[u16; 4]> = impostor.texels.iter().map(|texel| texel.map(half::f16::to_bits)).collect();
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * side), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&texels), layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
