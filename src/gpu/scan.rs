//! Exclusive prefix sum of whole numbers, in place. See `shaders/gpu/scan.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::gpu::scan_begin::ScanSource;

/// The most values of a scan: one workgroup has the sums of all blocks.
pub const MAX_VALUES: u32 = 1 << 21;

const BLOCK: u64 = 2048;

/// How many values there are.
const SIZE: BufferKind = BufferKind::storage("scan size");
/// Workgroups for them.
const ARGUMENTS: BufferKind = BufferKind::indirect("scan arguments");
/// Of blocks.
const SUMS: BufferKind = BufferKind::storage("scan sums");

/// What is summed.
pub struct Inputs<'a> {
    /// Numbers that the GPU wrote.
    pub numbers: &'a Buffer,
    /// Which of them says how many values there are.
    pub index: u32,
    /// At most so many, and [`MAX_VALUES`].
    pub capacity: u32,
    /// In and out.
    pub values: &'a Buffer,
}

/// Replaces each value by the sum of those before it, modulo 2³². The value after the last becomes the sum of all if
/// the buffer has room for it.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let source = ScanSource { index: inputs.index, capacity: inputs.capacity.min(MAX_VALUES) };
    let size = recorder.buffer(&SIZE, 4);
    let arguments = recorder.buffer(&ARGUMENTS, 12);
    let sums = recorder.buffer(&SUMS, 4 * u64::from(MAX_VALUES) / BLOCK);
    let resources = [
        ("source", recorder.uniform("scan source", &source)),
        ("numbers", inputs.numbers.binding()),
        ("size", size.binding()),
        ("arguments", arguments.binding()),
    ];
    recorder.groups("gpu/scan_begin", [1, 1], &resources);
    for stage in 0_u32..3 {
        let resources = [
            ("stage", recorder.uniform("stage", &stage)),
            ("size", size.binding()),
            ("sums", sums.binding()),
            ("values", inputs.values.binding()),
        ];
        if stage == 1 {
            recorder.groups("gpu/scan", [1, 1], &resources);
        } else {
            recorder.indirect("gpu/scan", &arguments, 0, &resources);
        }
    }
}

/// `Order` in `shaders/shared/ordered.wgsl`.
const ORDER: BufferKind = BufferKind::storage("order");
/// Where its list begins: the largest alignment of offsets.
const ORDER_HEAD_BYTES: u64 = 256;

/// How many workgroups an ordered pass has.
#[derive(Clone, Copy)]
pub enum Groups<'a> {
    /// In x and y.
    Of([u32; 2]),
    /// As the GPU counted them.
    Counted {
        /// From `offset` on: workgroups in x, y and z, and their number.
        arguments: &'a Buffer,
        /// In bytes.
        offset: u64,
        /// Not more; a last row of 65,535 may be filled up.
        most: u32,
    },
}

/// Workgroups in a row of counted ones.
const ROW: u32 = crate::gpu::wgsl::shared::dispatch::GROUPS_IN_ROW;

impl Groups<'_> {
    fn most(&self) -> u32 {
        match self {
            Self::Of([x, y]) => x * y,
            Self::Counted { most, .. } if *most > ROW => most.next_multiple_of(ROW),
            Self::Counted { most, .. } => *most,
        }
    }
}

/// A pass that writes a list in order, whichever workgroup is quicker: see `shaders/shared/ordered.wgsl`.
pub struct Ordered<'a> {
    /// Its shader.
    pub shader: Compute,
    /// Two, or three: the third is a single workgroup.
    pub stages: u32,
    /// Its workgroups.
    pub groups: Groups<'a>,
    /// Numbers that each workgroup may keep.
    pub kept: u64,
}

impl Ordered<'_> {
    /// Runs all stages.
    pub fn run(&self, recorder: &mut Recorder<'_>, resources: &[Named]) {
        let bytes = 4 * (u64::from(self.groups.most()) * (1 + self.kept) + 1);
        let order = recorder.buffer(&ORDER, (ORDER_HEAD_BYTES + bytes).next_power_of_two());
        let starts = order.slice(ORDER_HEAD_BYTES, order.raw.size() - ORDER_HEAD_BYTES);
        let mut all = vec![("order", order.binding())];
        all.extend(resources.iter().cloned());
        for stage in 0..self.stages {
            let shader = self.shader;
            match self.groups {
                Groups::Of([x, y]) => {
                    recorder.write(&order, &[stage, x * y]);
                    recorder.groups(shader, if stage < 2 { [x, y] } else { [1, 1] }, &all);
                }
                Groups::Counted { arguments, offset, .. } => {
                    recorder.write(&order, &[stage]);
                    recorder.copy((arguments, offset + 12), (&order, 4), 4);
                    if stage < 2 {
                        recorder.indirect(shader, arguments, offset, &all);
                    } else {
                        recorder.groups(shader, [1, 1], &all);
                    }
                }
            }
            if stage == 0 {
                // The number of groups is the second of the head.
                run(recorder, &Inputs { numbers: &order, index: 1, capacity: MAX_VALUES, values: &starts });
            }
        }
    }
}
