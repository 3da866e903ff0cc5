//! The surface's normal at the scale of marks. See `shaders/surface/form.wgsl`.

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

impl FormPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "surface/form"))
    }

    /// Reads `view`, `terrain`, `position`; writes `form`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        terrain: &[Named<'_>],
        position: &Target,
        form: &Target,
    ) {
        let mut resources = vec![("view", view), ("position", texture(&position.view)), ("form", texture(&form.view))];
        resources.extend(terrain.iter().cloned());
        let size_px = [form.texture.width(), form.texture.height()];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
