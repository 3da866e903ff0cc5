//! Exclusive prefix sum of whole numbers, in place. See `shaders/lines/strokes/scan.wgsl`.

use std::convert::Infallible;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Cx;

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

/// Replaces each value by the sum of those before it, modulo 2³². The value after the last becomes the sum of all if the
/// buffer has room for it.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let source = ScanSource { index: inputs.index, capacity: inputs.capacity.min(MAX_VALUES) };
    let size = cx.buffer(&SIZE, 4);
    let arguments = cx.buffer(&ARGUMENTS, 12);
    let sums = cx.buffer(&SUMS, 4 * u64::from(MAX_VALUES) / BLOCK);
    let resources = [
        ("source", cx.uniform("scan source", &source)),
        ("numbers", inputs.numbers.binding()),
        ("size", size.binding()),
        ("arguments", arguments.binding()),
    ];
    cx.groups("lines/strokes/scan_begin", [1, 1], &resources);
    for stage in 0_u32..3 {
        let resources = [
            ("stage", cx.uniform("stage", &stage)),
            ("size", size.binding()),
            ("sums", sums.binding()),
            ("values", inputs.values.binding()),
        ];
        if stage == 1 {
            cx.groups("lines/strokes/scan", [1, 1], &resources);
        } else {
            cx.indirect("lines/strokes/scan", &arguments, 0, &resources);
        }
    }
}

/// How many workgroups an ordered pass has.
const GROUP_COUNT: BufferKind = BufferKind::storage("group count");
/// Where each of them begins to write, and what it keeps from stage to stage.
const GROUP_STARTS: BufferKind = BufferKind::storage("group starts");

/// A pass that writes a list in order, whichever workgroup is quicker: see `shaders/shared/ordered.wgsl`.
pub struct Ordered {
    /// Its shader.
    pub shader: &'static str,
    /// Two, or three: the third is a single workgroup.
    pub stages: usize,
    /// In x and y.
    pub groups: [u32; 2],
    /// Numbers that each workgroup may keep.
    pub kept: u64,
}

impl Ordered {
    /// Runs all stages.
    pub fn run(&self, cx: &mut Cx<'_>, resources: &[Named]) {
        let numbers = stage_numbers(cx);
        let count = u64::from(self.groups[0]) * u64::from(self.groups[1]);
        let group_count = cx.buffer(&GROUP_COUNT, 4);
        let group_starts = cx.buffer(&GROUP_STARTS, (4 * (count * (1 + self.kept) + 1)).next_power_of_two());
        for (stage, number) in numbers.0[..self.stages].iter().enumerate() {
            let mut all = vec![
                ("stage", number.binding()),
                ("group_count", group_count.binding()),
                ("group_starts", group_starts.binding()),
            ];
            all.extend(resources.iter().cloned());
            cx.groups(Compute::from(self.shader), if stage < 2 { self.groups } else { [1, 1] }, &all);
            if stage == 0 {
                run(cx, &Inputs { numbers: &group_count, index: 0, capacity: MAX_VALUES, values: &group_starts });
            }
        }
    }
}

/// 0, 1 and 2 in storage buffers. No uniforms: a fourth uniform buffer makes lavapipe 22.3 write past its memory. See
/// `docs/decisions/software-drivers.md`.
struct StageNumbers([Buffer; 3]);

fn stage_numbers(cx: &mut Cx<'_>) -> Arc<StageNumbers> {
    let made = cx.kept(
        |_: &StageNumbers| true,
        |gpu| {
            let kind = BufferKind::storage("stage number");
            Ok::<_, Infallible>(StageNumbers([0_u32, 1, 2].map(|number| Buffer::with(gpu, &kind, &[number]))))
        },
    );
    let Ok(numbers) = made;
    numbers
}
