//! An OpenXR runtime without a headset, for tests. The OpenXR loader loads it through `XR_RUNTIME_JSON`.
//!
//! Poses and times follow from the frame's number alone. It does what a runtime does, and checks what a program must
//! do: the order of calls, handles, the types of structs, layers, sizes and layouts. A violation of the specification
//! is a line in the file that `HACHURE_XR_LOG` names, and the call fails with the error that the specification
//! prescribes. Other variables (`script.rs`) make it lose its session, take the headset off, or press buttons.
#![allow(unsafe_code, reason = "a runtime is called through pointers, whose types the loader and the program respect")]
#![allow(clippy::missing_safety_doc, reason = "the OpenXR specification says what each function requires")]
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes scratch files")]
#![allow(clippy::undocumented_unsafe_blocks, reason = "as above, in every function")]
#![allow(missing_docs, reason = "a part of a test")]

mod frames;
mod head;
mod input;
mod layers;
mod masks;
mod script;
mod state;
mod swapchains;
mod system;
mod vulkan;

use std::ffi::{CStr, c_char};

use openxr_sys as xr;

/// Returns a C function by its name.
macro_rules! functions {
    ($name:expr; $($function:literal => $value:expr => $kind:ident),* $(,)?) => {
        match $name {
            $($function => {
                let function: xr::pfn::$kind = $value;
                Some(unsafe { std::mem::transmute::<xr::pfn::$kind, xr::pfn::VoidFunction>(function) })
            })*
            _ => None,
        }
    };
}

#[unsafe(no_mangle)]
pub unsafe extern "system" fn xrNegotiateLoaderRuntimeInterface(
    loader: *const xr::NegotiateLoaderInfo,
    request: *mut xr::NegotiateRuntimeRequest,
) -> xr::Result {
    let (loader, request) = unsafe { (&*loader, &mut *request) };
    if loader.struct_type != xr::LoaderInterfaceStructs::LOADER_INFO
        || request.struct_type != xr::LoaderInterfaceStructs::RUNTIME_REQUEST
        || loader.min_interface_version > 1
    {
        return xr::Result::ERROR_INITIALIZATION_FAILED;
    }
    request.runtime_interface_version = 1;
    request.runtime_api_version = xr::Version::new(1, 0, 20);
    request.get_instance_proc_addr = Some(get_instance_proc_addr);
    xr::Result::SUCCESS
}

unsafe extern "system" fn get_instance_proc_addr(
    _instance: xr::Instance,
    name: *const c_char,
    function: *mut Option<xr::pfn::VoidFunction>,
) -> xr::Result {
    let name = unsafe { CStr::from_ptr(name) }.to_str().unwrap_or_default();
    let found = functions!(name;
        "xrGetInstanceProcAddr" => get_instance_proc_addr => GetInstanceProcAddr,
        "xrEnumerateInstanceExtensionProperties" => system::enumerate_extensions => EnumerateInstanceExtensionProperties,
        "xrEnumerateApiLayerProperties" => system::enumerate_layers => EnumerateApiLayerProperties,
        "xrCreateInstance" => system::create_instance => CreateInstance,
        "xrDestroyInstance" => system::destroy_instance => DestroyInstance,
        "xrGetInstanceProperties" => system::instance_properties => GetInstanceProperties,
        "xrResultToString" => system::result_to_string => ResultToString,
        "xrStructureTypeToString" => system::structure_type_to_string => StructureTypeToString,
        "xrGetSystem" => system::get_system => GetSystem,
        "xrGetSystemProperties" => system::system_properties => GetSystemProperties,
        "xrEnumerateViewConfigurations" => system::view_configurations => EnumerateViewConfigurations,
        "xrGetViewConfigurationProperties" => system::view_configuration => GetViewConfigurationProperties,
        "xrEnumerateViewConfigurationViews" => system::configuration_views => EnumerateViewConfigurationViews,
        "xrEnumerateEnvironmentBlendModes" => system::blend_modes => EnumerateEnvironmentBlendModes,
        "xrStringToPath" => system::string_to_path => StringToPath,
        "xrPathToString" => system::path_to_string => PathToString,
        "xrPollEvent" => frames::poll_event => PollEvent,
        "xrGetVulkanGraphicsRequirements2KHR" => vulkan::requirements => GetVulkanGraphicsRequirements2KHR,
        "xrCreateVulkanInstanceKHR" => vulkan::create_instance => CreateVulkanInstanceKHR,
        "xrGetVulkanGraphicsDevice2KHR" => vulkan::graphics_device => GetVulkanGraphicsDevice2KHR,
        "xrCreateVulkanDeviceKHR" => vulkan::create_device => CreateVulkanDeviceKHR,
        "xrCreateSession" => frames::create_session => CreateSession,
        "xrDestroySession" => frames::destroy_session => DestroySession,
        "xrBeginSession" => frames::begin_session => BeginSession,
        "xrEndSession" => frames::end_session => EndSession,
        "xrRequestExitSession" => frames::request_exit => RequestExitSession,
        "xrEnumerateReferenceSpaces" => frames::reference_spaces => EnumerateReferenceSpaces,
        "xrCreateReferenceSpace" => frames::create_reference_space => CreateReferenceSpace,
        "xrDestroySpace" => frames::destroy_space => DestroySpace,
        "xrLocateSpace" => frames::locate_space => LocateSpace,
        "xrGetReferenceSpaceBoundsRect" => frames::bounds_rect => GetReferenceSpaceBoundsRect,
        "xrWaitFrame" => frames::wait_frame => WaitFrame,
        "xrBeginFrame" => frames::begin_frame => BeginFrame,
        "xrEndFrame" => frames::end_frame => EndFrame,
        "xrGetVisibilityMaskKHR" => masks::visibility_mask => GetVisibilityMaskKHR,
        "xrPerfSettingsSetPerformanceLevelEXT" => system::set_performance_level => PerfSettingsSetPerformanceLevelEXT,
        "xrLocateViews" => frames::locate_views => LocateViews,
        "xrEnumerateSwapchainFormats" => swapchains::formats => EnumerateSwapchainFormats,
        "xrCreateSwapchain" => swapchains::create => CreateSwapchain,
        "xrDestroySwapchain" => swapchains::destroy => DestroySwapchain,
        "xrEnumerateSwapchainImages" => swapchains::images => EnumerateSwapchainImages,
        "xrAcquireSwapchainImage" => swapchains::acquire => AcquireSwapchainImage,
        "xrWaitSwapchainImage" => swapchains::wait => WaitSwapchainImage,
        "xrReleaseSwapchainImage" => swapchains::release => ReleaseSwapchainImage,
        "xrCreateActionSet" => input::create_action_set => CreateActionSet,
        "xrDestroyActionSet" => input::destroy_action_set => DestroyActionSet,
        "xrCreateAction" => input::create_action => CreateAction,
        "xrDestroyAction" => input::destroy_action => DestroyAction,
        "xrSuggestInteractionProfileBindings" => input::suggest => SuggestInteractionProfileBindings,
        "xrAttachSessionActionSets" => input::attach => AttachSessionActionSets,
        "xrGetCurrentInteractionProfile" => input::current_profile => GetCurrentInteractionProfile,
        "xrSyncActions" => input::sync => SyncActions,
        "xrGetActionStateBoolean" => input::boolean => GetActionStateBoolean,
        "xrGetActionStateFloat" => input::float => GetActionStateFloat,
        "xrGetActionStateVector2f" => input::vector => GetActionStateVector2f,
        "xrGetActionStatePose" => input::pose => GetActionStatePose,
        "xrCreateActionSpace" => input::create_action_space => CreateActionSpace,
        "xrEnumerateBoundSourcesForAction" => input::bound_sources => EnumerateBoundSourcesForAction,
        "xrGetInputSourceLocalizedName" => input::source_name => GetInputSourceLocalizedName,
        "xrApplyHapticFeedback" => input::apply_haptics => ApplyHapticFeedback,
        "xrStopHapticFeedback" => input::stop_haptics => StopHapticFeedback,
    );
    unsafe { *function = found };
    if found.is_some() { xr::Result::SUCCESS } else { xr::Result::ERROR_FUNCTION_UNSUPPORTED }
}
