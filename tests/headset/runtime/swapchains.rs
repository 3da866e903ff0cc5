//! Swapchains: their images are acquired and released, and released ones may be dumped.

use std::collections::VecDeque;

use ash::vk::{self, Handle as _};
use openxr_sys as xr;
use xr::Handle as _;

use super::state::{State, array, hold, status_of};
use super::vulkan::Image;

const IMAGES: usize = 3;

pub(crate) struct Chain {
    /// Index by order of creation; 0 is the left eye's, 2 the panel's.
    pub number: usize,
    pub size_px: [u32; 2],
    format: vk::Format,
    images: Vec<Image>,
    next: usize,
    /// Images that were acquired and not waited for, the oldest first.
    acquired: VecDeque<usize>,
    waited: Option<usize>,
    pub was_released: bool,
    /// Whether an image was released since the last frame ended.
    pub is_new: bool,
    /// Bytes of the last image that was released, if images are dumped.
    pub bytes: Vec<u8>,
    /// Name of the file to which the last image was dumped.
    pub file: String,
}

impl Chain {
    /// Returns whether the program holds an image.
    pub(crate) fn is_held(&self) -> bool {
        self.waited.is_some() || !self.acquired.is_empty()
    }

    fn texel_bytes(&self) -> u64 {
        if self.format == vk::Format::R16G16B16A16_SFLOAT { 8 } else { 4 }
    }
}

pub(crate) unsafe extern "system" fn formats(
    session: xr::Session,
    capacity: u32,
    count: *mut u32,
    out: *mut i64,
) -> xr::Result {
    let mut state = hold();
    status_of((|| {
        state.session("xrEnumerateSwapchainFormats", session)?;
        Ok(array(&state.script.formats, capacity, count, out))
    })())
}

pub(crate) unsafe extern "system" fn create(
    session: xr::Session,
    info: *const xr::SwapchainCreateInfo,
    out: *mut xr::Swapchain,
) -> xr::Result {
    const CALL: &str = "xrCreateSwapchain";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.session(CALL, session)?;
        state.check(CALL, (info.ty, info.next), xr::SwapchainCreateInfo::TYPE)?;
        if !state.script.formats.contains(&info.format) {
            let error = xr::Result::ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
            return Err(state.violation(CALL, "a format that was not offered", error));
        }
        let counts = [info.sample_count, info.face_count, info.array_size, info.mip_count];
        let is_plain = counts == [1; 4] && info.usage_flags == xr::SwapchainUsageFlags::COLOR_ATTACHMENT;
        if !is_plain || info.width == 0 || info.height == 0 {
            let error = xr::Result::ERROR_FEATURE_UNSUPPORTED;
            return Err(state.violation(CALL, "an image that this runtime does not have", error));
        }
        let (size_px, format) = ([info.width, info.height], vk::Format::from_raw(info.format as i32));
        let vulkan = state.vulkan.as_ref().ok_or(xr::Result::ERROR_RUNTIME_FAILURE)?;
        let images = (0..IMAGES).map(|_| vulkan.image(format, size_px)).collect();
        let handle = state.handle();
        let session = state.session(CALL, session)?;
        let number = session.chains.len();
        session.chains.insert(
            handle,
            Chain {
                number,
                size_px,
                format,
                images,
                next: 0,
                acquired: VecDeque::new(),
                waited: None,
                was_released: false,
                is_new: false,
                bytes: Vec::new(),
                file: String::new(),
            },
        );
        unsafe { *out = xr::Swapchain::from_raw(handle) };
        Ok(xr::Result::SUCCESS)
    })())
}

/// Returns the swapchain with this handle.
fn chain<'a>(state: &'a mut State, call: &str, swapchain: xr::Swapchain) -> Result<&'a mut Chain, xr::Result> {
    use super::state::SESSION;
    let handle = swapchain.into_raw();
    if !state.session.as_ref().is_some_and(|session| session.chains.contains_key(&handle)) {
        return Err(state.violation(call, "no such swapchain", xr::Result::ERROR_HANDLE_INVALID));
    }
    let session = state.session(call, xr::Session::from_raw(SESSION))?;
    session.chains.get_mut(&handle).ok_or(xr::Result::ERROR_HANDLE_INVALID)
}

pub(crate) unsafe extern "system" fn destroy(swapchain: xr::Swapchain) -> xr::Result {
    let mut state = hold();
    // A swapchain can be destroyed even if the session is lost.
    let removed = state.session.as_mut().and_then(|session| session.chains.remove(&swapchain.into_raw()));
    let Some(removed) = removed else {
        return state.violation("xrDestroySwapchain", "no such swapchain", xr::Result::ERROR_HANDLE_INVALID);
    };
    if let Some(vulkan) = &state.vulkan {
        removed.images.iter().for_each(|image| vulkan.destroy(image));
    }
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn images(
    swapchain: xr::Swapchain,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::SwapchainImageBaseHeader,
) -> xr::Result {
    const CALL: &str = "xrEnumerateSwapchainImages";
    let mut state = hold();
    status_of((|| {
        let handles: Vec<u64> =
            chain(&mut state, CALL, swapchain)?.images.iter().map(|image| image.image.as_raw()).collect();
        unsafe { *count = handles.len() as u32 };
        if capacity == 0 {
            return Ok(xr::Result::SUCCESS);
        }
        if (capacity as usize) < handles.len() {
            return Err(xr::Result::ERROR_SIZE_INSUFFICIENT);
        }
        for (i, handle) in handles.into_iter().enumerate() {
            let image = unsafe { &mut *out.cast::<xr::SwapchainImageVulkanKHR>().add(i) };
            state.check(CALL, (image.ty, image.next), xr::SwapchainImageVulkanKHR::TYPE)?;
            image.image = handle;
        }
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn acquire(
    swapchain: xr::Swapchain,
    info: *const xr::SwapchainImageAcquireInfo,
    index: *mut u32,
) -> xr::Result {
    const CALL: &str = "xrAcquireSwapchainImage";
    let mut state = hold();
    status_of((|| {
        if let Some(info) = unsafe { info.as_ref() } {
            state.check(CALL, (info.ty, info.next), xr::SwapchainImageAcquireInfo::TYPE)?;
        }
        let chain = chain(&mut state, CALL, swapchain)?;
        if chain.acquired.len() + usize::from(chain.waited.is_some()) == IMAGES {
            return Err(state.violation(CALL, "all images are acquired", xr::Result::ERROR_CALL_ORDER_INVALID));
        }
        unsafe { *index = chain.next as u32 };
        chain.acquired.push_back(chain.next);
        chain.next = (chain.next + 1) % IMAGES;
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn wait(
    swapchain: xr::Swapchain,
    info: *const xr::SwapchainImageWaitInfo,
) -> xr::Result {
    const CALL: &str = "xrWaitSwapchainImage";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::SwapchainImageWaitInfo::TYPE)?;
        let chain = chain(&mut state, CALL, swapchain)?;
        match (chain.waited, chain.acquired.pop_front()) {
            (None, Some(image)) => chain.waited = Some(image),
            _ => return Err(state.violation(CALL, "nothing to wait for", xr::Result::ERROR_CALL_ORDER_INVALID)),
        }
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn release(
    swapchain: xr::Swapchain,
    info: *const xr::SwapchainImageReleaseInfo,
) -> xr::Result {
    const CALL: &str = "xrReleaseSwapchainImage";
    let mut state = hold();
    status_of((|| {
        if let Some(info) = unsafe { info.as_ref() } {
            state.check(CALL, (info.ty, info.next), xr::SwapchainImageReleaseInfo::TYPE)?;
        }
        let wants = state.script.dump.is_some();
        let Some(image) = chain(&mut state, CALL, swapchain)?.waited.take() else {
            return Err(state.violation(CALL, "no image was waited for", xr::Result::ERROR_CALL_ORDER_INVALID));
        };
        let State { vulkan, session, .. } = &mut *state;
        let chain = session.as_mut().and_then(|session| session.chains.get_mut(&swapchain.into_raw()));
        let (Some(vulkan), Some(chain)) = (vulkan, chain) else { return Err(xr::Result::ERROR_RUNTIME_FAILURE) };
        chain.bytes = vulkan.take(&chain.images[image], chain.size_px, chain.texel_bytes(), wants);
        (chain.was_released, chain.is_new) = (true, true);
        Ok(xr::Result::SUCCESS)
    })())
}
