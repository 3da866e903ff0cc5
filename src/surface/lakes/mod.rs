//! Heights → water maps: how far each sample of a tile is from the shore of the lake, or the sea, that it belongs to.
//!
//! [`classes`] tells the water that each sample belongs to, of a tile and around it, [`shores`] where the shore is beside
//! samples, [`columns`] and [`maps`] how far it is from all others.
//!
//! Why: `docs/decisions/water.md`.

pub mod classes;
pub mod columns;
pub mod maps;
pub mod shores;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;
use crate::gpu::wgsl::shared::map_job::MapJob;
use crate::gpu::wgsl::shared::water_maps::SIDE;
use crate::tiles::slot_maps::MAPS_AT_ONCE;
use crate::tiles::water_maps::WaterMaps;

/// The tiles to make.
const JOBS: BufferKind = BufferKind::storage("lake jobs");
/// Whether there is water in each.
const FOUND: BufferKind = BufferKind::storage("lakes found");
/// Of the tiles of one submit, for each sample.
const CLASSES: BufferKind = BufferKind::storage("lake classes");
const SHORES: BufferKind = BufferKind::storage("lake shores");

/// What the passes share.
pub struct Inputs<'a> {
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// The tiles that are made.
    pub jobs: &'a [MapJob],
    /// The same on the GPU.
    pub job_list: Buffer,
    /// What is no higher is the sea, in metres.
    pub sea_m: f32,
    /// For each tile: whether it has any water.
    pub found: Buffer,
    /// For each sample: the water that it belongs to.
    pub classes: Buffer,
    /// For each sample: the shore beside it.
    pub shores: Buffer,
    /// Out.
    pub water_maps: Resource,
}

/// Makes the maps that are planned for this frame; none most of the time. Reads `terrain`. No submit has more than a
/// frame of a window.
pub fn make(cx: &mut Cx<'_>, terrain: &[Named], maps: &WaterMaps) {
    // A rehearsal asks, for maps that will be planned.
    let nothing: &[&[_]] = if cx.rehearses() { &[&[]] } else { &[] };
    let parts = maps.jobs().chunks(MAPS_AT_ONCE).chain(nothing.iter().copied());
    for (part, jobs) in parts.enumerate() {
        if part > 0 {
            cx.submit_so_far();
        }
        let bytes = 4 * (SIDE * SIDE) as u64 * MAPS_AT_ONCE as u64;
        let inputs = Inputs {
            terrain,
            jobs,
            job_list: cx.upload(&JOBS, jobs),
            sea_m: maps.key(),
            found: cx.upload(&FOUND, &[0_u32; MAPS_AT_ONCE]),
            classes: cx.buffer(&CLASSES, bytes),
            shores: cx.buffer(&SHORES, bytes),
            water_maps: Resource::Texture("water maps", maps.view().clone()),
        };
        classes::run(cx, &inputs);
        shores::run(cx, &inputs);
        columns::run(cx, &inputs);
        maps::run(cx, &inputs);
    }
}
