//! The distance of texture marks in a style whose land has rows. See `shaders/surface/rows/off_land.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// [`DISTANCE`](crate::surface::DISTANCE) of models and trees; 0 where land is seen.
pub(crate) const DISTANCE_OFF_LAND: TargetKind = TargetKind::storage(
    "distance off land",
    wgpu::TextureFormat::R32Float,
    Group::Surface.shows("Distance of models and trees along the view axis, in metres; 0 elsewhere"),
);

/// Removes the land from distances. `view` is a `View`, and `distance_off_land` a [`DISTANCE_OFF_LAND`].
pub(crate) fn run(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    surface_id: &Target,
    distance: &Target,
    distance_off_land: &Target,
) {
    let resources = [
        ("view", view.clone()),
        ("surface_id", surface_id.into()),
        ("distance_m", distance.into()),
        ("distance_off_land_m", distance_off_land.into()),
    ];
    recorder.pixels("surface/rows/off_land", distance_off_land.size_px(), &resources);
}
