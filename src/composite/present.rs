//! Draws the picture, or those of two eyes, into a window. See `shaders/composite/present.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::pipelines::{Draw, Key, Raw, Ready, replaced};
use crate::gpu::pools::Pools;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::composite::present::Present as PresentUniform;
use crate::scene::anaglyph::{Glasses, Mix};

/// The pictures that a window shows.
#[derive(Clone, Copy)]
pub enum Shown<'a> {
    /// The picture of one eye.
    One(&'a Target),
    /// The pictures of two eyes.
    Pair {
        left: &'a Target,
        right: &'a Target,
        /// The anaglyph glasses for which both pictures are mixed in the same pixels; `None` shows them side by side.
        glasses: Option<Glasses>,
    },
}

/// The pass that presents to a window. It has its own pools, because its frames are the window's.
pub struct PresentPass {
    pools: Pools,
    draw: Draw,
    /// Whether the pass encodes to sRGB, because the window's format does not.
    encodes: bool,
}

impl PresentPass {
    /// Creates the pass for a window's format.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let draw = Draw {
            name: "composite/present",
            definitions: &[],
            fragment: "fragment",
            colors: [replaced(format), None, None, None, None],
            depth: None,
            writes_depth: false,
            topology: wgpu::PrimitiveTopology::TriangleList,
        };
        Self { pools: Pools::new(gpu), draw, encodes: !format.is_srgb() }
    }

    /// Draws `shown` over all of `window`, whose size is `window_px`, with `encoder`, which the caller submits next.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        shown: Shown<'_>,
        window: &wgpu::TextureView,
        window_px: [u32; 2],
    ) {
        let window_px = window_px.map(|side| side as f32);
        let Pools { compiles, groups, arena, .. } = &mut self.pools;
        let mixed = |mix: &Mix| mix.map(|[red, green, blue]| [red, green, blue, 0.0]);
        let (side_by_side, [left_mix, right_mix]) = match shown {
            Shown::Pair { glasses: Some(glasses), .. } => (0, glasses.mixes().map(mixed)),
            Shown::Pair { glasses: None, .. } | Shown::One(_) => (1, Default::default()),
        };
        let encode = u32::from(self.encodes);
        let uniform = PresentUniform { encode, side_by_side, window_px, left_mix, right_mix };
        let mut resources = vec![("present", arena.uniform(gpu, "present", &uniform))];
        let fragment = match shown {
            Shown::One(picture) => {
                resources.push(("picture", picture.into()));
                "fragment"
            }
            Shown::Pair { left, right, .. } => {
                resources.extend([("picture", left.into()), ("right_picture", right.into())]);
                "pair"
            }
        };
        let draw = Key::Draw(Draw { fragment, ..self.draw.clone() });
        let ready = gpu.pipelines().ready(gpu, groups, &draw, &resources, compiles);
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
