//! Heights → water maps: how far each sample of a tile is from the shore of the lake, or the sea, that it belongs to.
//!
//! [`blocks`] and [`classes`] tell the water that each sample belongs to, of a tile and around it, [`shores`] where the
//! shore is beside samples, [`columns`] and [`maps`] how far it is from all others. Software drivers run both sides of a
//! branch, so what has no water is left out by the numbers of workgroups, which [`begin`] writes. [`seen`] tells whether
//! a view has any water.
//!
//! Why: `docs/decisions/water.md`.

pub mod begin;
pub mod blocks;
pub mod classes;
pub mod columns;
pub mod maps;
pub mod seen;
pub mod shores;

use std::convert::Infallible;
use std::sync::Arc;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::map_job::MapJob;
use crate::gpu::wgsl::shared::shores::{FOUND, JOBS as JOB_COUNT};
use crate::gpu::wgsl::shared::water_maps::SIDE;
use crate::tiles::slot_maps::MAPS_AT_ONCE;
use crate::tiles::water_maps::WaterMaps;
use crate::world::given_water::GivenWater;

/// The tiles to make.
const JOBS: BufferKind = BufferKind::storage("lake jobs");
/// What was found in them.
const FOUND_KIND: BufferKind = BufferKind::storage("lakes found");
/// Of the tiles of one submit, for each sample.
const CLASSES: BufferKind = BufferKind::storage("lake classes");
const SHORES: BufferKind = BufferKind::storage("lake shores");
/// Squares of samples that may have a lake.
const SQUARES: BufferKind = BufferKind::storage("lake squares");
/// Water that is given.
const GIVEN: BufferKind = BufferKind::storage("given water");
/// Workgroups of passes.
const ARGUMENTS: BufferKind = BufferKind::indirect("lake arguments");

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
    /// What was found in the tiles.
    pub found: Buffer,
    /// For each sample: the water that it belongs to.
    pub classes: Buffer,
    /// For each sample: the shore beside it.
    pub shores: Buffer,
    /// Squares of samples that may have a lake.
    pub squares: Buffer,
    /// Workgroups of [`classes`], [`shores`], [`columns`] and [`maps`].
    pub arguments: Buffer,
    /// Water beside what heights show, if any is given.
    pub given: Option<Buffer>,
    /// Out.
    pub water_maps: Resource,
}

/// Water that is given, on the GPU.
struct GivenBuffer {
    water: Arc<GivenWater>,
    buffer: Buffer,
}

/// It stays there as long as it is asked for in each frame.
fn given_buffer(recorder: &mut Recorder<'_>, water: &Arc<GivenWater>) -> Buffer {
    let made = recorder.kept(
        |known: &GivenBuffer| Arc::ptr_eq(&known.water, water),
        |gpu| {
            let buffer = Buffer::with(gpu, &GIVEN, &water.words);
            Ok::<_, Infallible>(GivenBuffer { water: Arc::clone(water), buffer })
        },
    );
    let Ok(given) = made;
    given.buffer.clone()
}

/// Makes the maps that are planned for this frame; none most of the time. Reads `terrain`. No submit has more than a
/// frame of a window.
pub fn make(recorder: &mut Recorder<'_>, terrain: &[Named], maps: &WaterMaps, given: Option<&Arc<GivenWater>>) {
    // A prewarming run asks, for maps that will be planned.
    let nothing: &[&[_]] = if recorder.prewarms() { &[&[]] } else { &[] };
    let parts = maps.jobs().chunks(MAPS_AT_ONCE).chain(nothing.iter().copied());
    let given = given.map(|water| given_buffer(recorder, water));
    for (part, jobs) in parts.enumerate() {
        if part > 0 {
            recorder.submit_so_far();
        }
        let bytes = 4 * (SIDE * SIDE) as u64 * MAPS_AT_ONCE as u64;
        let mut found = [0_u32; FOUND as usize];
        found[JOB_COUNT as usize] = jobs.len() as u32;
        let inputs = Inputs {
            terrain,
            jobs,
            job_list: recorder.upload(&JOBS, jobs),
            sea_m: maps.key(),
            found: recorder.upload(&FOUND_KIND, &found),
            classes: recorder.buffer(&CLASSES, bytes),
            shores: recorder.buffer(&SHORES, bytes),
            squares: recorder.buffer(&SQUARES, bytes / 4),
            arguments: recorder.buffer(&ARGUMENTS, 12 * 4),
            given: given.clone(),
            water_maps: Resource::Texture("water maps", maps.view().clone()),
        };
        blocks::run(recorder, &inputs);
        begin::run(recorder, &inputs);
        classes::run(recorder, &inputs);
        begin::run(recorder, &inputs);
        shores::run(recorder, &inputs);
        columns::run(recorder, &inputs);
        maps::run(recorder, &inputs);
    }
}
