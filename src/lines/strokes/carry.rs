//! From frame to frame: new strokes take over from old ones, old ones fade, and between updates all of them move along.
//!
//! An update makes strokes anew, without knowing of the last ones: their ends, their numbers and their textures would
//! jump. So each sample looks where it was in the frame before and what stroke was there (`samples`), and keeps its
//! identity and texture parameter, its pressure and part of its place (`carry`). The samples of a chain vote for where
//! on its texture it is as a whole (`vote`): toward that, parameters that perspective has stretched are evened out. Of
//! the old strokes, what no new one covers stays and shrinks (`fading`, `keep`).
//!
//! Active Strokes (Bénard et al. 2012) keep lines and bend them to follow the new contours; here the new ones are kept,
//! and take over what shows. That needs no topology of its own: a line that splits is two chains that both find the old
//! one.
//!
//! This is the temporal carry-over. Why: `docs/decisions/stroke-carry-over.md`.

use super::Lists;
use super::chain::ChainPass;
use super::points::PointsPass;
use super::samples::{MOST_SAMPLES, SamplesPass};
use super::scan::{ScanPass, ScanSize, buffer, numbers};
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::shared::describe;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::lines::strokes::MOST_PIECES;
use bytemuck::{Pod, Zeroable};

/// Workgroups of 64 for every sample.
const GROUPS: [u32; 2] = [MOST_SAMPLES / 64, 1];

/// What a chain takes over. Only the GPU writes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Heritage {
    stroke: u32,
    sense: f32,
    offset_px: f32,
    padding: u32,
}

describe!(Heritage as "Heritage" in "lines/strokes/vote": stroke, sense, offset_px, padding);

/// The passes.
pub struct CarryPass {
    vote: ComputePass,
    carry: ComputePass,
    fading: ComputePass,
    keep: ComputePass,
    advance: ComputePass,
    stages: Vec<GrowingBuffer>,
    size: ScanSize,
    heritages: wgpu::Buffer,
    gone: wgpu::Buffer,
    places: wgpu::Buffer,
}

impl CarryPass {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        Self {
            vote: ComputePass::new(gpu, "lines/strokes/vote"),
            carry: ComputePass::new(gpu, "lines/strokes/carry"),
            fading: ComputePass::new(gpu, "lines/strokes/fading"),
            keep: ComputePass::new(gpu, "lines/strokes/keep"),
            advance: ComputePass::new(gpu, "lines/strokes/advance"),
            stages: numbers(gpu, 3),
            size: ScanSize::new(gpu, 0, MOST_SAMPLES),
            heritages: buffer(gpu, "heritages", u64::from(MOST_PIECES) * size_of::<Heritage>() as u64, storage),
            gone: buffer(gpu, "gone samples", 4 * u64::from(MOST_SAMPLES), storage),
            places: buffer(gpu, "kept places", 4 * (u64::from(MOST_SAMPLES) + 1), storage),
        }
    }

    /// Reads what the samples of this frame found; changes them.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn take_over(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        lists: &Lists,
        chain: &ChainPass,
        points: &PointsPass,
        samples: &SamplesPass,
    ) {
        let heritages = || ("heritages", self.heritages.as_entire_binding());
        let (arguments, offset) = points.per_piece();
        let resources =
            [samples.carry(), lists.counts(), samples.starts(), samples.list(), samples.matches(), heritages()];
        self.vote.run_indirect(gpu, recorder, arguments, offset, &resources);
        let resources = [
            ("view", view),
            samples.carry(),
            lists.counts(),
            chain.named_chains(),
            samples.starts(),
            samples.matches(),
            heritages(),
            samples.samples(),
            samples.list(),
        ];
        self.carry.run_groups(gpu, recorder, GROUPS, &resources);
    }

    /// Adds to the list of this frame what is left of the frame before where `ids` has no stroke of this frame.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn keep(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        samples: &SamplesPass,
        scan: &ScanPass,
        ids: &Target,
        depth: &Target,
    ) {
        let gone = || ("gone", self.gone.as_entire_binding());
        let resources = [
            ("view", view.clone()),
            samples.carry(),
            samples.old_list(),
            samples.old_samples(),
            samples.samples(),
            ("ids", texture(&ids.view)),
            ("depth", texture(&depth.view)),
            gone(),
        ];
        self.fading.run_groups(gpu, recorder, GROUPS, &resources);
        for (stage, uniform) in self.stages.iter().enumerate() {
            let resources = [
                ("stage", uniform.binding()),
                ("view", view.clone()),
                samples.carry(),
                samples.old_list(),
                samples.old_samples(),
                gone(),
                ("places", self.places.as_entire_binding()),
                samples.list(),
                samples.samples(),
                samples.draws(),
            ];
            let groups = if stage == 2 { [1, 1] } else { GROUPS };
            self.keep.run_groups(gpu, recorder, groups, &resources);
            if stage == 0 {
                scan.run(gpu, recorder, &self.size, &samples.before().counts, &self.places);
            }
        }
    }

    /// Moves the strokes of the frame before into this one.
    pub fn advance(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        samples: &SamplesPass,
    ) {
        let resources = [
            ("view", view),
            samples.carry(),
            samples.old_list(),
            samples.old_samples(),
            samples.list(),
            samples.samples(),
            samples.draws(),
        ];
        self.advance.run_groups(gpu, recorder, GROUPS, &resources);
    }
}
