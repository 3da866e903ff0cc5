//! Which candidates are drawn, and how wide. See `shaders/surface/rows/marks.wgsl`.

use super::{BLOCKS, RowPlan};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;
use crate::gpu::wgsl::shared::rows::{MOST_CANDIDATES, SAMPLES};

/// Vertices and instances.
pub const DRAWN: BufferKind = BufferKind::indirect("row draw");
/// Samples of marks.
pub const MARKS: BufferKind = BufferKind::storage("row marks");

/// What the pass reads.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// The blocks, and how marks are drawn.
    pub plan: &'a RowPlan,
    /// Of what is seen.
    pub position: &'a Target,
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

/// Chooses marks.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) -> Marks {
    let plan = inputs.plan;
    let drawn = cx.buffer(&DRAWN, 16);
    let samples = cx.buffer(&MARKS, 16 * u64::from(plan.rules.most_marks) * SAMPLES as u64);
    cx.write(&drawn, &[6_u32, 0, 0, 0]);
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("rules", cx.uniform("row rules", &plan.rules)),
        ("blocks", cx.upload(&BLOCKS, &plan.seen).binding()),
        ("counts", plan.counts.binding()),
        ("candidates", plan.candidates.binding()),
        ("drawn", drawn.binding()),
        ("marks", samples.binding()),
        ("position", inputs.position.into()),
        ("tone", inputs.tone.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    cx.groups("surface/rows/marks", [MOST_CANDIDATES / 64, plan.seen.len() as u32], &resources);
    Marks { drawn, samples }
}
