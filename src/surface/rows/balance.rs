//! By how much marks are wider. See `shaders/surface/rows/balance.wgsl`.

use super::{RowPlan, rooms};
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// By how much, in squares of the picture.
const GAINS: BufferKind = BufferKind::storage("row gains");

/// Holds ink against what is asked for.
pub fn run(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    plan: &RowPlan,
    inks: &Buffer,
    [position, tone]: [&Target; 2],
) -> Buffer {
    let squares = rooms::squares(plan, tone.size_px());
    let gains = recorder.buffer(&GAINS, 4 * u64::from(squares));
    let resources = [
        ("view", view.clone()),
        ("rules", recorder.uniform("row rules", &plan.rules)),
        ("inks", inks.binding()),
        ("gains", gains.binding()),
        ("position", position.into()),
        ("tone", tone.into()),
    ];
    recorder.groups("surface/rows/balance", [squares.div_ceil(64), 1], &resources);
    gains
}
