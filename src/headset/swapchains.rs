//! The images that the runtime shows: one swapchain for each eye, and one for the panel.

use openxr as xr;

use super::binding;
use super::error::{During, HeadsetError};
use crate::gpu::Gpu;

/// Formats in order of preference, with their Vulkan numbers. The runtime decodes sRGB formats, and takes all others as
/// linear light, for which eight bits show banding in the dark.
const FORMATS: [(u32, wgpu::TextureFormat); 5] = [
    (43, wgpu::TextureFormat::Rgba8UnormSrgb),
    (50, wgpu::TextureFormat::Bgra8UnormSrgb),
    (97, wgpu::TextureFormat::Rgba16Float),
    (37, wgpu::TextureFormat::Rgba8Unorm),
    (44, wgpu::TextureFormat::Bgra8Unorm),
];

/// The images of one swapchain. Textures are dropped before the swapchain.
pub struct SwapchainImages {
    images: Vec<(wgpu::Texture, wgpu::TextureView)>,
    /// The swapchain of the runtime, which owns the images.
    pub swapchain: xr::Swapchain<xr::Vulkan>,
    format: wgpu::TextureFormat,
    size_px: [u32; 2],
}

impl SwapchainImages {
    /// Creates images of a size, in the best format that the runtime offers.
    ///
    /// # Errors
    /// Returns [`HeadsetError::Size`], [`HeadsetError::Lacks`], or the error of the runtime.
    pub fn new(gpu: &Gpu, session: &xr::Session<xr::Vulkan>, size_px: [u32; 2]) -> Result<Self, HeadsetError> {
        let [width, height] = size_px;
        let most = gpu.device.limits().max_texture_dimension_2d;
        if width.max(height) > most {
            return Err(HeadsetError::Size { width, height, most });
        }
        let offered = session.enumerate_swapchain_formats().during("xrEnumerateSwapchainFormats")?;
        let known = FORMATS.iter().find(|(number, _)| offered.contains(number));
        let &(number, format) = known.ok_or_else(|| HeadsetError::Lacks {
            runtime: "the OpenXR runtime".to_owned(),
            what: "a supported colour format (8-bit RGBA or BGRA, or 16-bit RGBA)",
        })?;
        let swapchain = session
            .create_swapchain(&xr::SwapchainCreateInfo {
                create_flags: xr::SwapchainCreateFlags::EMPTY,
                usage_flags: xr::SwapchainUsageFlags::COLOR_ATTACHMENT,
                format: number,
                sample_count: 1,
                width,
                height,
                face_count: 1,
                array_size: 1,
                mip_count: 1,
            })
            .during("xrCreateSwapchain")?;
        let images = swapchain.enumerate_images().during("xrEnumerateSwapchainImages")?;
        let images = images
            .into_iter()
            .map(|image| {
                let texture = binding::texture_of(gpu, image, format, size_px)?;
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                Ok((texture, view))
            })
            .collect::<Result<Vec<_>, HeadsetError>>()?;
        Ok(Self { images, swapchain, format, size_px })
    }

    /// Returns the size of an image.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Returns the format of the images.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.format
    }

    /// Acquires the next image, and waits until the runtime no longer uses it.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub fn acquire(&mut self) -> Result<usize, HeadsetError> {
        let index = self.swapchain.acquire_image().during("xrAcquireSwapchainImage")? as usize;
        self.swapchain.wait_image(xr::Duration::INFINITE).during("xrWaitSwapchainImage")?;
        Ok(index)
    }

    /// Returns the image with an index, to draw on.
    pub fn image(&self, index: usize) -> Option<&(wgpu::Texture, wgpu::TextureView)> {
        self.images.get(index)
    }

    /// Releases the image to the runtime. The commands that draw on it must have been submitted.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub fn release(&mut self) -> Result<(), HeadsetError> {
        self.swapchain.release_image().during("xrReleaseSwapchainImage")
    }
}
