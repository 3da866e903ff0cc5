//! The marks that are drawn of the proposals, and their widths. See `shaders/surface/rows/marks.wgsl`.

use super::RowPlan;
use super::proposals::Proposals;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::readback::read_buffer;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::shared::rows::SAMPLES;
use crate::gpu::{Gpu, GpuError};

/// Arguments of an indirect draw.
pub(crate) const DRAWN: BufferKind = BufferKind::indirect("row draw");
/// Samples along the marks.
pub(crate) const MARKS: BufferKind = BufferKind::storage("row marks");
/// Bytes of a mark.
pub(crate) const BYTES: u64 = 16 * SAMPLES as u64;

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The plan, for its rules uniform.
    pub plan: &'a RowPlan,
    /// The proposals, after the choice.
    pub proposals: &'a Proposals,
    /// Factor by which marks are widened, for each square of the picture.
    pub gains: &'a Buffer,
    /// A target whose alpha is the requested tone.
    pub tone: &'a Target,
}

/// The marks to draw: arguments of an indirect draw, and samples.
pub(crate) struct Marks {
    /// Arguments of the draw: vertices and instances.
    pub drawn: Buffer,
    /// Samples along the marks.
    pub samples: Buffer,
}

/// Computes the widths of the marks.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) -> Marks {
    let plan = inputs.plan;
    let drawn = recorder.buffer(&DRAWN, 16);
    let samples = recorder.buffer(&MARKS, u64::from(plan.rules.max_marks) * BYTES);
    recorder.reset(&drawn, &[2 * SAMPLES as u32, 0, 0, 0]);
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
    recorder.groups("surface/rows/marks", [plan.rules.max_marks.div_ceil(64), 1], &resources);
    Marks { drawn, samples }
}

/// A sample along a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowSample {
    /// Position on the targets, in pixels.
    pub px: [f32; 2],
    /// Width across the mark, in pixels; 0 at its ends.
    pub width_px: f32,
    /// Distance along the view axis, in metres.
    pub depth_m: f32,
}

/// Reads the marks back as polylines, in arbitrary order and without hidden-line removal. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Readback`] when the device is lost or out of memory.
pub(crate) fn read(gpu: &Gpu, drawn: &Buffer, samples: &Buffer) -> Result<Vec<Vec<RowSample>>, GpuError> {
    let numbers: Vec<u32> = read_buffer(gpu, &drawn.raw, 4)?;
    let of_mark = SAMPLES as usize;
    let room = samples.raw.size() as usize / (16 * of_mark);
    let marks = numbers.get(1).map_or(0, |instances| *instances as usize).min(room);
    let samples: Vec<[f32; 4]> = read_buffer(gpu, &samples.raw, marks * of_mark)?;
    let lines = samples.chunks_exact(of_mark).map(|mark| {
        let mut line: Vec<RowSample> =
            mark.iter().map(|&[x, y, half, depth_m]| RowSample { px: [x, y], width_px: 2.0 * half, depth_m }).collect();
        // Samples that are not drawn coincide with the mark's ends.
        line.dedup_by_key(|sample| sample.px);
        line
    });
    Ok(lines.collect())
}
