//! Exclusive prefix sum of whole numbers, in place. See `shaders/lines/strokes/scan.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named};
use crate::gpu::timer::Recorder;

/// The most values of a scan: one workgroup has the sums of all blocks.
pub const MAX_VALUES: u32 = 1 << 21;

const BLOCK: u64 = 2048;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ScanSource {
    index: u32,
    capacity: u32,
}

crate::gpu::shared::describe!(ScanSource as "ScanSource" in "lines/strokes/scan_begin": index, capacity);

/// The pass: how much there is, blocks, their sums, places.
pub struct ScanPass {
    begin: ComputePass,
    scan: ComputePass,
    stages: Vec<GrowingBuffer>,
    size: wgpu::Buffer,
    arguments: wgpu::Buffer,
    sums: wgpu::Buffer,
}

/// Where a scan finds how many values it has: a buffer of `u32` that the GPU wrote, and a place in it.
pub struct ScanSize {
    index: u32,
    source: GrowingBuffer,
}

impl ScanSize {
    /// The number at `index` of the buffer that [`ScanPass::run`] gets, at most `capacity` and [`MAX_VALUES`].
    pub fn new(gpu: &Gpu, index: u32, capacity: u32) -> Self {
        let mut source = GrowingBuffer::new(gpu, "scan source", wgpu::BufferUsages::UNIFORM);
        source.write(gpu, &[ScanSource { index, capacity: capacity.min(MAX_VALUES) }]);
        Self { index, source }
    }

    /// The place of the number, counted in numbers.
    pub fn index(&self) -> u32 {
        self.index
    }
}

/// What a pass needs to write a list in order, whichever workgroup is quicker: see `shaders/shared/ordered.wgsl`.
pub struct Ordered {
    stages: Vec<GrowingBuffer>,
    size: ScanSize,
    group_count: wgpu::Buffer,
    group_starts: GrowingBuffer,
}

impl Ordered {
    /// For a pass of so many stages.
    pub fn new(gpu: &Gpu, stages: u32) -> Self {
        Self {
            // No uniforms: a fourth uniform buffer makes lavapipe 22.3 write past its memory. See
            // `docs/decisions/software-drivers.md`.
            stages: numbers_in(gpu, stages, wgpu::BufferUsages::STORAGE),
            size: ScanSize::new(gpu, 0, MAX_VALUES),
            group_count: buffer(gpu, "group count", 4, wgpu::BufferUsages::STORAGE),
            group_starts: GrowingBuffer::new(gpu, "group starts", wgpu::BufferUsages::STORAGE),
        }
    }

    /// Runs all stages of `pass` over `groups` workgroups, that may keep `kept` numbers each; a third stage, if there is
    /// one, is a single workgroup.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        pass: &ComputePass,
        scan: &ScanPass,
        groups: [u32; 2],
        kept: u64,
        resources: &[Named<'_>],
    ) {
        let count = u64::from(groups[0]) * u64::from(groups[1]);
        self.group_starts.reserve_exactly(gpu, 4 * (count * (1 + kept) + 1));
        for (stage, uniform) in self.stages.iter().enumerate() {
            let mut all = vec![
                ("stage", uniform.binding()),
                ("group_count", self.group_count.as_entire_binding()),
                ("group_starts", self.group_starts.binding()),
            ];
            all.extend(resources.iter().cloned());
            pass.run_groups(gpu, recorder, if stage < 2 { groups } else { [1, 1] }, &all);
            if stage == 0 {
                scan.run(gpu, recorder, &self.size, &self.group_count, self.group_starts.buffer());
            }
        }
    }
}

impl ScanPass {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        Self {
            begin: ComputePass::new(gpu, "lines/strokes/scan_begin"),
            scan: ComputePass::new(gpu, "lines/strokes/scan"),
            stages: numbers(gpu, 3),
            size: buffer(gpu, "scan size", 4, storage),
            arguments: buffer(gpu, "scan arguments", 12, storage | wgpu::BufferUsages::INDIRECT),
            sums: buffer(gpu, "scan sums", 4 * u64::from(MAX_VALUES) / BLOCK, storage),
        }
    }

    /// Reads the number of values, `size` in `numbers`; replaces each of `values` by the sum of those before it, modulo
    /// 2³². The value after the last becomes the sum of all if the buffer has room for it. Both buffers have the usage
    /// `STORAGE`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size: &ScanSize,
        numbers: &wgpu::Buffer,
        values: &wgpu::Buffer,
    ) {
        let resources = [
            ("source", size.source.binding()),
            ("numbers", numbers.as_entire_binding()),
            ("size", self.size.as_entire_binding()),
            ("arguments", self.arguments.as_entire_binding()),
        ];
        self.begin.run_groups(gpu, recorder, [1, 1], &resources);
        for (stage, uniform) in self.stages.iter().enumerate() {
            let resources = [
                ("stage", uniform.binding()),
                ("size", self.size.as_entire_binding()),
                ("sums", self.sums.as_entire_binding()),
                ("values", values.as_entire_binding()),
            ];
            if stage == 1 {
                self.scan.run_groups(gpu, recorder, [1, 1], &resources);
            } else {
                self.scan.run_indirect(gpu, recorder, &self.arguments, 0, &resources);
            }
        }
    }
}

/// Uniforms that hold 0, 1, 2 and so on: which stage or turn of a pass it is.
pub(super) fn numbers(gpu: &Gpu, count: u32) -> Vec<GrowingBuffer> {
    numbers_in(gpu, count, wgpu::BufferUsages::UNIFORM)
}

fn numbers_in(gpu: &Gpu, count: u32, usage: wgpu::BufferUsages) -> Vec<GrowingBuffer> {
    let buffer = |number: u32| {
        let mut buffer = GrowingBuffer::new(gpu, "number", usage);
        buffer.write(gpu, &[number]);
        buffer
    };
    (0..count).map(buffer).collect()
}

/// A buffer that only the GPU writes; `usage` gains `COPY_SRC`, for tests and files.
pub(super) fn buffer(gpu: &Gpu, label: &'static str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let usage = usage | wgpu::BufferUsages::COPY_SRC;
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}
