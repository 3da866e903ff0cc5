//! Passes that draw one triangle over all of a texture that does not belong to a renderer: a window's surface, or an
//! image of a headset's runtime. Their frames are not those of a renderer, so they have pools of their own.
//!
//! The vertex entry point of such a shader returns `hachure::full_screen::full_screen_corner`.

use super::Gpu;
use super::bind::{Named, Resource};
use super::pipelines::{Draw, Key, Raw, Ready, replaced};
use super::pools::Pools;

/// The pools of full-screen passes.
pub(crate) struct FullScreen {
    pools: Pools,
}

impl FullScreen {
    /// Creates empty pools.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { pools: Pools::new(gpu) }
    }

    /// Returns a uniform for [`FullScreen::draw`], valid until [`FullScreen::flush`].
    pub(crate) fn uniform<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, name: &'static str, value: &T) -> Resource {
        self.pools.arena.uniform(gpu, name, value)
    }

    /// Records a pass that draws over all of `view`, a texture of the given format, with a shader's fragment entry
    /// point. Where the shader has an error, the texture becomes black.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (name, fragment): (&'static str, &'static str),
        resources: &[Named],
        (view, format): (&wgpu::TextureView, wgpu::TextureFormat),
    ) {
        let draw =
            Key::Draw(Draw { fragment, colors: [replaced(format), None, None, None, None], ..Draw::triangles(name) });
        let Pools { compiles, groups, .. } = &mut self.pools;
        let ready = gpu.pipelines().ready(gpu, groups, &draw, resources, compiles);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(name),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
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

    /// Uploads the uniforms and ends the frame; must be called after the last pass, before the encoder is submitted.
    pub(crate) fn flush(&mut self, gpu: &Gpu) {
        self.pools.arena.flush(gpu);
        self.pools.end_frame();
    }
}
