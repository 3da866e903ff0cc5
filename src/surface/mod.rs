//! From a world and a view to pictures of its surface: depth and surface id, then distance and normal
//! ([`seen`]), then motion.
//!
//! A surface has a kind ([`id`]). Each kind rasterises itself, resolves its pixels and adds its edges to one list
//! ([`edges`]); lines and tones read the pictures and that list, and do not depend on the kind.

pub(crate) mod id;
pub(crate) mod seen;
pub(crate) mod edges;
pub(crate) mod hidden;
pub(crate) mod local_color;
pub(crate) mod land;
pub(crate) mod meshes;
pub(crate) mod trees;
pub(crate) mod mark_normal;
pub(crate) mod form;
pub(crate) mod draped_image;
pub(crate) mod lakes;
pub(crate) mod water;
pub(crate) mod curvature;
pub(crate) mod bend_axis;
pub(crate) mod ladder;
pub(crate) mod rims;
pub(crate) mod rows;
pub(crate) mod motion;

pub use self::seen::DISTANCE;
pub(crate) use self::seen::{NORMAL, NORMAL_AND_LIGHTNESS};
use crate::gpu::target::{Group, TargetKind};

/// Reversed depth: near / distance along the view axis; 0 is the sky.
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// [`id`]s; 0 is the sky.
pub(crate) const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Depth as rasterised, that is of the mesh and not of the bicubic surface.
pub(crate) const DEPTH: TargetKind = TargetKind::attachment(
    "depth",
    DEPTH_FORMAT,
    Group::Surface.shows("Reversed depth of the rasteriser: nearer is greater"),
);
/// The [`id`] of the surface that is seen at each pixel.
pub(crate) const SURFACE_ID: TargetKind = TargetKind::attachment(
    "surface id",
    ID_FORMAT,
    Group::Surface.shows("Each patch of the land, each model and each tree in a colour of its own"),
);
