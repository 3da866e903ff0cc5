//! Blinn-Phong over an elevation tint. See `shaders/tones/plain.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// What the tint needs to know of the scene.
#[derive(Clone, Copy, Debug)]
pub struct PlainLight {
    /// Unit, in the world.
    pub to_sun: [f32; 3],
    /// The camera's height in the world.
    pub camera_z_m: f32,
    /// Heights at which the tint begins and ends.
    pub range_m: [f32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct PlainUniform {
    to_sun: [f32; 3],
    camera_z_m: f32,
    low_m: f32,
    high_m: f32,
    shininess: f32,
    specular: f32,
}

crate::gpu::shared::describe!(PlainUniform as "Plain" in "tones/plain": to_sun, camera_z_m, low_m, high_m, shininess, specular);

/// The pass.
pub struct PlainPass {
    pass: ComputePass,
    uniform: GrowingBuffer,
}

impl PlainPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let pass = ComputePass::new(gpu, "tones/plain");
        Self { pass, uniform: GrowingBuffer::new(gpu, "plain", wgpu::BufferUsages::UNIFORM) }
    }

    /// Reads `view`, `terrain`, `position`, `normal`; writes `tone`.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        light: PlainLight,
        view: wgpu::BindingResource<'_>,
        terrain: Named<'_>,
        position: &Target,
        normal: &Target,
        tone: &Target,
    ) {
        let [low_m, high_m] = light.range_m;
        let uniform = PlainUniform {
            to_sun: light.to_sun,
            camera_z_m: light.camera_z_m,
            low_m,
            high_m: high_m.max(low_m + 1.0),
            shininess: 24.0,
            specular: 0.06,
        };
        self.uniform.write(gpu, &[uniform]);
        let resources = [
            ("view", view),
            terrain,
            ("plain", self.uniform.binding()),
            ("position", texture(&position.view)),
            ("normal", texture(&normal.view)),
            ("tone", texture(&tone.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
