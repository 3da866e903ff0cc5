//! Local Surface Approximation contours. See `shaders/lines/lsa.wgsl`.
//!
//! Why: `docs/decisions/lsa-contours.md`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::Epsilon;

/// ε of Eq. 6 as the paper has it.
pub const PAPER_EPSILON_M: f32 = 1e-5;
/// ε of Eq. 6 in sizes of the pixel in the world: the paper's 1e-5 m is this part of a pixel some 5 m away, the scale
/// of its scenes.
pub const FOOTPRINT_EPSILON: f32 = 2e-3;
/// The ramp k of Eq. 6.
pub const PLANE_RAMP: [f32; 2] = [50.0, 150.0];

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct LsaUniform {
    epsilon_paper_m: f32,
    epsilon_footprint: f32,
    plane_ramp: [f32; 2],
}

crate::gpu::shared::describe!(LsaUniform as "Lsa" in "lines/lsa": epsilon_paper_m, epsilon_footprint, plane_ramp);

/// The pass.
pub struct LsaPass {
    pass: ComputePass,
    uniform: GrowingBuffer,
}

impl LsaPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let pass = ComputePass::new(gpu, "lines/lsa");
        Self { pass, uniform: GrowingBuffer::new(gpu, "lsa", wgpu::BufferUsages::UNIFORM) }
    }

    /// Reads `view`, `position`, `normal`; writes `errors`.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        epsilon: Epsilon,
        view: wgpu::BindingResource<'_>,
        position: &Target,
        normal: &Target,
        errors: &Target,
    ) {
        let (epsilon_paper_m, epsilon_footprint) = match epsilon {
            Epsilon::Paper => (PAPER_EPSILON_M, 0.0),
            Epsilon::Footprint => (0.0, FOOTPRINT_EPSILON),
        };
        self.uniform.write(gpu, &[LsaUniform { epsilon_paper_m, epsilon_footprint, plane_ramp: PLANE_RAMP }]);
        let resources = [
            ("view", view),
            ("lsa", self.uniform.binding()),
            ("position", texture(&position.view)),
            ("normal", texture(&normal.view)),
            ("errors", texture(&errors.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
