//! From a world and a view to pictures of its surface: depth and surface id, then position and normal, then motion.
//!
//! A surface has a kind ([`id`]). Each kind rasterises itself, resolves its pixels and adds its edges to one list
//! ([`edges`]); lines and tones read the pictures and that list, and do not depend on the kind.

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
pub mod rims;
pub mod rows;
pub mod motion;

use crate::gpu::target::TargetKind;

/// Reversed depth: near / distance along the view axis; 0 is the sky.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// [`id`]s; 0 is the sky.
pub const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Depth as rasterised, that is of the mesh and not of the bicubic surface.
pub const DEPTH: TargetKind = TargetKind::attachment("depth", DEPTH_FORMAT);
/// The [`id`] of the surface that is seen at each pixel.
pub const SURFACE_ID: TargetKind = TargetKind::attachment("surface id", ID_FORMAT);
/// xyz: metres from the rig's origin; w: distance along the view axis. All 0 in the sky.
pub const POSITION: TargetKind = TargetKind::storage("position", wgpu::TextureFormat::Rgba32Float);
/// xyz: unit normal in world space; 0 in the sky.
pub const NORMAL: TargetKind = TargetKind::storage("normal", wgpu::TextureFormat::Rgba32Float);
