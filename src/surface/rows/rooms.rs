//! The room of each mark, that is the gap between its neighbours, and its ink. See `shaders/surface/rows/rooms.wgsl`.

use super::RowPlan;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::shared::row_ink::SQUARE;

/// Ink in each square of the picture.
const INKS: BufferKind = BufferKind::storage("row inks");

/// Returns the number of squares, as in `shaders/shared/row_ink.wgsl`.
pub(super) fn squares(plan: &RowPlan, size_px: [u32; 2]) -> u32 {
    let side_px = ((SQUARE * plan.rules.spacing_px).ceil() as u32).max(1);
    size_px.map(|side| side.div_ceil(side_px)).iter().product()
}

/// Measures the rooms, with the resources that `choice` returned, and returns the ink of each square.
pub(crate) fn run(recorder: &mut Recorder<'_>, plan: &RowPlan, places: &[Named], tone: &Target) -> Buffer {
    let inks = recorder.buffer(&INKS, 4 * u64::from(squares(plan, tone.size_px())));
    recorder.reset_to_zero(&inks);
    let mut resources = places.to_vec();
    resources.extend([("inks", inks.binding()), ("tone", tone.into())]);
    recorder.groups("surface/rows/rooms", [plan.rules.max_marks.div_ceil(64), 1], &resources);
    inks
}
