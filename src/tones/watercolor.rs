//! Washes that run and settle. See `shaders/tones/watercolor.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::Watercolor;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct WatercolorUniform {
    edge: f32,
    edge_px: f32,
    granulation: f32,
    flow: f32,
    warp_px: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

crate::gpu::shared::describe!(WatercolorUniform as "Watercolor" in "tones/watercolor": edge, edge_px, granulation, flow, warp_px, pad_a, pad_b, pad_c);

/// Where the camera is, for noise that is fixed in the world: whole blocks of 4096 m, and the rest.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Anchor {
    blocks: [i32; 3],
    pad_a: u32,
    rest_m: [f32; 3],
    pad_b: u32,
}

crate::gpu::shared::describe!(Anchor as "Anchor" in "tones/watercolor": blocks, pad_a, rest_m, pad_b);

/// Side of a block; `shaders/shared/wobble.wgsl` says why.
const BLOCK_M: f64 = 4096.0;

impl Anchor {
    fn new(camera_m: DVec3) -> Self {
        let blocks = (camera_m / BLOCK_M).floor();
        let rest_m = (camera_m - blocks * BLOCK_M).as_vec3().to_array();
        Self { blocks: blocks.as_ivec3().to_array(), pad_a: 0, rest_m, pad_b: 0 }
    }
}

/// The pass.
pub struct WatercolorPass {
    pass: ComputePass,
    uniform: GrowingBuffer,
    anchor: GrowingBuffer,
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// Of the surface.
    pub position: &'a Target,
    /// Colours.
    pub tone: &'a Target,
    /// Out: colours.
    pub washed: &'a Target,
}

impl WatercolorPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            pass: ComputePass::new(gpu, "tones/watercolor"),
            uniform: GrowingBuffer::new(gpu, "watercolor", wgpu::BufferUsages::UNIFORM),
            anchor: GrowingBuffer::new(gpu, "anchor", wgpu::BufferUsages::UNIFORM),
        }
    }

    /// Washes what a camera at `camera_m` sees.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        watercolor: &Watercolor,
        camera_m: DVec3,
        inputs: Inputs<'_>,
    ) {
        let &Watercolor { edge, edge_px, granulation, flow, warp_px } = watercolor;
        let [pad_a, pad_b, pad_c] = [0.0; 3];
        self.uniform
            .write(gpu, &[WatercolorUniform { edge, edge_px, granulation, flow, warp_px, pad_a, pad_b, pad_c }]);
        self.anchor.write(gpu, &[Anchor::new(camera_m)]);
        let resources = [
            ("view", inputs.view),
            ("watercolor", self.uniform.binding()),
            ("anchor", self.anchor.binding()),
            ("position", texture(&inputs.position.view)),
            ("tone", texture(&inputs.tone.view)),
            ("washed", texture(&inputs.washed.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
