//! The position of texture marks in a style whose land has rows. See `shaders/surface/rows/off_land.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};

/// [`POSITION`](crate::surface::POSITION) of models and trees; all 0 where land is seen.
pub(crate) const PLACE_OFF_LAND: TargetKind = TargetKind::storage("place off land", wgpu::TextureFormat::Rgba32Float);

/// Removes the land from a position. `view` is a `View`, and `place_off_land` a [`PLACE_OFF_LAND`].
pub(crate) fn run(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    surface_id: &Target,
    position: &Target,
    place_off_land: &Target,
) {
    let resources = [
        ("view", view.clone()),
        ("surface_id", surface_id.into()),
        ("position", position.into()),
        ("place_off_land", place_off_land.into()),
    ];
    recorder.pixels("surface/rows/off_land", place_off_land.size_px(), &resources);
}
