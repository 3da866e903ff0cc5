//! Exclusive prefix sum of integers in place (`shaders/gpu/scan.wgsl`), and passes that use it to write a list in a
//! fixed order.

use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::gpu::scan::{BLOCK, Scan};

/// Largest number of values in a scan: 64 workgroups × 16 blocks × 2048 values.
pub(crate) const MAX_VALUES: u32 = 1 << 21;

/// Largest number of workgroups.
const MAX_GROUPS: u32 = 64;
/// Largest capacity for which a single workgroup scans all values, in one dispatch instead of two.
const MAX_OF_ONE: u32 = 4 * BLOCK;

/// The sums of the workgroups, u32.
const SUMS: BufferKind = BufferKind::storage("scan sums");

/// The number of values of a scan.
#[derive(Clone, Copy)]
pub(crate) enum Count<'a> {
    /// A number that the CPU knows.
    Of(u32),
    /// A number that the GPU has computed.
    Counted {
        /// A buffer of u32 that contains the number.
        numbers: &'a Buffer,
        /// Index of the number in `numbers`.
        index: u32,
        /// Largest number of values; a greater number is clamped to it and to [`MAX_VALUES`].
        capacity: u32,
    },
}

/// Replaces each value by the sum of the values before it, modulo 2³². The element after the last value becomes the
/// total, if the buffer has room for it.
pub(crate) fn run(recorder: &mut Recorder<'_>, count: Count<'_>, values: &Buffer) {
    let sums = recorder.buffer(&SUMS, 4 * u64::from(MAX_GROUPS));
    let (capacity, index, definitions): (_, _, &[&str]) = match count {
        Count::Of(number) => (number, 0, &[]),
        Count::Counted { index, capacity, .. } => (capacity, index, &["COUNTED"]),
    };
    let capacity = capacity.min(MAX_VALUES);
    let groups = if capacity <= MAX_OF_ONE { 1 } else { capacity.div_ceil(BLOCK).min(MAX_GROUPS) };
    for stage in u32::from(groups == 1)..2 {
        let scan = Scan { stage, groups, capacity, index };
        let mut resources =
            vec![("scan", recorder.uniform("scan", &scan)), ("sums", sums.binding()), ("values", values.binding())];
        if let Count::Counted { numbers, .. } = count {
            resources.push(("numbers", numbers.binding()));
        }
        recorder.groups(Compute { name: "gpu/scan", definitions }, [groups, 1], &resources);
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
        /// An upper bound of the product of the numbers of workgroups. The dispatch rounds it up to whole rows of
        /// [`GROUPS_IN_ROW`](crate::gpu::wgsl::shared::dispatch::GROUPS_IN_ROW).
        max_groups: u32,
    },
}

/// Workgroups in a row of a counted dispatch.
const ROW: u32 = crate::gpu::wgsl::shared::dispatch::GROUPS_IN_ROW;

impl<'a> Groups<'a> {
    /// Returns the product of the numbers of workgroups, which on the GPU is the number stored after them.
    fn count(&self) -> Count<'a> {
        match *self {
            Self::Of([x, y]) => Count::Of(x * y),
            Self::Counted { arguments, offset, .. } => {
                Count::Counted { numbers: arguments, index: (offset / 4) as u32 + 3, capacity: MAX_VALUES }
            }
        }
    }

    /// Returns an upper bound of the number of workgroups that are dispatched.
    fn max_dispatched(&self) -> u32 {
        match self {
            Self::Of([x, y]) => x * y,
            Self::Counted { max_groups, .. } if *max_groups > ROW => max_groups.next_multiple_of(ROW),
            Self::Counted { max_groups, .. } => *max_groups,
        }
    }
}

/// A pass that writes a list in an order that does not depend on which workgroup is quicker. The order is made by
/// `shaders/shared/ordered.wgsl`.
pub(crate) struct Ordered<'a> {
    pub shader: Compute,
    /// The variant for the first stage, if it differs.
    pub first_stage_shader: Option<Compute>,
    /// Number of workgroups of both stages.
    pub groups: Groups<'a>,
    /// Number of u32 that each workgroup may store between the stages.
    pub words_per_group: u64,
}

impl Ordered<'_> {
    /// Runs both stages with `resources` and the `order` list, and the prefix sum between them.
    pub(crate) fn run(&self, recorder: &mut Recorder<'_>, resources: &[Named]) {
        let bytes = 4 * (u64::from(self.groups.max_dispatched()) * (1 + self.words_per_group) + 1);
        let order = recorder.buffer(&ORDER, (ORDER_HEAD_BYTES + bytes).next_power_of_two());
        let starts = order.slice(ORDER_HEAD_BYTES, order.raw.size() - ORDER_HEAD_BYTES);
        for stage in 0_u32..2 {
            let mut all = vec![("order", order.binding()), ("order_stage", recorder.uniform("order stage", &stage))];
            all.extend(resources.iter().cloned());
            let shader = self.first_stage_shader.filter(|_| stage == 0).unwrap_or(self.shader);
            match self.groups {
                Groups::Of([x, y]) => recorder.groups(shader, [x, y], &all),
                Groups::Counted { arguments, offset, .. } => recorder.indirect(shader, arguments, offset, &all),
            }
            if stage == 0 {
                run(recorder, self.groups.count(), &starts);
            }
        }
    }
}
