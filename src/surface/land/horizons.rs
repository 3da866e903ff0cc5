//! Heights → horizon maps: the horizon toward the sun and the visible part of the sky. See
//! `shaders/surface/land/horizons.wgsl`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
pub(crate) use crate::gpu::wgsl::surface::land::horizons::Horizons as HorizonsUniform;
use crate::tiles::horizon_maps::{HORIZON_MAP_SIDE, HorizonMaps};
use crate::tiles::slot_maps::MAPS_AT_ONCE;
use crate::tiles::terrain::HORIZON_MAPS;

/// The tiles whose maps are computed.
const JOBS: BufferKind = BufferKind::storage("horizon jobs");

/// Requests the pipeline, before there are maps.
pub(crate) fn prewarm(recorder: &mut Recorder<'_>) {
    recorder.groups("surface/land/horizons", [1, 1], &[]);
}

/// Computes the maps that `horizons` has planned for this frame; most frames have none. A frame for a file may have
/// planned hundreds: no submit computes more than one frame of a window does, because systems reset a GPU that is busy
/// for long.
pub(crate) fn run(recorder: &mut Recorder<'_>, terrain: &[Named], horizons: &HorizonMaps) {
    let maps = &horizons.maps;
    let uniform = HorizonsUniform { to_sun: maps.key().to_array(), pad_a: 0.0, pad_b: 0.0 };
    // A prewarming run dispatches an empty list, since maps will be planned later.
    let nothing: &[&[_]] = if recorder.prewarms() { &[&[]] } else { &[] };
    let parts = maps.jobs().chunks(MAPS_AT_ONCE).chain(nothing.iter().copied());
    for (part, jobs) in parts.enumerate() {
        if part > 0 {
            recorder.submit_so_far();
        }
        let mut resources = vec![
            ("horizons", recorder.uniform("horizons", &uniform)),
            ("jobs", recorder.upload(&JOBS, jobs).binding()),
            ("horizon_maps", Resource::Texture(HORIZON_MAPS, maps.view().clone())),
        ];
        resources.extend(terrain.iter().cloned());
        // The tiles are stacked along y.
        let side = HORIZON_MAP_SIDE.div_ceil(WORKGROUP_PX);
        recorder.groups("surface/land/horizons", [side, side * jobs.len() as u32], &resources);
    }
}
