//! The instance, the system, and paths of the runtime.

use std::ffi::{CStr, c_char};

use openxr_sys as xr;
use xr::Handle as _;

use super::state::{INSTANCE, SYSTEM, State, array, hold, status_of, text};

const VIEWS: xr::ViewConfigurationType = xr::ViewConfigurationType::PRIMARY_STEREO;
/// Larger than any size that is requested.
const MAX_PX: u32 = 8192;

pub(crate) unsafe extern "system" fn enumerate_extensions(
    layer: *const c_char,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::ExtensionProperties,
) -> xr::Result {
    let state = hold();
    if !layer.is_null() {
        return xr::Result::ERROR_API_LAYER_NOT_PRESENT;
    }
    let mut names = vec![if state.script.has_vulkan { "XR_KHR_vulkan_enable2" } else { "XR_KHR_opengl_enable" }];
    names.extend(state.script.has_mask.then_some("XR_KHR_visibility_mask"));
    names.extend(state.script.hot.map(|_| "XR_EXT_performance_settings"));
    unsafe { *count = names.len() as u32 };
    if capacity == 0 {
        return xr::Result::SUCCESS;
    }
    for (i, name) in names.iter().enumerate() {
        let properties = unsafe { &mut *out.add(i) };
        if properties.ty != xr::ExtensionProperties::TYPE {
            return xr::Result::ERROR_VALIDATION_FAILURE;
        }
        text(name, &mut properties.extension_name);
        properties.extension_version = 2;
    }
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn enumerate_layers(
    _capacity: u32,
    count: *mut u32,
    _out: *mut xr::ApiLayerProperties,
) -> xr::Result {
    unsafe { *count = 0 };
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn create_instance(
    info: *const xr::InstanceCreateInfo,
    instance: *mut xr::Instance,
) -> xr::Result {
    let (mut state, info) = (hold(), unsafe { &*info });
    if let Some(error) = state.script.without_service {
        return error;
    }
    if info.ty != xr::InstanceCreateInfo::TYPE || state.has_instance {
        return state.violation("xrCreateInstance", "wrong type, or twice", xr::Result::ERROR_VALIDATION_FAILURE);
    }
    if info.application_info.api_version > xr::Version::new(1, 0, 0xffff_ffff) {
        return xr::Result::ERROR_API_VERSION_UNSUPPORTED;
    }
    if info.application_info.application_name[0] == 0 {
        return state.violation("xrCreateInstance", "no name", xr::Result::ERROR_NAME_INVALID);
    }
    for i in 0..info.enabled_extension_count as usize {
        let name = unsafe { CStr::from_ptr(*info.enabled_extension_names.add(i)) };
        let is_mask = state.script.has_mask && name == c"XR_KHR_visibility_mask";
        let gives_notice = state.script.hot.is_some() && name == c"XR_EXT_performance_settings";
        if !is_mask && !gives_notice && (!state.script.has_vulkan || name != c"XR_KHR_vulkan_enable2") {
            return xr::Result::ERROR_EXTENSION_NOT_PRESENT;
        }
        state.enabled_masks |= is_mask;
    }
    state.has_instance = true;
    unsafe { *instance = xr::Instance::from_raw(INSTANCE) };
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn destroy_instance(instance: xr::Instance) -> xr::Result {
    let mut state = hold();
    if !state.has_instance || instance.into_raw() != INSTANCE {
        return state.violation("xrDestroyInstance", "no such instance", xr::Result::ERROR_HANDLE_INVALID);
    }
    if state.session.is_some() {
        state.violation("xrDestroyInstance", "the session is still there", xr::Result::SUCCESS);
    }
    state.has_instance = false;
    let (frames, violations, empty) = (state.frames, state.violations, state.empty_frames);
    state.log(&format!("ended after {frames} frames with {violations} violations and {empty} empty frames"));
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn instance_properties(
    instance: xr::Instance,
    out: *mut xr::InstanceProperties,
) -> xr::Result {
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        state.instance("xrGetInstanceProperties", instance)?;
        state.check("xrGetInstanceProperties", (out.ty, out.next), xr::InstanceProperties::TYPE)?;
        out.runtime_version = xr::Version::new(1, 0, 0);
        text("hachure's test runtime", &mut out.runtime_name);
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn result_to_string(
    _instance: xr::Instance,
    value: xr::Result,
    out: *mut c_char,
) -> xr::Result {
    text(&format!("{value:?}"), unsafe { std::slice::from_raw_parts_mut(out, xr::MAX_RESULT_STRING_SIZE) });
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn structure_type_to_string(
    _instance: xr::Instance,
    value: xr::StructureType,
    out: *mut c_char,
) -> xr::Result {
    text(&format!("{value:?}"), unsafe { std::slice::from_raw_parts_mut(out, xr::MAX_STRUCTURE_NAME_SIZE) });
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn get_system(
    instance: xr::Instance,
    info: *const xr::SystemGetInfo,
    system: *mut xr::SystemId,
) -> xr::Result {
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.instance("xrGetSystem", instance)?;
        state.check("xrGetSystem", (info.ty, info.next), xr::SystemGetInfo::TYPE)?;
        if info.form_factor != xr::FormFactor::HEAD_MOUNTED_DISPLAY {
            return Err(xr::Result::ERROR_FORM_FACTOR_UNSUPPORTED);
        }
        if let Some(error) = state.script.without_system {
            return Err(error);
        }
        if !state.script.has_headset {
            return Err(xr::Result::ERROR_FORM_FACTOR_UNAVAILABLE);
        }
        unsafe { *system = xr::SystemId::from_raw(SYSTEM) };
        Ok(xr::Result::SUCCESS)
    })())
}

/// Checks that the instance and the system are right, and that the view configuration is stereo.
pub(crate) fn check_system(
    state: &mut State,
    call: &str,
    instance: xr::Instance,
    system: xr::SystemId,
    views: xr::ViewConfigurationType,
) -> Result<(), xr::Result> {
    state.instance(call, instance)?;
    if system.into_raw() != SYSTEM {
        return Err(state.violation(call, "no such system", xr::Result::ERROR_SYSTEM_INVALID));
    }
    if views != VIEWS {
        return Err(xr::Result::ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
    }
    Ok(())
}

pub(crate) unsafe extern "system" fn system_properties(
    instance: xr::Instance,
    system: xr::SystemId,
    out: *mut xr::SystemProperties,
) -> xr::Result {
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        check_system(&mut state, "xrGetSystemProperties", instance, system, VIEWS)?;
        state.check("xrGetSystemProperties", (out.ty, out.next), xr::SystemProperties::TYPE)?;
        out.system_id = system;
        out.vendor_id = 1;
        text("no headset at all", &mut out.system_name);
        out.graphics_properties.max_swapchain_image_width = MAX_PX;
        out.graphics_properties.max_swapchain_image_height = MAX_PX;
        out.graphics_properties.max_layer_count = 16;
        out.tracking_properties.orientation_tracking = xr::TRUE;
        out.tracking_properties.position_tracking = xr::TRUE;
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn view_configurations(
    instance: xr::Instance,
    system: xr::SystemId,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::ViewConfigurationType,
) -> xr::Result {
    let mut state = hold();
    match check_system(&mut state, "xrEnumerateViewConfigurations", instance, system, VIEWS) {
        Ok(()) => array(&[VIEWS], capacity, count, out),
        Err(error) => error,
    }
}

pub(crate) unsafe extern "system" fn view_configuration(
    instance: xr::Instance,
    system: xr::SystemId,
    views: xr::ViewConfigurationType,
    out: *mut xr::ViewConfigurationProperties,
) -> xr::Result {
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        check_system(&mut state, "xrGetViewConfigurationProperties", instance, system, views)?;
        state.check("xrGetViewConfigurationProperties", (out.ty, out.next), xr::ViewConfigurationProperties::TYPE)?;
        out.view_configuration_type = VIEWS;
        out.fov_mutable = xr::FALSE;
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn configuration_views(
    instance: xr::Instance,
    system: xr::SystemId,
    views: xr::ViewConfigurationType,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::ViewConfigurationView,
) -> xr::Result {
    const CALL: &str = "xrEnumerateViewConfigurationViews";
    let mut state = hold();
    status_of((|| {
        check_system(&mut state, CALL, instance, system, views)?;
        unsafe { *count = 2 };
        if capacity == 0 {
            return Ok(xr::Result::SUCCESS);
        }
        if capacity < 2 {
            return Err(xr::Result::ERROR_SIZE_INSUFFICIENT);
        }
        for (i, [width, height]) in state.script.sizes_px.into_iter().enumerate() {
            let view = unsafe { &mut *out.add(i) };
            state.check(CALL, (view.ty, view.next), xr::ViewConfigurationView::TYPE)?;
            view.recommended_image_rect_width = width;
            view.max_image_rect_width = MAX_PX;
            view.recommended_image_rect_height = height;
            view.max_image_rect_height = MAX_PX;
            // More samples than hachure uses, as some runtimes recommend.
            view.recommended_swapchain_sample_count = 4;
            view.max_swapchain_sample_count = 4;
        }
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn blend_modes(
    instance: xr::Instance,
    system: xr::SystemId,
    views: xr::ViewConfigurationType,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::EnvironmentBlendMode,
) -> xr::Result {
    let mut state = hold();
    match check_system(&mut state, "xrEnumerateEnvironmentBlendModes", instance, system, views) {
        Ok(()) => array(&[xr::EnvironmentBlendMode::OPAQUE], capacity, count, out),
        Err(error) => error,
    }
}

pub(crate) unsafe extern "system" fn string_to_path(
    instance: xr::Instance,
    string: *const c_char,
    path: *mut xr::Path,
) -> xr::Result {
    let mut state = hold();
    status_of((|| {
        state.instance("xrStringToPath", instance)?;
        let string = unsafe { CStr::from_ptr(string) }.to_str().unwrap().to_owned();
        let is_clean = |part: &str| {
            !part.is_empty()
                && part.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b"-_.".contains(&b))
        };
        if !string.strip_prefix('/').is_some_and(|rest| rest.split('/').all(is_clean)) {
            let what = format!("{string} is not a path");
            return Err(state.violation("xrStringToPath", &what, xr::Result::ERROR_PATH_FORMAT_INVALID));
        }
        unsafe { *path = state.path(string) };
        Ok(xr::Result::SUCCESS)
    })())
}

impl State {
    /// Returns the handle of a path.
    pub(crate) fn path(&mut self, string: String) -> xr::Path {
        let known = self.paths.iter().position(|path| *path == string);
        let index = known.unwrap_or_else(|| {
            self.paths.push(string);
            self.paths.len() - 1
        });
        xr::Path::from_raw(index as u64 + 1)
    }

    /// Returns the text of a path.
    pub(crate) fn path_text(&self, path: xr::Path) -> Option<&str> {
        self.paths.get(path.into_raw().checked_sub(1)? as usize).map(String::as_str)
    }
}

pub(crate) unsafe extern "system" fn path_to_string(
    instance: xr::Instance,
    path: xr::Path,
    capacity: u32,
    count: *mut u32,
    out: *mut c_char,
) -> xr::Result {
    let mut state = hold();
    status_of((|| {
        state.instance("xrPathToString", instance)?;
        let Some(text) = state.path_text(path) else {
            return Err(state.violation("xrPathToString", "no such path", xr::Result::ERROR_PATH_INVALID));
        };
        let bytes: Vec<c_char> = text.bytes().chain([0]).map(|byte| byte as c_char).collect();
        Ok(array(&bytes, capacity, count, out))
    })())
}

/// hachure leaves the levels to the runtime.
pub(crate) unsafe extern "system" fn set_performance_level(
    _session: xr::Session,
    _domain: xr::PerfSettingsDomainEXT,
    _level: xr::PerfSettingsLevelEXT,
) -> xr::Result {
    xr::Result::SUCCESS
}
