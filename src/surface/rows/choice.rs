//! The proposals that are drawn. See `shaders/surface/rows/choice.wgsl`.

use super::RowPlan;
use super::proposals::Proposals;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::row_places::{CELLS_PER_SPACING, CHOICE_ROUNDS, RASTER_MARGIN, RowPlaces};

/// The mark that claims each cell, with its priority.
const CLAIMS: BufferKind = BufferKind::storage("row claims");
/// The drawn mark that occupies each cell.
const TAKEN: BufferKind = BufferKind::storage("row cells taken");
/// Stages of a round.
const STAGES: u32 = 2;

/// Selects a maximal set of marks that keep their distance; returns the bindings of `shaders/shared/row_places.wgsl`,
/// with the raster of the marks that are drawn.
pub(crate) fn run(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    plan: &RowPlan,
    proposals: &Proposals,
    size_px: [u32; 2],
) -> Vec<Named> {
    let spacing_px = plan.rules.spacing_px.max(1e-3);
    let size = size_px
        .map(|side| ((side as f32 + 2.0 * RASTER_MARGIN * spacing_px) * CELLS_PER_SPACING / spacing_px).ceil() as u32);
    let [claims, taken] =
        [&CLAIMS, &TAKEN].map(|kind| recorder.buffer(kind, 4 * u64::from(size[0]) * u64::from(size[1])));
    recorder.reset_to_zero(&claims);
    recorder.reset_to_zero(&taken);
    let rules = recorder.uniform("row rules", &plan.rules);
    let shared = |recorder: &mut Recorder<'_>, places: RowPlaces, near: &Buffer| {
        vec![
            ("view", view.clone()),
            ("rules", rules.clone()),
            ("places", recorder.uniform("row places", &places)),
            ("proposed", proposals.count.binding()),
            ("proposals", proposals.all.binding()),
            ("near", near.binding()),
        ]
    };
    for number in 0..CHOICE_ROUNDS * STAGES {
        let places = RowPlaces { size, round: number / STAGES, stage: number % STAGES };
        let [near, raster] = if places.stage == 0 { [&taken, &claims] } else { [&claims, &taken] };
        let mut resources = shared(recorder, places, near);
        resources.push(("raster", raster.binding()));
        recorder.groups("surface/rows/choice", [plan.rules.max_marks.div_ceil(64), 1], &resources);
    }
    shared(recorder, RowPlaces { size, ..RowPlaces::default() }, &taken)
}
