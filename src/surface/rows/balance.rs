//! Widens marks to make up for bare land. See `shaders/surface/rows/balance.wgsl`.

use super::{RowPlan, rooms};
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;

/// Factor by which marks are widened, for each square of the picture.
const GAINS: BufferKind = BufferKind::storage("row gains");

/// Compares the ink of each square with the requested tone, and returns the factors by which marks are widened.
pub(crate) fn run(
    recorder: &mut Recorder<'_>,
    view: &Resource,
    plan: &RowPlan,
    inks: &Buffer,
    [distance, tone]: [&Target; 2],
) -> Buffer {
    let squares = rooms::squares(plan, tone.size_px());
    let gains = recorder.buffer(&GAINS, 4 * u64::from(squares));
    let resources = [
        ("view", view.clone()),
        ("rules", recorder.uniform("row rules", &plan.rules)),
        ("inks", inks.binding()),
        ("gains", gains.binding()),
        ("distance_m", distance.into()),
        ("tone", tone.into()),
    ];
    recorder.groups("surface/rows/balance", [squares.div_ceil(64), 1], &resources);
    gains
}
