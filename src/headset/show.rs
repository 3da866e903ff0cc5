//! Copies an eye's picture to the runtime's image, with a border that darkens during motion. See
//! `shaders/headset/show.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::full_screen::FullScreen;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::headset::show::Show as ShowUniform;
use crate::scene::view::Lens;

/// The pass that copies a picture to a swapchain image.
pub(super) struct ShowPass {
    full_screen: FullScreen,
}

impl ShowPass {
    /// Creates the pass.
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { full_screen: FullScreen::new(gpu) }
    }

    /// Draws `picture` onto the upper left corner of an image that is at least as large, into `encoder`, which must be
    /// submitted next. `vignette` is how dark the border is, 0 to 1.
    pub(super) fn run(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Target,
        image: (&wgpu::TextureView, wgpu::TextureFormat),
        lens: &Lens,
        vignette: f64,
    ) {
        let size_px = picture.size_px();
        let [width, height] = size_px.map(f64::from);
        let tangent_per_px = [(lens.left + lens.right) / width, (lens.up + lens.down) / height];
        let uniform = ShowUniform {
            corner_tangent: [-lens.left as f32, -lens.up as f32],
            tangent_per_px: tangent_per_px.map(|tangent| tangent as f32),
            size_px: size_px.map(|side| side as f32),
            vignette: vignette as f32,
            pad: 0.0,
        };
        let resources = [("show", self.full_screen.uniform(gpu, "show", &uniform)), ("picture", picture.into())];
        self.full_screen.draw(gpu, encoder, ("headset/show", "fragment"), &resources, image);
    }

    /// Copies `picture` to an image of the same size, as [`ShowPass::run`] does, without a border.
    pub(super) fn copy(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Target,
        image: (&wgpu::TextureView, wgpu::TextureFormat),
    ) {
        let lens = Lens { left: 1.0, right: 1.0, up: 1.0, down: 1.0 };
        self.run(gpu, encoder, picture, image, &lens, 0.0);
    }

    /// Uploads uniforms and ends the frame; must be called after the last picture, before the encoder is submitted.
    pub(super) fn flush(&mut self, gpu: &Gpu) {
        self.full_screen.flush(gpu);
    }
}
