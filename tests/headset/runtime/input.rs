//! The runtime's actions: suggested, attached and queried ones, and the buttons that the script presses.

use std::collections::BTreeMap;
use std::ffi::{CStr, c_char};

use openxr_sys as xr;
use xr::Handle as _;

use super::state::{State, array, hold, status_of, time_of};

#[derive(Default)]
pub(crate) struct Input {
    /// Names of action sets by handle.
    sets: BTreeMap<u64, String>,
    actions: BTreeMap<u64, Action>,
    /// Suggested bindings by profile: action and path.
    suggested: BTreeMap<String, Vec<(u64, String)>>,
    is_attached: bool,
}

struct Action {
    set: u64,
    name: String,
    kind: xr::ActionType,
    /// Value at the last sync.
    value: [f32; 2],
    changed: bool,
    is_active: bool,
}

/// Controllers, and their input paths after `/user/hand/HAND/input/`. A path begins with the hand if only one has it.
const CONTROLLERS: [(&str, &[&str]); 5] = [
    ("khr/simple_controller", &["select/click", "menu/click"]),
    (
        "oculus/touch_controller",
        &[
            "left x/click",
            "left y/click",
            "left menu/click",
            "right a/click",
            "right b/click",
            "squeeze/value",
            "trigger/value",
            "thumbstick",
            "thumbstick/click",
        ],
    ),
    ("valve/index_controller", &["a/click", "b/click", "squeeze/value", "trigger/value", "thumbstick", "trackpad"]),
    (
        "microsoft/motion_controller",
        &[
            "menu/click",
            "squeeze/click",
            "trigger/value",
            "thumbstick",
            "thumbstick/click",
            "trackpad",
            "trackpad/click",
        ],
    ),
    (
        "htc/vive_controller",
        &["menu/click", "squeeze/click", "trigger/click", "trigger/value", "trackpad", "trackpad/click"],
    ),
];

fn is_control(profile: &str, path: &str) -> bool {
    let Some((_, controls)) =
        CONTROLLERS.iter().find(|(name, _)| profile.strip_prefix("/interaction_profiles/") == Some(name))
    else {
        return false;
    };
    controls.iter().any(|control| {
        let (hands, control): (&[&str], _) = match control.split_once(' ') {
            Some(("left", control)) => (&["left"], control),
            Some((_, control)) => (&["right"], control),
            None => (&["left", "right"], control),
        };
        hands.iter().any(|hand| path == format!("/user/hand/{hand}/input/{control}"))
    })
}

fn name_of(name: &[c_char]) -> String {
    unsafe { CStr::from_ptr(name.as_ptr()) }.to_str().unwrap().to_owned()
}

fn is_name(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b"-_.".contains(&b))
}

pub(crate) unsafe extern "system" fn create_action_set(
    instance: xr::Instance,
    info: *const xr::ActionSetCreateInfo,
    out: *mut xr::ActionSet,
) -> xr::Result {
    const CALL: &str = "xrCreateActionSet";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.instance(CALL, instance)?;
        state.check(CALL, (info.ty, info.next), xr::ActionSetCreateInfo::TYPE)?;
        let name = name_of(&info.action_set_name);
        if !is_name(&name) || name_of(&info.localized_action_set_name).is_empty() {
            return Err(state.violation(CALL, "no such name", xr::Result::ERROR_PATH_FORMAT_INVALID));
        }
        if state.input.sets.values().any(|known| *known == name) {
            return Err(state.violation(CALL, "the name is taken", xr::Result::ERROR_NAME_DUPLICATED));
        }
        let handle = state.handle();
        state.input.sets.insert(handle, name);
        unsafe { *out = xr::ActionSet::from_raw(handle) };
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn destroy_action_set(set: xr::ActionSet) -> xr::Result {
    let mut state = hold();
    if state.input.sets.remove(&set.into_raw()).is_none() {
        return state.violation("xrDestroyActionSet", "no such set", xr::Result::ERROR_HANDLE_INVALID);
    }
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn create_action(
    set: xr::ActionSet,
    info: *const xr::ActionCreateInfo,
    out: *mut xr::Action,
) -> xr::Result {
    const CALL: &str = "xrCreateAction";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::ActionCreateInfo::TYPE)?;
        let (set, name) = (set.into_raw(), name_of(&info.action_name));
        if !state.input.sets.contains_key(&set) {
            return Err(state.violation(CALL, "no such set", xr::Result::ERROR_HANDLE_INVALID));
        }
        if state.input.is_attached {
            return Err(state.violation(CALL, "attached", xr::Result::ERROR_ACTIONSETS_ALREADY_ATTACHED));
        }
        if !is_name(&name) || name_of(&info.localized_action_name).is_empty() {
            return Err(state.violation(CALL, "no such name", xr::Result::ERROR_PATH_FORMAT_INVALID));
        }
        if state.input.actions.values().any(|action| action.name == name) {
            return Err(state.violation(CALL, "the name is taken", xr::Result::ERROR_NAME_DUPLICATED));
        }
        let (handle, kind) = (state.handle(), info.action_type);
        let action = Action { set, name, kind, value: [0.0; 2], changed: false, is_active: false };
        state.input.actions.insert(handle, action);
        unsafe { *out = xr::Action::from_raw(handle) };
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn destroy_action(action: xr::Action) -> xr::Result {
    let mut state = hold();
    if state.input.actions.remove(&action.into_raw()).is_none() {
        return state.violation("xrDestroyAction", "no such action", xr::Result::ERROR_HANDLE_INVALID);
    }
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn suggest(
    instance: xr::Instance,
    info: *const xr::InteractionProfileSuggestedBinding,
) -> xr::Result {
    const CALL: &str = "xrSuggestInteractionProfileBindings";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.instance(CALL, instance)?;
        state.check(CALL, (info.ty, info.next), xr::InteractionProfileSuggestedBinding::TYPE)?;
        if state.input.is_attached {
            return Err(state.violation(CALL, "attached", xr::Result::ERROR_ACTIONSETS_ALREADY_ATTACHED));
        }
        let Some(profile) = state.path_text(info.interaction_profile).map(str::to_owned) else {
            return Err(state.violation(CALL, "no such path", xr::Result::ERROR_PATH_INVALID));
        };
        let bindings =
            unsafe { std::slice::from_raw_parts(info.suggested_bindings, info.count_suggested_bindings as usize) };
        let mut suggested = Vec::new();
        for binding in bindings {
            let path = state.path_text(binding.binding).unwrap_or_default().to_owned();
            if !is_control(&profile, &path) {
                let what = format!("{profile} has no {path}");
                return Err(state.violation(CALL, &what, xr::Result::ERROR_PATH_UNSUPPORTED));
            }
            if !state.input.actions.contains_key(&binding.action.into_raw()) {
                return Err(state.violation(CALL, "no such action", xr::Result::ERROR_HANDLE_INVALID));
            }
            suggested.push((binding.action.into_raw(), path));
        }
        state.input.suggested.insert(profile, suggested);
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn attach(
    session: xr::Session,
    info: *const xr::SessionActionSetsAttachInfo,
) -> xr::Result {
    const CALL: &str = "xrAttachSessionActionSets";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.session(CALL, session)?;
        state.check(CALL, (info.ty, info.next), xr::SessionActionSetsAttachInfo::TYPE)?;
        if state.input.is_attached {
            return Err(state.violation(CALL, "twice", xr::Result::ERROR_ACTIONSETS_ALREADY_ATTACHED));
        }
        let sets = unsafe { std::slice::from_raw_parts(info.action_sets, info.count_action_sets as usize) };
        if sets.iter().any(|set| !state.input.sets.contains_key(&set.into_raw())) {
            return Err(state.violation(CALL, "no such set", xr::Result::ERROR_HANDLE_INVALID));
        }
        state.input.is_attached = true;
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn current_profile(
    session: xr::Session,
    _hand: xr::Path,
    out: *mut xr::InteractionProfileState,
) -> xr::Result {
    const CALL: &str = "xrGetCurrentInteractionProfile";
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        state.session(CALL, session)?;
        state.check(CALL, (out.ty, out.next), xr::InteractionProfileState::TYPE)?;
        let profile = state.script.profile.clone();
        out.interaction_profile = state.path(profile);
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn sync(session: xr::Session, info: *const xr::ActionsSyncInfo) -> xr::Result {
    const CALL: &str = "xrSyncActions";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::ActionsSyncInfo::TYPE)?;
        let is_focused = state.session(CALL, session)?.state == xr::SessionState::FOCUSED;
        let sets =
            unsafe { std::slice::from_raw_parts(info.active_action_sets, info.count_active_action_sets as usize) };
        let are_there = sets.iter().all(|set| state.input.sets.contains_key(&set.action_set.into_raw()));
        if !state.input.is_attached || !are_there {
            return Err(state.violation(CALL, "not attached", xr::Result::ERROR_ACTIONSET_NOT_ATTACHED));
        }
        let State { input, script, frames, .. } = &mut *state;
        let bound = input.suggested.get(&script.profile);
        for (handle, action) in &mut input.actions {
            let controls = bound.into_iter().flatten().filter(|(bound, _)| bound == handle);
            let paths: Vec<&str> = controls.map(|(_, path)| path.as_str()).collect();
            let held = script
                .pushes
                .iter()
                .find(|push| (push.frames[0]..push.frames[1]).contains(frames) && paths.contains(&push.path.as_str()));
            action.is_active = is_focused && !paths.is_empty();
            let value = held.filter(|_| action.is_active).map_or([0.0; 2], |push| push.value);
            action.changed = value != action.value;
            action.value = value;
            debug_assert!(input.sets.contains_key(&action.set));
        }
        Ok(if is_focused { xr::Result::SUCCESS } else { xr::Result::SESSION_NOT_FOCUSED })
    })())
}

/// Returns the value of an action at the last sync; the action must be of this type.
fn asked(
    call: &str,
    session: xr::Session,
    info: &xr::ActionStateGetInfo,
    kind: xr::ActionType,
) -> Result<([f32; 2], xr::Bool32, xr::Bool32, xr::Time), xr::Result> {
    let mut state = hold();
    state.session(call, session)?;
    state.check(call, (info.ty, info.next), xr::ActionStateGetInfo::TYPE)?;
    let time = xr::Time::from_nanos(time_of(state.frames));
    if !state.input.is_attached {
        return Err(state.violation(call, "not attached", xr::Result::ERROR_ACTIONSET_NOT_ATTACHED));
    }
    if info.subaction_path != xr::Path::NULL {
        return Err(state.violation(call, "no such subaction", xr::Result::ERROR_PATH_UNSUPPORTED));
    }
    match state.input.actions.get(&info.action.into_raw()) {
        Some(action) if action.kind == kind => Ok((action.value, action.changed.into(), action.is_active.into(), time)),
        Some(_) => Err(state.violation(call, "another type of action", xr::Result::ERROR_ACTION_TYPE_MISMATCH)),
        None => Err(state.violation(call, "no such action", xr::Result::ERROR_HANDLE_INVALID)),
    }
}

pub(crate) unsafe extern "system" fn boolean(
    session: xr::Session,
    info: *const xr::ActionStateGetInfo,
    out: *mut xr::ActionStateBoolean,
) -> xr::Result {
    match asked("xrGetActionStateBoolean", session, unsafe { &*info }, xr::ActionType::BOOLEAN_INPUT) {
        Ok((value, changed, is_active, time)) => {
            let out = unsafe { &mut *out };
            out.current_state = (value[0] > 0.5).into();
            (out.changed_since_last_sync, out.is_active, out.last_change_time) = (changed, is_active, time);
            xr::Result::SUCCESS
        }
        Err(error) => error,
    }
}

pub(crate) unsafe extern "system" fn float(
    session: xr::Session,
    info: *const xr::ActionStateGetInfo,
    out: *mut xr::ActionStateFloat,
) -> xr::Result {
    match asked("xrGetActionStateFloat", session, unsafe { &*info }, xr::ActionType::FLOAT_INPUT) {
        Ok((value, changed, is_active, time)) => {
            let out = unsafe { &mut *out };
            out.current_state = value[0];
            (out.changed_since_last_sync, out.is_active, out.last_change_time) = (changed, is_active, time);
            xr::Result::SUCCESS
        }
        Err(error) => error,
    }
}

pub(crate) unsafe extern "system" fn vector(
    session: xr::Session,
    info: *const xr::ActionStateGetInfo,
    out: *mut xr::ActionStateVector2f,
) -> xr::Result {
    match asked("xrGetActionStateVector2f", session, unsafe { &*info }, xr::ActionType::VECTOR2F_INPUT) {
        Ok(([x, y], changed, is_active, time)) => {
            let out = unsafe { &mut *out };
            out.current_state = xr::Vector2f { x, y };
            (out.changed_since_last_sync, out.is_active, out.last_change_time) = (changed, is_active, time);
            xr::Result::SUCCESS
        }
        Err(error) => error,
    }
}

pub(crate) unsafe extern "system" fn pose(
    session: xr::Session,
    info: *const xr::ActionStateGetInfo,
    out: *mut xr::ActionStatePose,
) -> xr::Result {
    match asked("xrGetActionStatePose", session, unsafe { &*info }, xr::ActionType::POSE_INPUT) {
        Ok((_, _, is_active, _)) => {
            unsafe { (*out).is_active = is_active };
            xr::Result::SUCCESS
        }
        Err(error) => error,
    }
}

pub(crate) unsafe extern "system" fn create_action_space(
    _session: xr::Session,
    _info: *const xr::ActionSpaceCreateInfo,
    _out: *mut xr::Space,
) -> xr::Result {
    xr::Result::ERROR_FEATURE_UNSUPPORTED
}

pub(crate) unsafe extern "system" fn bound_sources(
    _session: xr::Session,
    _info: *const xr::BoundSourcesForActionEnumerateInfo,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::Path,
) -> xr::Result {
    array(&[], capacity, count, out)
}

pub(crate) unsafe extern "system" fn source_name(
    _session: xr::Session,
    _info: *const xr::InputSourceLocalizedNameGetInfo,
    capacity: u32,
    count: *mut u32,
    out: *mut c_char,
) -> xr::Result {
    array(&[0], capacity, count, out)
}

pub(crate) unsafe extern "system" fn apply_haptics(
    _session: xr::Session,
    _info: *const xr::HapticActionInfo,
    _haptics: *const xr::HapticBaseHeader,
) -> xr::Result {
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn stop_haptics(
    _session: xr::Session,
    _info: *const xr::HapticActionInfo,
) -> xr::Result {
    xr::Result::SUCCESS
}
