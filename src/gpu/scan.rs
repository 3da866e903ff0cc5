//! Exclusive prefix sum of integers in place (`shaders/gpu/scan.wgsl`), and passes that use it to write a list in a
//! fixed order.

use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::gpu::scan_begin::ScanSource;

/// Largest number of values in a scan, because a single workgroup scans the sums of all blocks.
pub(crate) const MAX_VALUES: u32 = 1 << 21;

/// Values in a block.
const BLOCK: u64 = 2048;

/// The number of values, one u32.
const SIZE: BufferKind = BufferKind::storage("scan size");
/// The number of workgroups that scan the values, in x, y and z.
const ARGUMENTS: BufferKind = BufferKind::indirect("scan arguments");
/// The sums of the blocks, u32.
const SUMS: BufferKind = BufferKind::storage("scan sums");

/// The inputs of a scan.
pub(crate) struct Inputs<'a> {
    /// A buffer of u32 that contains the number of values.
    pub numbers: &'a Buffer,
    /// Index in `numbers` of the number of values.
    pub index: u32,
    /// Largest number of values; a greater number is clamped to it and to [`MAX_VALUES`].
    pub capacity: u32,
    /// The values, u32, which are replaced by their sums.
    pub values: &'a Buffer,
}

/// Replaces each value by the sum of the values before it, modulo 2³². The element after the last value becomes the
/// total, if the buffer has room for it.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
/// Offset in bytes of its list `starts`, which is the largest alignment that a storage binding may need.
const ORDER_HEAD_BYTES: u64 = 256;

/// The number of workgroups of an ordered pass.
#[derive(Clone, Copy)]
pub(crate) enum Groups<'a> {
    /// Workgroups in x and y.
    Of([u32; 2]),
    /// A number that the GPU has computed.
    Counted {
        /// At `offset`, four u32: workgroups in x, y and z, and their product.
        arguments: &'a Buffer,
        /// Offset in `arguments`, in bytes.
        offset: u64,
        /// Largest number of workgroups, before the last row of 65,535 is filled up.
        most: u32,
    },
}

/// Workgroups in a row of a counted dispatch.
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

/// A pass that writes a list in an order that does not depend on which workgroup is quicker. The order is made by
/// `shaders/shared/ordered.wgsl`.
pub(crate) struct Ordered<'a> {
    pub shader: Compute,
    /// The variant for the first stage, if it differs.
    pub find: Option<Compute>,
    /// Number of stages, 2 or 3. The third is a single workgroup.
    pub stages: u32,
    /// Number of workgroups of the first two stages.
    pub groups: Groups<'a>,
    /// How many u32 each workgroup may store between stages.
    pub kept: u64,
}

impl Ordered<'_> {
    /// Runs all stages with `resources` and the `order` list, and the prefix sum after the first stage.
    pub(crate) fn run(&self, recorder: &mut Recorder<'_>, resources: &[Named]) {
        let bytes = 4 * (u64::from(self.groups.most()) * (1 + self.kept) + 1);
        let order = recorder.buffer(&ORDER, (ORDER_HEAD_BYTES + bytes).next_power_of_two());
        let starts = order.slice(ORDER_HEAD_BYTES, order.raw.size() - ORDER_HEAD_BYTES);
        let mut all = vec![("order", order.binding())];
        all.extend(resources.iter().cloned());
        for stage in 0..self.stages {
            let shader = self.find.filter(|_| stage == 0).unwrap_or(self.shader);
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
                // The number of workgroups is the second number of the list's head.
                run(recorder, &Inputs { numbers: &order, index: 1, capacity: MAX_VALUES, values: &starts });
            }
        }
    }
}
