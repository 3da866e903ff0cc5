//! Chains → smoothed points with their arc lengths. See `shaders/lines/strokes/points.wgsl`.

use super::chain::Chains;
use super::{Lists, MAX_FRAME_SEGMENTS};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{self, Count};
pub(crate) use crate::gpu::wgsl::shared::stroke_style::Point;
use crate::surface::edges::EdgeList;

const POINT_BYTES: u64 = size_of::<Point>() as u64;
/// Index of the number of points in `StrokeCounts`.
const POINTS_INDEX: u32 = 3;

/// Smoothed points of all chains, one after another: [`Point`]s.
pub(crate) const POINTS: BufferKind = BufferKind::storage("stroke points");
/// Arc length from the first point of all chains, in 1/16 px.
pub(crate) const LENGTHS: BufferKind = BufferKind::storage("stroke lengths");

/// The points of a frame's strokes.
pub(crate) struct Points {
    /// [`POINTS`], one chain after another.
    pub list: Buffer,
    /// [`LENGTHS`], the arc lengths of the points.
    pub along: Buffer,
}

/// Computes points and their arc lengths from segments and chains, and counts the points.
pub(crate) fn run(recorder: &mut Recorder<'_>, lists: &Lists, edges: &EdgeList, chains: &Chains) -> Points {
    // A chain of n segments has n + 1 points.
    let most = 2 * u64::from(MAX_FRAME_SEGMENTS);
    let points =
        Points { list: recorder.buffer(&POINTS, most * POINT_BYTES), along: recorder.buffer(&LENGTHS, most * 4) };
    let resources = [
        lists.strokes(),
        chains.plan(),
        edges.draw(),
        ("segments", lists.segments.binding()),
        chains.named(),
        ("places", chains.places.binding()),
        lists.counts(),
        edges.edges(),
        ("points", points.list.binding()),
        ("lengths", points.along.binding()),
    ];
    let (arguments, offset) = chains.per_segment();
    recorder.indirect("lines/strokes/points", arguments, offset, &resources);
    let (numbers, capacity) = (&lists.counts, 2 * MAX_FRAME_SEGMENTS);
    scan::run(recorder, Count::Counted { numbers, index: POINTS_INDEX, capacity }, &points.along);
    points
}
