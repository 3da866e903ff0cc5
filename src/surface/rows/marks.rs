//! What is drawn of the proposals, and how wide. See `shaders/surface/rows/marks.wgsl`.

use super::RowPlan;
use super::proposals::Proposals;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::readback::read_buffer;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::shared::rows::SAMPLES;
use crate::gpu::{Gpu, GpuError};

/// Vertices and instances.
pub const DRAWN: BufferKind = BufferKind::indirect("row draw");
/// Samples of marks.
pub const MARKS: BufferKind = BufferKind::storage("row marks");

/// What the pass reads.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// How marks are drawn.
    pub plan: &'a RowPlan,
    /// What may be drawn, and is chosen.
    pub proposals: &'a Proposals,
    /// By how much marks are wider, in squares of the picture.
    pub gains: &'a Buffer,
    /// Its alpha is the tone that is asked for.
    pub tone: &'a Target,
}

/// What there is to draw: the numbers of an indirect draw, and the samples.
pub struct Marks {
    /// Vertices and instances.
    pub drawn: Buffer,
    /// Samples of marks.
    pub samples: Buffer,
}

/// Gives marks their widths.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) -> Marks {
    let plan = inputs.plan;
    let drawn = recorder.buffer(&DRAWN, 16);
    let samples = recorder.buffer(&MARKS, 16 * u64::from(plan.rules.most_marks) * SAMPLES as u64);
    recorder.write(&drawn, &[2 * SAMPLES as u32, 0, 0, 0]);
    let resources = [
        ("view", inputs.view.clone()),
        ("rules", recorder.uniform("row rules", &plan.rules)),
        ("proposed", inputs.proposals.count.binding()),
        ("proposals", inputs.proposals.all.binding()),
        ("gains", inputs.gains.binding()),
        ("drawn", drawn.binding()),
        ("marks", samples.binding()),
        ("tone", inputs.tone.into()),
    ];
    recorder.groups("surface/rows/marks", [plan.rules.most_marks.div_ceil(64), 1], &resources);
    Marks { drawn, samples }
}

/// A place on a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowSample {
    /// On the targets.
    pub px: [f32; 2],
    /// Across the mark, in pixels; 0 where it ends.
    pub width_px: f32,
    /// Along the view axis, in metres.
    pub depth_m: f32,
}

/// The marks as lines, in no order; what hides them is not asked. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Readback`] when the device is lost or out of memory.
pub fn read(gpu: &Gpu, drawn: &Buffer, samples: &Buffer) -> Result<Vec<Vec<RowSample>>, GpuError> {
    let numbers: Vec<u32> = read_buffer(gpu, &drawn.raw, 4)?;
    let of_mark = SAMPLES as usize;
    let room = samples.raw.size() as usize / (16 * of_mark);
    let marks = numbers.get(1).map_or(0, |instances| *instances as usize).min(room);
    let samples: Vec<[f32; 4]> = read_buffer(gpu, &samples.raw, marks * of_mark)?;
    let lines = samples.chunks_exact(of_mark).map(|mark| {
        let mut line: Vec<RowSample> =
            mark.iter().map(|&[x, y, half, depth_m]| RowSample { px: [x, y], width_px: 2.0 * half, depth_m }).collect();
        // What is not drawn of it stands at its ends.
        line.dedup_by_key(|sample| sample.px);
        line
    });
    Ok(lines.collect())
}
