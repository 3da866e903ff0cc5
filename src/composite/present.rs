//! The picture onto a window. See `shaders/composite/present.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::pipelines::{Draw, Key, Raw, Ready, replaced};
use crate::gpu::pools::Pools;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::composite::present::Present as PresentUniform;

/// The pass of a window. Its frames are the window's, so it has pools of its own.
pub struct PresentPass {
    pools: Pools,
    draw: Key,
    /// Whether the window shows what is written as it is: then the pass encodes.
    encodes: bool,
}

impl PresentPass {
    /// For a window's format.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let draw = Key::Draw(Draw {
            name: "composite/present",
            fragment: "fragment",
            colors: [replaced(format), None],
            depth: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
        });
        Self { pools: Pools::new(gpu), draw, encodes: !format.is_srgb() }
    }

    /// Draws `picture` over all of `window`, whose size is `window_px`, into `encoder`, which is submitted next.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Target,
        window: &wgpu::TextureView,
        window_px: [u32; 2],
    ) {
        let window_px = window_px.map(|side| side as f32);
        let Pools { pipelines, groups, arena, .. } = &mut self.pools;
        let uniform = PresentUniform { encode: u32::from(self.encodes), pad: 0, window_px };
        let resources = [("present", arena.uniform(gpu, "present", &uniform)), ("picture", picture.into())];
        let ready = pipelines.ready(gpu, groups, &self.draw, &resources);
        arena.flush(gpu);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("composite/present"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: window,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        if let Some((Ready { raw: Raw::Draw(pipeline), bound }, _)) = &ready {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bound.group, &bound.offsets);
            pass.draw(0..3, 0..1);
        }
        drop(pass);
        self.pools.end_frame();
    }
}
