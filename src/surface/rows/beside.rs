//! The position of texture marks in a style whose land has rows. See `shaders/surface/rows/beside.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// [`POSITION`](crate::surface::POSITION) of models and trees; all 0 where land is seen.
pub const PLACE_BESIDE: TargetKind = TargetKind::storage("place beside", wgpu::TextureFormat::Rgba32Float);

/// Removes the land from a position. `view` is a `View`, and `place_beside` a [`PLACE_BESIDE`].
pub fn run(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    surface_id: &Target,
    position: &Target,
    place_beside: &Target,
) {
    let resources = [
        ("view", view.clone()),
        ("surface_id", surface_id.into()),
        ("position", position.into()),
        ("place_beside", place_beside.into()),
    ];
    recorder.pixels("surface/rows/beside", place_beside.size_px(), &resources);
}
