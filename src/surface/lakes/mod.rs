//! Makes water maps of heights: the distance of each sample of a tile from the shore of its lake or of the sea.
//!
//! [`blocks`] and [`classes`] find the water that each sample of a tile and its surroundings belongs to, [`shores`] the
//! shore next to samples, [`columns`] and [`maps`] the distance of all other samples from it. Software drivers run both
//! sides of a branch, so samples without water are skipped by the workgroup counts, which [`begin`] writes. [`seen`]
//! reports whether a view has any water.
//!
//! Why: `docs/decisions/water.md`.

pub(crate) mod begin;
pub(crate) mod blocks;
pub(crate) mod classes;
pub(crate) mod columns;
pub(crate) mod maps;
pub(crate) mod seen;
pub(crate) mod shores;

use std::convert::Infallible;
use std::sync::Arc;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::map_job::MapJob;
use crate::gpu::wgsl::shared::shores::{FOUND, JOBS as JOB_COUNT};
use crate::gpu::wgsl::shared::water_maps::SIDE;
use crate::tiles::slot_maps::MAPS_AT_ONCE;
use crate::tiles::terrain::WATER_MAPS;
use crate::tiles::water_maps::WaterMaps;
use crate::world::given_water::GivenWater;

/// The tiles whose maps are computed.
const JOBS: BufferKind = BufferKind::storage("lake jobs");
/// Counts and lists of the findings in the tiles.
const FOUND_KIND: BufferKind = BufferKind::storage("lakes found");
/// For each sample of the tiles of one submit: the water that it belongs to.
const CLASSES: BufferKind = BufferKind::storage("lake classes");
const SHORES: BufferKind = BufferKind::storage("lake shores");
/// Squares of samples that may have a lake.
const SQUARES: BufferKind = BufferKind::storage("lake squares");
/// Water given by the scene.
const GIVEN: BufferKind = BufferKind::storage("given water");
/// Workgroup counts of the indirect passes.
const ARGUMENTS: BufferKind = BufferKind::indirect("lake arguments");
/// Offsets of the counts of [`classes`], [`shores`], [`columns`] and [`maps`] in [`ARGUMENTS`], in bytes.
const CLASSES_OFFSET: u64 = 0;
const SHORES_OFFSET: u64 = 12;
const COLUMNS_OFFSET: u64 = 24;
const MAPS_OFFSET: u64 = 36;

/// Inputs and outputs that the passes share.
pub(crate) struct Inputs<'a> {
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The tiles whose maps are computed.
    pub jobs: &'a [MapJob],
    /// `jobs` on the GPU.
    pub job_list: Buffer,
    /// Sea level in metres: samples at or below it are sea.
    pub sea_m: f32,
    /// Counts and lists of what was found in the tiles.
    pub found: Buffer,
    /// For each sample: the water that it belongs to.
    pub classes: Buffer,
    /// For each sample: the shore next to it.
    pub shores: Buffer,
    /// Squares of samples that may have a lake.
    pub squares: Buffer,
    /// Workgroup counts of [`classes`], [`shores`], [`columns`] and [`maps`].
    pub arguments: Buffer,
    /// Water given by the scene (a mask or polygons), in addition to the water that the heights show.
    pub given: Option<Buffer>,
    pub water_maps: Resource,
}

/// Water given by the scene, on the GPU.
struct GivenBuffer {
    water: Arc<GivenWater>,
    buffer: Buffer,
}

/// Returns the buffer of `water`. It is cached as long as every frame uses it.
fn given_buffer(recorder: &mut Recorder<'_>, water: &Arc<GivenWater>) -> Buffer {
    let made = recorder.cached(
        |known: &GivenBuffer| Arc::ptr_eq(&known.water, water),
        |gpu| {
            let buffer = Buffer::with(gpu, &GIVEN, &water.words);
            Ok::<_, Infallible>(GivenBuffer { water: Arc::clone(water), buffer })
        },
    );
    let Ok(given) = made;
    given.buffer.clone()
}

/// Computes the maps that are planned for this frame; most frames have none. No submit computes more than one frame of
/// a window does.
pub(crate) fn make(recorder: &mut Recorder<'_>, terrain: &[Named], maps: &WaterMaps, given: Option<&Arc<GivenWater>>) {
    // A prewarming run dispatches an empty list, since maps will be planned later.
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
            water_maps: Resource::Texture(WATER_MAPS, maps.view().clone()),
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
