//! Finds the farthest depth in each tile of the picture. See `shaders/surface/trees/tile_depth.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind, Targets};
use crate::gpu::wgsl::shared::tree_depth::TILE_PX;

/// The farthest depth in each tile of 8 × 8 pixels, before trees are drawn.
pub(crate) const TILE_DEPTH: TargetKind = TargetKind::storage(
    "tile depth",
    wgpu::TextureFormat::R32Float,
    Group::Trees.shows("Farthest depth in blocks of 8 × 8 pixels, which hides trees"),
);

/// Returns the target for the tiles of a picture.
pub(crate) fn target(gpu: &Gpu, targets: &mut Targets) -> Target {
    let tiles = targets.size_px().map(|side| side.div_ceil(TILE_PX));
    targets.sized(gpu, &TILE_DEPTH, tiles)
}

/// Finds the farthest depths of what has been drawn so far.
pub(super) fn run(recorder: &mut Recorder<'_>, view: &Resource, depth: &Target, tile_depth: &Target) {
    let resources = [("view", view.clone()), ("depth", depth.into()), ("tile_depth", tile_depth.into())];
    recorder.pixels("surface/trees/tile_depth", tile_depth.size_px(), &resources);
}
