//! Vulkan, shared by the program and the runtime: the runtime creates the instance and the device, and copies images
//! out.

use std::ffi::c_char;

use ash::vk::{self, Handle as _};
use openxr_sys as xr;

use super::state::{hold, status_of};
use super::system::check_system;

const VIEWS: xr::ViewConfigurationType = xr::ViewConfigurationType::PRIMARY_STEREO;

/// The Vulkan objects that the program draws with.
pub(crate) struct Vulkan {
    pub instance: ash::Instance,
    pub physical_device: Option<vk::PhysicalDevice>,
    pub device: Option<ash::Device>,
    pub queue: Option<Queue>,
}

/// The session's queue, and the command buffer into which the runtime records.
pub(crate) struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
}

/// An image of a swapchain.
pub(crate) struct Image {
    pub image: vk::Image,
    memory: vk::DeviceMemory,
}

pub(crate) unsafe extern "system" fn requirements(
    instance: xr::Instance,
    system: xr::SystemId,
    out: *mut xr::GraphicsRequirementsVulkanKHR,
) -> xr::Result {
    const CALL: &str = "xrGetVulkanGraphicsRequirements2KHR";
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        check_system(&mut state, CALL, instance, system, VIEWS)?;
        state.check(CALL, (out.ty, out.next), xr::GraphicsRequirementsVulkanKHR::TYPE)?;
        out.min_api_version_supported = xr::Version::new(1, 0, 0);
        out.max_api_version_supported = xr::Version::new(1, 2, 0);
        state.asked_requirements = true;
        Ok(xr::Result::SUCCESS)
    })())
}

type GetProc = unsafe extern "system" fn(vk::Instance, *const c_char) -> vk::PFN_vkVoidFunction;

fn static_fn(get: Option<xr::platform::VkGetInstanceProcAddr>) -> Option<ash::StaticFn> {
    let get = get?;
    let get_instance_proc_addr = unsafe { std::mem::transmute::<xr::platform::VkGetInstanceProcAddr, GetProc>(get) };
    Some(ash::StaticFn { get_instance_proc_addr })
}

pub(crate) unsafe extern "system" fn create_instance(
    instance: xr::Instance,
    info: *const xr::VulkanInstanceCreateInfoKHR,
    out: *mut xr::platform::VkInstance,
    result: *mut xr::platform::VkResult,
) -> xr::Result {
    const CALL: &str = "xrCreateVulkanInstanceKHR";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        check_system(&mut state, CALL, instance, info.system_id, VIEWS)?;
        state.check(CALL, (info.ty, info.next), xr::VulkanInstanceCreateInfoKHR::TYPE)?;
        if !state.asked_requirements {
            let error = xr::Result::ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
            return Err(state.violation(CALL, "the requirements were not queried", error));
        }
        let Some(static_fn) = static_fn(info.pfn_get_instance_proc_addr) else {
            return Err(state.violation(CALL, "no functions of Vulkan", xr::Result::ERROR_VALIDATION_FAILURE));
        };
        let entry = unsafe { ash::Entry::from_static_fn(static_fn) };
        match unsafe { entry.create_instance(&*info.vulkan_create_info.cast(), None) } {
            Ok(made) => {
                unsafe { (*out, *result) = (made.handle().as_raw() as _, 0) };
                state.vulkan = Some(Vulkan { instance: made, physical_device: None, device: None, queue: None });
            }
            Err(error) => unsafe { *result = error.as_raw() },
        }
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn graphics_device(
    instance: xr::Instance,
    info: *const xr::VulkanGraphicsDeviceGetInfoKHR,
    out: *mut xr::platform::VkPhysicalDevice,
) -> xr::Result {
    const CALL: &str = "xrGetVulkanGraphicsDevice2KHR";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        check_system(&mut state, CALL, instance, info.system_id, VIEWS)?;
        state.check(CALL, (info.ty, info.next), xr::VulkanGraphicsDeviceGetInfoKHR::TYPE)?;
        let wrong = xr::Result::ERROR_VALIDATION_FAILURE;
        let handle = state.vulkan.as_ref().map(|vulkan| vulkan.instance.handle().as_raw());
        if handle != Some(info.vulkan_instance as u64) {
            return Err(state.violation(CALL, "not the instance that the runtime made", wrong));
        }
        let vulkan = state.vulkan.as_mut().ok_or(wrong)?;
        let devices = unsafe { vulkan.instance.enumerate_physical_devices() }.map_err(|_| wrong)?;
        let device = *devices.first().ok_or(xr::Result::ERROR_RUNTIME_FAILURE)?;
        vulkan.physical_device = Some(device);
        unsafe { *out = device.as_raw() as _ };
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn create_device(
    instance: xr::Instance,
    info: *const xr::VulkanDeviceCreateInfoKHR,
    out: *mut xr::platform::VkDevice,
    result: *mut xr::platform::VkResult,
) -> xr::Result {
    const CALL: &str = "xrCreateVulkanDeviceKHR";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        check_system(&mut state, CALL, instance, info.system_id, VIEWS)?;
        state.check(CALL, (info.ty, info.next), xr::VulkanDeviceCreateInfoKHR::TYPE)?;
        let given = state.vulkan.as_ref().and_then(|vulkan| vulkan.physical_device);
        let Some(physical) = given.filter(|given| given.as_raw() == info.vulkan_physical_device as u64) else {
            let error = xr::Result::ERROR_VALIDATION_FAILURE;
            return Err(state.violation(CALL, "not the physical device that the runtime named", error));
        };
        let vulkan = state.vulkan.as_mut().ok_or(xr::Result::ERROR_VALIDATION_FAILURE)?;
        match unsafe { vulkan.instance.create_device(physical, &*info.vulkan_create_info.cast(), None) } {
            Ok(device) => {
                unsafe { (*out, *result) = (device.handle().as_raw() as _, 0) };
                vulkan.device = Some(device);
            }
            Err(error) => unsafe { *result = error.as_raw() },
        }
        Ok(xr::Result::SUCCESS)
    })())
}

impl Vulkan {
    /// Checks that a session's binding contains the objects that the runtime created, and takes the queue.
    pub(crate) fn bind(&mut self, binding: &xr::GraphicsBindingVulkanKHR) -> Option<()> {
        let device = self.device.as_ref()?;
        let is_own = self.instance.handle().as_raw() == binding.instance as u64
            && self.physical_device?.as_raw() == binding.physical_device as u64
            && device.handle().as_raw() == binding.device as u64;
        if !is_own {
            return None;
        }
        let flags = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(binding.queue_family_index).flags(flags);
        self.queue = Some(unsafe {
            let raw = device.get_device_queue(binding.queue_family_index, binding.queue_index);
            let pool = device.create_command_pool(&info, None).ok()?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Queue { raw, pool, commands: device.allocate_command_buffers(&info).ok()?[0] }
        });
        Some(())
    }

    /// Releases the queue.
    pub(crate) fn unbind(&mut self) {
        if let (Some(device), Some(queue)) = (&self.device, self.queue.take()) {
            unsafe { device.destroy_command_pool(queue.pool, None) };
        }
    }

    fn memory(&self, needs: vk::MemoryRequirements, flags: vk::MemoryPropertyFlags) -> vk::DeviceMemory {
        let device = self.device.as_ref().unwrap();
        let types = unsafe { self.instance.get_physical_device_memory_properties(self.physical_device.unwrap()) };
        let index = (0..types.memory_type_count).find(|index| {
            needs.memory_type_bits & (1 << index) != 0
                && types.memory_types[*index as usize].property_flags.contains(flags)
        });
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index.unwrap());
        unsafe { device.allocate_memory(&info, None) }.unwrap()
    }

    /// Returns an image to draw on, in the layout of an acquired image.
    pub(crate) fn image(&self, format: vk::Format, [width, height]: [u32; 2]) -> Image {
        let device = self.device.as_ref().unwrap();
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC);
        let image = unsafe { device.create_image(&info, None) }.unwrap();
        let memory =
            self.memory(unsafe { device.get_image_memory_requirements(image) }, vk::MemoryPropertyFlags::empty());
        unsafe { device.bind_image_memory(image, memory, 0) }.unwrap();
        self.run(|device, commands| {
            barrier(device, commands, image, vk::ImageLayout::UNDEFINED, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        });
        Image { image, memory }
    }

    pub(crate) fn destroy(&self, image: &Image) {
        let device = self.device.as_ref().unwrap();
        unsafe {
            device.destroy_image(image.image, None);
            device.free_memory(image.memory, None);
        }
    }

    /// Takes a released image and returns it to the swapchain. Returns its bytes if `wants`. It expects the layout that
    /// the specification requires, so the validation layer reports any other layout.
    pub(crate) fn take(&self, image: &Image, [width, height]: [u32; 2], texel_bytes: u64, wants: bool) -> Vec<u8> {
        let device = self.device.as_ref().unwrap();
        let bytes = u64::from(width) * u64::from(height) * texel_bytes;
        let (attachment, source) = (vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let buffer = wants.then(|| unsafe {
            let info = vk::BufferCreateInfo::default().size(bytes).usage(vk::BufferUsageFlags::TRANSFER_DST);
            let buffer = device.create_buffer(&info, None).unwrap();
            let memory = self.memory(device.get_buffer_memory_requirements(buffer), host);
            device.bind_buffer_memory(buffer, memory, 0).unwrap();
            (buffer, memory)
        });
        self.run(|device, commands| {
            barrier(device, commands, image.image, attachment, source);
            if let Some((buffer, _)) = buffer {
                let layers =
                    vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
                let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
                    width,
                    height,
                    depth: 1,
                });
                unsafe { device.cmd_copy_image_to_buffer(commands, image.image, source, buffer, &[region]) };
            }
            barrier(device, commands, image.image, source, attachment);
        });
        let Some((buffer, memory)) = buffer else { return Vec::new() };
        unsafe {
            let mapped = device.map_memory(memory, 0, bytes, vk::MemoryMapFlags::empty()).unwrap();
            let copied = std::slice::from_raw_parts(mapped.cast::<u8>(), bytes as usize).to_vec();
            device.unmap_memory(memory);
            device.destroy_buffer(buffer, None);
            device.free_memory(memory, None);
            copied
        }
    }

    /// Records, submits and waits.
    fn run(&self, record: impl FnOnce(&ash::Device, vk::CommandBuffer)) {
        let (device, queue) = (self.device.as_ref().unwrap(), self.queue.as_ref().unwrap());
        let once = vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT;
        unsafe {
            device.begin_command_buffer(queue.commands, &vk::CommandBufferBeginInfo::default().flags(once)).unwrap();
            record(device, queue.commands);
            device.end_command_buffer(queue.commands).unwrap();
            let commands = [queue.commands];
            let submit = vk::SubmitInfo::default().command_buffers(&commands);
            device.queue_submit(queue.raw, &[submit], vk::Fence::null()).unwrap();
            device.queue_wait_idle(queue.raw).unwrap();
        }
    }
}

fn barrier(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    image: vk::Image,
    from: vk::ImageLayout,
    to: vk::ImageLayout,
) {
    let range =
        vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1);
    let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
    let barrier = vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(from)
        .new_layout(to)
        .src_access_mask(all)
        .dst_access_mask(all)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(range);
    let (stages, none) = (vk::PipelineStageFlags::ALL_COMMANDS, vk::DependencyFlags::empty());
    unsafe { device.cmd_pipeline_barrier(commands, stages, stages, none, &[], &[], &[barrier]) };
}
