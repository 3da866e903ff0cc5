//! Depth of the mesh → position and normal of the surface. See `shaders/surface/resolve.wgsl`.
//!
//! Why: `docs/decisions/resolve-pass.md`.

use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, Named, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// xyz: relative to the camera in metres; w: distance along the view axis. All 0 is the sky.
pub const POSITION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// xyz: unit, in the world; 0 is the sky.
pub const NORMAL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The pass.
pub struct ResolvePass(ComputePass);

impl ResolvePass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "surface/resolve"))
    }

    /// Reads `view`, `terrain`, `depth`; writes `position`, `normal`.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        terrain: &[Named<'_>],
        depth: &Target,
        position: &Target,
        normal: &Target,
    ) {
        let mut resources = vec![
            ("view", view),
            ("depth", texture(&depth.view)),
            ("position", texture(&position.view)),
            ("normal", texture(&normal.view)),
        ];
        resources.extend(terrain.iter().cloned());
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
