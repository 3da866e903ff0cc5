//! Heights → what the land sees of the sun and of the sky. See `shaders/surface/horizons.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::recorder::{Cx, WORKGROUP_PX};
use crate::tiles::horizon_maps::{HORIZON_MAP_SIDE, HorizonMaps};

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct HorizonsUniform {
    to_sun: [f32; 2],
    pad_a: f32,
    pad_b: f32,
}

crate::gpu::shared::describe!(HorizonsUniform as "Horizons" in "surface/horizons": to_sun, pad_a, pad_b);

/// The tiles to make.
const JOBS: BufferKind = BufferKind::storage("horizon jobs");

/// Makes the tiles that `seen` has planned for this frame; none most of the time. Reads `terrain`.
pub fn run(cx: &mut Cx<'_>, terrain: &[Named], seen: &HorizonMaps) {
    let jobs = seen.jobs();
    if jobs.is_empty() && !cx.rehearses() {
        return;
    }
    let uniform = HorizonsUniform { to_sun: seen.to_sun().to_array(), pad_a: 0.0, pad_b: 0.0 };
    let mut resources = vec![
        ("horizons", cx.uniform("horizons", &uniform)),
        ("jobs", cx.upload(&JOBS, jobs).binding()),
        ("seen_tiles", Resource::Texture("horizon maps", seen.view().clone())),
    ];
    resources.extend(terrain.iter().cloned());
    // Tiles stand below each other.
    let side = HORIZON_MAP_SIDE.div_ceil(WORKGROUP_PX);
    cx.groups("surface/horizons", [side, side * jobs.len() as u32], &resources);
}
