//! The images that the runtime shows: a swapchain for each eye.

use openxr as xr;

use super::binding;
use super::error::{During, HeadsetError};
use crate::gpu::Gpu;

/// Formats that the runtime may offer, as Vulkan numbers them, in the order in which they are taken. The runtime reads
/// what is encoded as sRGB, and takes everything else as linear light; eight linear bits show steps in the dark.
const FORMATS: [(u32, wgpu::TextureFormat); 5] = [
    (43, wgpu::TextureFormat::Rgba8UnormSrgb),
    (50, wgpu::TextureFormat::Bgra8UnormSrgb),
    (97, wgpu::TextureFormat::Rgba16Float),
    (37, wgpu::TextureFormat::Rgba8Unorm),
    (44, wgpu::TextureFormat::Bgra8Unorm),
];

/// The images of an eye. They go before the swapchain.
pub struct EyeImages {
    images: Vec<(wgpu::Texture, wgpu::TextureView)>,
    /// The runtime's.
    pub swapchain: xr::Swapchain<xr::Vulkan>,
    format: wgpu::TextureFormat,
    size_px: [u32; 2],
}

impl EyeImages {
    /// Images of a size, in the best format that the runtime has.
    ///
    /// # Errors
    /// [`HeadsetError::Size`], [`HeadsetError::Lacks`], and what the runtime says.
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
            what: "a colour format that hachure knows (RGBA or BGRA of 8 bits, RGBA of 16)",
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

    /// Width and height.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Of the images.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.format
    }

    /// The next image, when the runtime has done with it.
    ///
    /// # Errors
    /// What the runtime says.
    pub fn acquire(&mut self) -> Result<usize, HeadsetError> {
        let index = self.swapchain.acquire_image().during("xrAcquireSwapchainImage")? as usize;
        self.swapchain.wait_image(xr::Duration::INFINITE).during("xrWaitSwapchainImage")?;
        Ok(index)
    }

    /// To draw on the image of a number.
    pub fn image(&self, index: usize) -> Option<&(wgpu::Texture, wgpu::TextureView)> {
        self.images.get(index)
    }

    /// Hands the image back. What draws on it was submitted.
    ///
    /// # Errors
    /// What the runtime says.
    pub fn release(&mut self) -> Result<(), HeadsetError> {
        self.swapchain.release_image().during("xrReleaseSwapchainImage")
    }
}
