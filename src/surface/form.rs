//! The surface's normal at the scale of marks. See `shaders/surface/form.wgsl`.
//!
//! This is the mark normal. Why: `docs/decisions/hatching.md`.

use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, Named, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// xyz: unit normal in the world; w: distance along the view axis. All 0 is the sky.
pub const FORM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Side of the block of pixels that shares a texel; `shaders/shared/form.wgsl` has it too.
const BLOCK_PX: u32 = 4;

/// The size of the picture for targets of `size_px`: blocks are counted in the whole picture, so a part may see one
/// more at either end.
pub fn form_size(size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|side| side.div_ceil(BLOCK_PX) + 1)
}

/// The pass.
pub struct FormPass(ComputePass);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// Heights and tables.
    pub terrain: &'a [Named<'a>],
    /// Tells meshes from the land.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface: a mesh's own normal is its form.
    pub normal: &'a Target,
    /// Out.
    pub form: &'a Target,
}

impl FormPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "surface/form"))
    }

    /// Finds the form of what the inputs show.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, inputs: Inputs<'_>) {
        let mut resources = vec![
            ("view", inputs.view),
            ("surface_id", texture(&inputs.surface_id.view)),
            ("position", texture(&inputs.position.view)),
            ("normal", texture(&inputs.normal.view)),
            ("form", texture(&inputs.form.view)),
        ];
        resources.extend(inputs.terrain.iter().cloned());
        let size_px = [inputs.form.texture.width(), inputs.form.texture.height()];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
