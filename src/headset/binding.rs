//! The connection between OpenXR, Vulkan and wgpu: everything that Rust cannot check.
//!
//! The runtime creates the Vulkan instance and device with the extensions and features that wgpu requires
//! (`XR_KHR_vulkan_enable2`), and wgpu takes over both. The images of a swapchain belong to the runtime: wgpu draws on
//! them and never destroys them.
#![allow(unsafe_code, reason = "foreign libraries and raw handles; every block says why it is sound")]

use std::ffi::CStr;

use ash::vk::{self, Handle as _};
use openxr as xr;
use wgpu::hal;
use wgpu::hal::api::Vulkan;

use super::error::{During, HeadsetError};
use crate::gpu::Gpu;
use crate::gpu::device::instance_descriptor;

/// The newest Vulkan version that wgpu requests from a driver.
const NEWEST_VULKAN: u32 = vk::API_VERSION_1_3;

/// Handles of the device that the runtime created, which a session needs.
#[derive(Clone, Copy)]
pub(super) struct Binding {
    instance: vk::Instance,
    physical_device: vk::PhysicalDevice,
    device: vk::Device,
    queue_family: u32,
}

/// Loads the OpenXR loader, from where the system finds libraries.
///
/// # Errors
/// Returns [`HeadsetError::NoLoader`] if it cannot be loaded.
pub(super) fn load() -> Result<xr::Entry, HeadsetError> {
    // SAFETY: a library of this name is the OpenXR loader, which follows the specification.
    unsafe { xr::Entry::load(&()) }.map_err(|error| {
        let cause = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
        HeadsetError::NoLoader { cause }
    })
}

/// Opens the GPU to which the headset is connected.
///
/// # Errors
/// Returns [`HeadsetError::NoVulkan`], or the error of the runtime.
pub(super) fn open_gpu(instance: &xr::Instance, system: xr::SystemId) -> Result<(Gpu, Binding), HeadsetError> {
    let needs = instance.graphics_requirements::<xr::Vulkan>(system).during("xrGetVulkanGraphicsRequirements2KHR")?;
    // SAFETY: a library of this name is the Vulkan loader.
    let entry = unsafe { ash::Entry::load() }.map_err(no_vulkan)?;
    // SAFETY: the entry was just loaded.
    let known = unsafe { entry.try_enumerate_instance_version() }.map_err(no_vulkan)?.unwrap_or(vk::API_VERSION_1_0);
    let version = if known < vk::API_VERSION_1_1 { vk::API_VERSION_1_0 } else { NEWEST_VULKAN.min(known) };
    let version_xr = xr::Version::new(vk::api_version_major(version) as u16, vk::api_version_minor(version) as u16, 0);
    if version_xr < needs.min_api_version_supported {
        return Err(no_vulkan(format!(
            "the headset requires version {}, and the system has {version_xr}",
            needs.min_api_version_supported
        )));
    }
    let flags = instance_descriptor().flags - wgpu::InstanceFlags::VALIDATION;
    let extensions = hal::vulkan::Instance::desired_extensions(&entry, known, flags).map_err(no_vulkan)?;
    let hal_instance = open_instance(instance, system, &entry, [known, version], extensions, flags)?;
    let raw_instance = hal_instance.shared_instance().raw_instance().clone();

    // SAFETY: the runtime has just created the instance.
    let physical_device = unsafe { instance.vulkan_graphics_device(system, raw_instance.handle().as_raw() as _) }
        .during("xrGetVulkanGraphicsDevice2KHR")?;
    let physical_device = vk::PhysicalDevice::from_raw(physical_device as _);
    let exposed = hal_instance
        .expose_adapter(physical_device)
        .ok_or_else(|| no_vulkan("the GPU of the headset is too old for wgpu"))?;
    let features = exposed.features & wgpu_profiler::GpuProfiler::ALL_WGPU_TIMER_FEATURES;
    let limits = exposed.capabilities.limits.clone();

    // SAFETY: the physical device is one of this instance.
    let families = unsafe { raw_instance.get_physical_device_queue_family_properties(physical_device) };
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let queue_family = families.iter().position(|family| family.queue_flags.contains(both));
    let queue_family =
        queue_family.ok_or_else(|| no_vulkan("the GPU of the headset has no queue for graphics and compute"))? as u32;
    let extensions = exposed.adapter.required_device_extensions(features);
    let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
    let mut enabled = exposed.adapter.physical_device_features(&extensions, features);
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&names);
    let info = enabled.add_to_device_create(info);
    // SAFETY: everything that the create info points to lives until the call returns, and Vulkan's types are the same
    // in both crates: pointers and functions of C.
    let made = unsafe {
        let get = std::mem::transmute::<vk::PFN_vkGetInstanceProcAddr, xr::sys::platform::VkGetInstanceProcAddr>(
            entry.static_fn().get_instance_proc_addr,
        );
        instance.create_vulkan_device(system, get, physical_device.as_raw() as _, (&raw const info).cast())
    };
    let device = made.during("xrCreateVulkanDeviceKHR")?.map_err(|code| no_vulkan(vk::Result::from_raw(code)))?;
    // SAFETY: the device was just created from this instance.
    let device = unsafe { ash::Device::load(raw_instance.fp_v1_0(), vk::Device::from_raw(device as _)) };
    let binding = Binding { instance: raw_instance.handle(), physical_device, device: device.handle(), queue_family };

    let hints = wgpu::MemoryHints::default();
    // SAFETY: the device was created from this adapter, with these extensions, features and queues. wgpu destroys it.
    let opened = unsafe {
        exposed.adapter.device_from_raw(device, None, &extensions, features, &limits, &hints, queue_family, 0)
    };
    let opened = opened.map_err(no_vulkan)?;
    // SAFETY: the hal's instance and adapter are those of the runtime, and belong together.
    let (instance, adapter) = unsafe {
        let instance = wgpu::Instance::from_hal::<Vulkan>(hal_instance);
        let adapter = instance.create_adapter_from_hal(exposed);
        (instance, adapter)
    };
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("hachure"),
        required_features: features,
        required_limits: limits,
        memory_hints: hints,
        ..Default::default()
    };
    // SAFETY: this adapter opened the device with these features.
    let (device, queue) = unsafe { adapter.create_device_from_hal::<Vulkan>(opened, &descriptor) }
        .map_err(|source| crate::gpu::GpuError::NoDevice { adapter: adapter.get_info().name, source })?;
    Ok((Gpu::of_device(instance, adapter, device, queue), binding))
}

/// Creates the runtime's Vulkan instance with the extensions that wgpu expects, and wraps it for wgpu.
fn open_instance(
    instance: &xr::Instance,
    system: xr::SystemId,
    entry: &ash::Entry,
    [known, version]: [u32; 2],
    extensions: Vec<&'static CStr>,
    flags: wgpu::InstanceFlags,
) -> Result<hal::vulkan::Instance, HeadsetError> {
    let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
    let application = vk::ApplicationInfo::default()
        .application_name(c"hachure")
        .application_version(1)
        .engine_name(c"wgpu-hal")
        .engine_version(2)
        .api_version(version);
    let info = vk::InstanceCreateInfo::default().application_info(&application).enabled_extension_names(&names);
    // SAFETY: as for the device.
    let made = unsafe {
        let get = std::mem::transmute::<vk::PFN_vkGetInstanceProcAddr, xr::sys::platform::VkGetInstanceProcAddr>(
            entry.static_fn().get_instance_proc_addr,
        );
        instance.create_vulkan_instance(system, get, (&raw const info).cast())
    };
    let made = made.during("xrCreateVulkanInstanceKHR")?.map_err(|code| no_vulkan(vk::Result::from_raw(code)))?;
    // SAFETY: the instance was just created through this entry.
    let raw = unsafe { ash::Instance::load(entry.static_fn(), vk::Instance::from_raw(made as _)) };
    // SAFETY: the entry is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.map_err(no_vulkan)?;
    let has_optimus = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(c"VK_LAYER_NV_optimus"));
    // SAFETY: the instance was created through this entry with these extensions, which wgpu requested. wgpu destroys
    // it.
    unsafe {
        hal::vulkan::Instance::from_raw(
            entry.clone(),
            raw,
            known,
            0,
            None,
            extensions,
            flags,
            wgpu::MemoryBudgetThresholds::default(),
            has_optimus,
            None,
        )
    }
    .map_err(no_vulkan)
}

/// An open session: its handle, the waiter for frames, and the stream that takes frames.
pub(super) type Opened = (xr::Session<xr::Vulkan>, xr::FrameWaiter, xr::FrameStream<xr::Vulkan>);

/// Opens a session that draws with `gpu`, which lives at least as long.
///
/// The runtime may use the queue while a frame begins or ends and while an image is acquired or released. The caller
/// draws on one thread, and nothing else in hachure submits: the background threads build pipelines and fill textures,
/// which wgpu submits with the next frame.
///
/// # Errors
/// Returns the error of the runtime.
pub(super) fn open_session(
    instance: &xr::Instance,
    system: xr::SystemId,
    gpu: &Gpu,
    binding: Binding,
) -> Result<Opened, HeadsetError> {
    let info = xr::vulkan::SessionCreateInfo {
        instance: binding.instance.as_raw() as _,
        physical_device: binding.physical_device.as_raw() as _,
        device: binding.device.as_raw() as _,
        queue_family_index: binding.queue_family,
        queue_index: 0,
    };
    // SAFETY: the handles are those of the GPU, and the session holds a clone of it until the session is destroyed.
    unsafe { instance.create_session_with_guard::<xr::Vulkan>(system, &info, Box::new(gpu.clone())) }
        .during("xrCreateSession")
}

/// Wraps an image of a swapchain as a texture to draw on. The texture must be dropped before its swapchain.
pub(super) fn texture_of(
    gpu: &Gpu,
    image: u64,
    format: wgpu::TextureFormat,
    size_px: [u32; 2],
) -> Result<wgpu::Texture, HeadsetError> {
    let size = wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 };
    let label = Some("headset");
    let hal_descriptor = hal::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUses::COLOR_TARGET,
        memory_flags: hal::MemoryFlags::empty(),
        view_formats: Vec::new(),
    };
    let descriptor = wgpu::TextureDescriptor {
        label,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    };
    // SAFETY: the device was created on Vulkan.
    let device = unsafe { gpu.device.as_hal::<Vulkan>() }.ok_or_else(|| no_vulkan("the device does not use Vulkan"))?;
    // SAFETY: the runtime created the image with this size and format, as an attachment. The callback makes wgpu leave
    // the image's destruction to the runtime. An acquired image is in the layout of an attachment.
    Ok(unsafe {
        let memory = hal::vulkan::TextureMemory::External;
        let image = vk::Image::from_raw(image);
        let texture = device.texture_from_raw(image, &hal_descriptor, Some(Box::new(|| ())), memory);
        gpu.device.create_texture_from_hal::<Vulkan>(texture, &descriptor, wgpu::TextureUses::COLOR_TARGET)
    })
}

fn no_vulkan(cause: impl std::fmt::Display) -> HeadsetError {
    HeadsetError::NoVulkan { cause: cause.to_string() }
}
