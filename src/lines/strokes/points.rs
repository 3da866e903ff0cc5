//! Chains → smoothed points with their arc lengths. See `shaders/lines/strokes/points.wgsl` and `lengths.wgsl`.

use bytemuck::{Pod, Zeroable};

use super::chain::ChainPass;
use super::scan::{ScanPass, ScanSize};
use super::{Lists, MOST_PIECES};
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::ComputePass;
use crate::gpu::timer::Recorder;

/// A point of a stroke.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Point {
    /// On the picture.
    pub px: [f32; 2],
    /// Distance along the view axis.
    pub depth_m: f32,
    /// Whose it is.
    pub chain: u32,
    /// Of the edge that begins here: [`Edge::kind`](super::Edge::kind).
    pub kind: u32,
    /// Nothing.
    pub padding: u32,
}

crate::gpu::shared::describe!(Point as "Point" in "lines/strokes/points": px, depth_m, chain, kind, padding);

/// Bytes of a point.
const POINT_BYTES: u64 = size_of::<Point>() as u64;
/// In the arguments: workgroups for pieces, workgroups for points.
const FOR_PIECES: u64 = 0;
const FOR_POINTS: u64 = 16;
/// Where `StrokeCounts` has the number of points.
const POINTS_INDEX: u32 = 3;

/// The passes, and what they make.
pub struct PointsPass {
    count: ComputePass,
    points: ComputePass,
    lengths: ComputePass,
    size: ScanSize,
    arguments: wgpu::Buffer,
    /// Places on the picture, distances, chains.
    list: GrowingBuffer,
    /// Arc lengths since the first point of all, in 1/16 px.
    along: GrowingBuffer,
}

impl PointsPass {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        let read = Usage::STORAGE | Usage::COPY_SRC;
        Self {
            count: ComputePass::new(gpu, "lines/strokes/arguments"),
            points: ComputePass::new(gpu, "lines/strokes/points"),
            lengths: ComputePass::new(gpu, "lines/strokes/lengths"),
            size: ScanSize::new(gpu, POINTS_INDEX, 2 * MOST_PIECES),
            arguments: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stroke arguments"),
                size: 32,
                usage: Usage::STORAGE | Usage::INDIRECT,
                mapped_at_creation: false,
            }),
            list: GrowingBuffer::new(gpu, "stroke points", read),
            along: GrowingBuffer::new(gpu, "stroke lengths", read),
        }
    }

    /// Makes room for the points of `pieces` pieces.
    pub fn reserve(&mut self, gpu: &Gpu, pieces: u32) {
        // A chain of n pieces has n + 1 points.
        self.list.reserve_exactly(gpu, 2 * u64::from(pieces) * POINT_BYTES);
        self.along.reserve_exactly(gpu, 2 * u64::from(pieces) * 4);
    }

    /// Reads pieces and chains; writes points, their arc lengths, and how many there are.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, lists: &Lists, chain: &ChainPass, scan: &ScanPass) {
        let resources = [
            lists.strokes(),
            ("edge_draw", lists.edge_draw.binding()),
            lists.counts(),
            ("arguments", self.arguments.as_entire_binding()),
        ];
        self.count.run_groups(gpu, recorder, [1, 1], &resources);
        let resources = [
            ("pieces", lists.pieces.binding()),
            ("ordered", chain.ordered().as_entire_binding()),
            chain.named_chains(),
            ("places", chain.places().as_entire_binding()),
            lists.counts(),
            ("edges", lists.edges.binding()),
            ("points", self.list.binding()),
        ];
        self.points.run_indirect(gpu, recorder, &self.arguments, FOR_PIECES, &resources);
        let resources = [("points", self.list.binding()), lists.counts(), ("lengths", self.along.binding())];
        self.lengths.run_indirect(gpu, recorder, &self.arguments, FOR_POINTS, &resources);
        scan.run(gpu, recorder, &self.size, lists.counts.buffer(), self.along.buffer());
    }

    /// The points.
    pub fn list(&self) -> &GrowingBuffer {
        &self.list
    }

    /// The arc lengths.
    pub fn along(&self) -> &GrowingBuffer {
        &self.along
    }

    /// Workgroups of 256 for each piece, and so for each chain: the buffer and its offset.
    pub fn per_piece(&self) -> (&wgpu::Buffer, u64) {
        (&self.arguments, FOR_PIECES)
    }
}
