//! What an update saw, for the next one. See `shaders/lines/strokes/farthest.wgsl`.

use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};

/// Reversed depth of the farthest surface at a pixel and its neighbours, at the last update; it lasts to the next one.
pub const FARTHEST: TargetKind = TargetKind::storage("farthest", wgpu::TextureFormat::R32Float);

/// Keeps what `depth` has.
pub fn run(cx: &mut Cx<'_>, depth: &Target, farthest: &Target) {
    cx.pixels("lines/strokes/farthest", farthest.size_px(), &[("depth", depth.into()), ("farthest", farthest.into())]);
}
