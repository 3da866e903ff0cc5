//! Chains → smoothed points with their arc lengths. See `shaders/lines/strokes/points.wgsl` and `lengths.wgsl`.

use super::chain::Chains;
use super::{Lists, MAX_FRAME_SEGMENTS};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::scan;
pub(crate) use crate::gpu::wgsl::shared::stroke_style::Point;
use crate::surface::edges::EdgeList;

const POINT_BYTES: u64 = size_of::<Point>() as u64;
/// Offsets in the arguments: workgroups per segment, workgroups per point.
const FOR_SEGMENTS: u64 = 0;
const FOR_POINTS: u64 = 16;
/// Index of the number of points in `StrokeCounts`.
const POINTS_INDEX: u32 = 3;

/// Smoothed points of all chains, one after another: [`Point`]s.
pub(crate) const POINTS: BufferKind = BufferKind::storage("stroke points");
/// Arc length from the first point of all chains, in 1/16 px.
pub(crate) const LENGTHS: BufferKind = BufferKind::storage("stroke lengths");
/// Workgroup counts of the indirect passes.
const ARGUMENTS: BufferKind = BufferKind::indirect("stroke arguments");

/// The points of a frame's strokes.
pub(crate) struct Points {
    /// [`POINTS`], one chain after another.
    pub list: Buffer,
    /// [`LENGTHS`], the arc lengths of the points.
    pub along: Buffer,
    arguments: Buffer,
}

impl Points {
    /// Returns the workgroup counts, as buffer and offset, for 256 threads per workgroup and one thread per segment,
    /// and so per chain.
    pub(crate) fn per_segment(&self) -> (&Buffer, u64) {
        (&self.arguments, FOR_SEGMENTS)
    }
}

/// Computes points and their arc lengths from segments and chains, and counts the points.
pub(crate) fn run(recorder: &mut Recorder<'_>, lists: &Lists, edges: &EdgeList, chains: &Chains) -> Points {
    // A chain of n segments has n + 1 points.
    let most = 2 * u64::from(MAX_FRAME_SEGMENTS);
    let points = Points {
        list: recorder.buffer(&POINTS, most * POINT_BYTES),
        along: recorder.buffer(&LENGTHS, most * 4),
        arguments: recorder.buffer(&ARGUMENTS, 32),
    };
    let resources = [lists.strokes(), edges.draw(), lists.counts(), ("arguments", points.arguments.binding())];
    recorder.groups("lines/strokes/arguments", [1, 1], &resources);
    let resources = [
        ("segments", lists.segments.binding()),
        chains.named(),
        ("places", chains.places.binding()),
        lists.counts(),
        edges.edges(),
        ("points", points.list.binding()),
    ];
    recorder.indirect("lines/strokes/points", &points.arguments, FOR_SEGMENTS, &resources);
    let resources = [("points", points.list.binding()), lists.counts(), ("lengths", points.along.binding())];
    recorder.indirect("lines/strokes/lengths", &points.arguments, FOR_POINTS, &resources);
    let numbers = &lists.counts;
    scan::run(
        recorder,
        &scan::Inputs { numbers, index: POINTS_INDEX, capacity: 2 * MAX_FRAME_SEGMENTS, values: &points.along },
    );
    points
}
