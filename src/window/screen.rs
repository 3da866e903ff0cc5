//! The window's surface, to which frames are presented, across resizes, losses and minimising.

use std::sync::Arc;

use winit::window::Window;

use super::WindowError;
use crate::composite::present::PresentPass;
use crate::gpu::Gpu;

/// The surface and the pass that fills it.
pub(super) struct Screen {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    present: PresentPass,
}

/// The surface's answer to a request for a frame.
pub(super) enum Acquired {
    /// A texture to draw on.
    Frame(wgpu::SurfaceTexture),
    /// Nothing now; try again soon.
    Soon,
    /// Nothing while the window cannot be seen.
    Hidden,
}

impl Screen {
    /// Configures a surface that `gpu` can present to.
    ///
    /// # Errors
    /// Returns [`WindowError::NoPresent`] if the GPU cannot.
    pub(super) fn new(gpu: &Gpu, window: Arc<Window>, surface: wgpu::Surface<'static>) -> Result<Self, WindowError> {
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| WindowError::NoPresent { adapter: gpu.description() })?;
        // The pass encodes the picture itself, and the panel is blended in encoded colours: choose a format that does
        // not encode.
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let plain = |format: &wgpu::TextureFormat| {
            matches!(format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Rgba8Unorm)
        };
        config.format = formats.into_iter().find(plain).unwrap_or(config.format);
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&gpu.device, &config);
        let present = PresentPass::new(gpu, config.format);
        Ok(Self { window, surface, config, present })
    }

    /// Returns the format of the surface.
    pub(super) fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// Returns the size of the surface.
    pub(super) fn size_px(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Returns the pass that fills the surface with the picture.
    pub(super) fn present(&mut self) -> &mut PresentPass {
        &mut self.present
    }

    /// Follows the window's size; a size of 0 is ignored.
    pub(super) fn resize(&mut self, gpu: &Gpu, size_px: [u32; 2]) {
        if size_px.contains(&0) || size_px == self.size_px() {
            return;
        }
        let limit = gpu.device.limits().max_texture_dimension_2d;
        [self.config.width, self.config.height] = size_px.map(|side| side.min(limit));
        self.surface.configure(&gpu.device, &self.config);
    }

    /// Acquires the texture of the next frame.
    ///
    /// # Errors
    /// Fails if the surface is lost and cannot be recreated.
    pub(super) fn acquire(&mut self, gpu: &Gpu) -> Result<Acquired, WindowError> {
        use wgpu::CurrentSurfaceTexture as Current;
        Ok(match self.surface.get_current_texture() {
            Current::Success(frame) => Acquired::Frame(frame),
            // The frame could still be drawn on, but a better one is a call away.
            Current::Suboptimal(frame) => {
                drop(frame);
                self.reconfigure(gpu);
                match self.surface.get_current_texture() {
                    Current::Success(frame) | Current::Suboptimal(frame) => Acquired::Frame(frame),
                    _ => Acquired::Soon,
                }
            }
            Current::Timeout => Acquired::Soon,
            Current::Occluded => Acquired::Hidden,
            Current::Outdated => {
                self.reconfigure(gpu);
                Acquired::Soon
            }
            Current::Lost => {
                self.surface = gpu.instance.create_surface(Arc::clone(&self.window))?;
                self.reconfigure(gpu);
                Acquired::Soon
            }
            // The message is reported with the device's errors.
            Current::Validation => {
                gpu.check()?;
                Acquired::Soon
            }
        })
    }

    fn reconfigure(&mut self, gpu: &Gpu) {
        let size = self.window.inner_size();
        if size.width > 0 && size.height > 0 {
            [self.config.width, self.config.height] = [size.width, size.height];
        }
        self.surface.configure(&gpu.device, &self.config);
    }
}
