//! From a world and a view to pictures of its surface: depth and id, then position and normal, then motion.
//!
//! A surface has a kind ([`id`]). Each kind rasterises itself, resolves its pixels and offers its edges to one list
//! ([`edges`]); lines and tones know the pictures and that list, and no kind.

pub mod id;
pub mod edges;
pub mod hidden;
pub mod local_color;
pub mod land;
pub mod meshes;
pub mod trees;
pub mod mark_normal;
pub mod form;
pub mod lakes;
pub mod water;
pub mod curvature;
pub mod bend_axis;
pub mod cuts;
pub mod height_lines;
pub mod rims;
pub mod rows;
pub mod motion;

use crate::gpu::target::TargetKind;

/// Reversed depth: near / distance along the view axis; 0 is the sky.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// [`id`]s; 0 is the sky.
pub const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Of the surface as it was rasterised.
pub const DEPTH: TargetKind = TargetKind::attachment("depth", DEPTH_FORMAT);
/// What is seen at each pixel.
pub const SURFACE_ID: TargetKind = TargetKind::attachment("surface id", ID_FORMAT);
/// xyz: metres from the rig's origin; w: distance along the view axis. All 0 is the sky.
pub const POSITION: TargetKind = TargetKind::storage("position", wgpu::TextureFormat::Rgba32Float);
/// xyz: unit, in the world; 0 is the sky.
pub const NORMAL: TargetKind = TargetKind::storage("normal", wgpu::TextureFormat::Rgba32Float);
