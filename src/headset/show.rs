//! Copies an eye's picture to the runtime's image, with a border that darkens during motion. See
//! `shaders/headset/show.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::pipelines::{Draw, Key, Raw, Ready, replaced};
use crate::gpu::pools::Pools;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::headset::show::Show as ShowUniform;
use crate::scene::view::Lens;

/// The pass. It has pools of its own, because the runtime's images are not targets of a renderer.
pub struct ShowPass {
    pools: Pools,
}

impl ShowPass {
    /// Creates the pass with empty pools.
    pub fn new(gpu: &Gpu) -> Self {
        Self { pools: Pools::new(gpu) }
    }

    /// Draws `picture` onto an image of the same size into `encoder`, which must be submitted next. `vignette` is how
    /// dark the border is, 0 to 1.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Target,
        (image, format): (&wgpu::TextureView, wgpu::TextureFormat),
        lens: &Lens,
        vignette: f64,
    ) {
        let draw = Key::Draw(Draw {
            name: "headset/show",
            definitions: &[],
            fragment: "fragment",
            colors: [replaced(format), None, None, None, None],
            depth: None,
            writes_depth: false,
            topology: wgpu::PrimitiveTopology::TriangleList,
        });
        let [width, height] = picture.size_px().map(f64::from);
        let tangent_per_px = [(lens.left + lens.right) / width, (lens.up + lens.down) / height];
        let uniform = ShowUniform {
            corner_tangent: [-lens.left as f32, -lens.up as f32],
            tangent_per_px: tangent_per_px.map(|tangent| tangent as f32),
            vignette: vignette as f32,
            pad: 0.0,
        };
        let Pools { compiles, groups, arena, .. } = &mut self.pools;
        let resources = [("show", arena.uniform(gpu, "show", &uniform)), ("picture", picture.into())];
        let ready = gpu.pipelines().ready(gpu, groups, &draw, &resources, compiles);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("headset/show"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: image,
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
    }

    /// Uploads uniforms and ends the frame; must be called after the last eye, before the encoder is submitted.
    pub fn flush(&mut self, gpu: &Gpu) {
        self.pools.arena.flush(gpu);
        self.pools.end_frame();
    }
}
