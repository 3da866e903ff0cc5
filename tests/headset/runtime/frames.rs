//! The session of the runtime: its states, its frames, the poses of the head, and the submitted layers.

use openxr_sys as xr;
use xr::Handle as _;

use super::head::views_at;
use super::layers::check_layers;
use super::state::{Event, Frame, SESSION, SYSTEM, Session, State, array, hold, status_of, time_of};

const VIEWS: xr::ViewConfigurationType = xr::ViewConfigurationType::PRIMARY_STEREO;

pub(crate) unsafe extern "system" fn create_session(
    instance: xr::Instance,
    info: *const xr::SessionCreateInfo,
    out: *mut xr::Session,
) -> xr::Result {
    const CALL: &str = "xrCreateSession";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.instance(CALL, instance)?;
        state.check(CALL, (info.ty, std::ptr::null()), xr::SessionCreateInfo::TYPE)?;
        if info.system_id.into_raw() != SYSTEM || state.session.is_some() {
            return Err(state.violation(CALL, "no such system, or twice", xr::Result::ERROR_SYSTEM_INVALID));
        }
        let missing = xr::Result::ERROR_GRAPHICS_DEVICE_INVALID;
        let Some(binding) = (unsafe { info.next.cast::<xr::GraphicsBindingVulkanKHR>().as_ref() }) else {
            return Err(state.violation(CALL, "no binding", missing));
        };
        state.check(CALL, (binding.ty, binding.next), xr::GraphicsBindingVulkanKHR::TYPE)?;
        if state.vulkan.as_mut().and_then(|vulkan| vulkan.bind(binding)).is_none() {
            return Err(state.violation(CALL, "not the device that the runtime made", missing));
        }
        state.session = Some(Session {
            state: xr::SessionState::UNKNOWN,
            is_running: false,
            exits: false,
            spaces: Default::default(),
            chains: Default::default(),
            waited: None,
            begun: None,
            next_frame: 0,
            located: None,
            shown: None,
        });
        state.events.extend([xr::SessionState::IDLE, xr::SessionState::READY].map(Event::Session));
        unsafe { *out = xr::Session::from_raw(SESSION) };
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn destroy_session(session: xr::Session) -> xr::Result {
    let mut state = hold();
    let Some(taken) = state.session.take().filter(|_| session.into_raw() == SESSION) else {
        return state.violation("xrDestroySession", "no such session", xr::Result::ERROR_HANDLE_INVALID);
    };
    if !taken.chains.is_empty() || !taken.spaces.is_empty() {
        state.violation("xrDestroySession", "swapchains or spaces are still there", xr::Result::SUCCESS);
    }
    if let Some(vulkan) = &mut state.vulkan {
        vulkan.unbind();
    }
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn poll_event(instance: xr::Instance, out: *mut xr::EventDataBuffer) -> xr::Result {
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        state.instance("xrPollEvent", instance)?;
        state.check("xrPollEvent", (out.ty, out.next), xr::EventDataBuffer::TYPE)?;
        let Some(event) = state.events.pop_front() else { return Ok(xr::Result::EVENT_UNAVAILABLE) };
        let (next, time) = (std::ptr::null(), xr::Time::from_nanos(time_of(state.frames)));
        match event {
            Event::Session(now) => {
                let Some(session) = &mut state.session else { return Ok(xr::Result::EVENT_UNAVAILABLE) };
                session.state = now;
                let ty = xr::EventDataSessionStateChanged::TYPE;
                let session = xr::Session::from_raw(SESSION);
                let event = xr::EventDataSessionStateChanged { ty, next, session, state: now, time };
                unsafe { (&raw mut *out).cast::<xr::EventDataSessionStateChanged>().write(event) };
            }
            Event::Mask(view_index) => {
                let event = xr::EventDataVisibilityMaskChangedKHR {
                    ty: xr::EventDataVisibilityMaskChangedKHR::TYPE,
                    next,
                    session: xr::Session::from_raw(SESSION),
                    view_configuration_type: VIEWS,
                    view_index,
                };
                unsafe { (&raw mut *out).cast::<xr::EventDataVisibilityMaskChangedKHR>().write(event) };
            }
            Event::Slow(is_slow) => {
                use xr::PerfSettingsNotificationLevelEXT as Level;
                let levels = [Level::NORMAL, Level::IMPAIRED];
                let event = xr::EventDataPerfSettingsEXT {
                    ty: xr::EventDataPerfSettingsEXT::TYPE,
                    next,
                    domain: xr::PerfSettingsDomainEXT::GPU,
                    sub_domain: xr::PerfSettingsSubDomainEXT::RENDERING,
                    from_level: levels[usize::from(!is_slow)],
                    to_level: levels[usize::from(is_slow)],
                };
                unsafe { (&raw mut *out).cast::<xr::EventDataPerfSettingsEXT>().write(event) };
            }
            Event::InstanceLoss => {
                let ty = xr::EventDataInstanceLossPending::TYPE;
                let event = xr::EventDataInstanceLossPending { ty, next, loss_time: time };
                unsafe { (&raw mut *out).cast::<xr::EventDataInstanceLossPending>().write(event) };
            }
        }
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn begin_session(
    session: xr::Session,
    info: *const xr::SessionBeginInfo,
) -> xr::Result {
    const CALL: &str = "xrBeginSession";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::SessionBeginInfo::TYPE)?;
        let session = state.session(CALL, session)?;
        if session.is_running {
            return Err(state.violation(CALL, "it runs already", xr::Result::ERROR_SESSION_RUNNING));
        }
        if session.state != xr::SessionState::READY {
            return Err(state.violation(CALL, "it is not ready", xr::Result::ERROR_SESSION_NOT_READY));
        }
        if info.primary_view_configuration_type != VIEWS {
            return Err(xr::Result::ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
        }
        session.is_running = true;
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn end_session(session: xr::Session) -> xr::Result {
    const CALL: &str = "xrEndSession";
    let mut state = hold();
    status_of((|| {
        let session = state.session(CALL, session)?;
        if !session.is_running {
            return Err(state.violation(CALL, "it does not run", xr::Result::ERROR_SESSION_NOT_RUNNING));
        }
        if session.state != xr::SessionState::STOPPING {
            return Err(state.violation(CALL, "it is not stopping", xr::Result::ERROR_SESSION_NOT_STOPPING));
        }
        session.is_running = false;
        (session.waited, session.begun, session.located) = (None, None, None);
        let next = if session.exits { xr::SessionState::EXITING } else { xr::SessionState::READY };
        state.events.extend([xr::SessionState::IDLE, next].map(Event::Session));
        Ok(xr::Result::SUCCESS)
    })())
}

/// Queues the states from the current one to the end of the session.
fn go_down(state: &mut State) {
    let last = state.events.iter().rev().find_map(|event| match event {
        Event::Session(state) => Some(*state),
        Event::InstanceLoss | Event::Mask(_) | Event::Slow(_) => None,
    });
    let from = last.or(state.session.as_ref().map(|session| session.state)).unwrap_or(xr::SessionState::IDLE);
    let way = [
        xr::SessionState::FOCUSED,
        xr::SessionState::VISIBLE,
        xr::SessionState::SYNCHRONIZED,
        xr::SessionState::STOPPING,
    ];
    let begin = way.iter().position(|state| *state == from).map_or(3, |place| place + 1);
    state.events.extend(way[begin.min(3)..].iter().map(|state| Event::Session(*state)));
}

pub(crate) unsafe extern "system" fn request_exit(session: xr::Session) -> xr::Result {
    const CALL: &str = "xrRequestExitSession";
    let mut state = hold();
    status_of((|| {
        let session = state.session(CALL, session)?;
        if !session.is_running {
            return Err(state.violation(CALL, "it does not run", xr::Result::ERROR_SESSION_NOT_RUNNING));
        }
        session.exits = true;
        go_down(&mut state);
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn reference_spaces(
    session: xr::Session,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::ReferenceSpaceType,
) -> xr::Result {
    let mut state = hold();
    status_of((|| {
        state.session("xrEnumerateReferenceSpaces", session)?;
        let all = [xr::ReferenceSpaceType::VIEW, xr::ReferenceSpaceType::LOCAL, xr::ReferenceSpaceType::STAGE];
        let offered = if state.script.has_stage { &all[..] } else { &all[..2] };
        Ok(array(offered, capacity, count, out))
    })())
}

pub(crate) unsafe extern "system" fn create_reference_space(
    session: xr::Session,
    info: *const xr::ReferenceSpaceCreateInfo,
    out: *mut xr::Space,
) -> xr::Result {
    const CALL: &str = "xrCreateReferenceSpace";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::ReferenceSpaceCreateInfo::TYPE)?;
        let (kind, handle) = (info.reference_space_type, state.handle());
        if kind == xr::ReferenceSpaceType::STAGE && !state.script.has_stage {
            let error = xr::Result::ERROR_REFERENCE_SPACE_UNSUPPORTED;
            return Err(state.violation(CALL, "a space that was not offered", error));
        }
        if info.pose_in_reference_space != xr::Posef::IDENTITY {
            return Err(xr::Result::ERROR_FEATURE_UNSUPPORTED);
        }
        state.session(CALL, session)?.spaces.insert(handle, kind);
        unsafe { *out = xr::Space::from_raw(handle) };
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn destroy_space(space: xr::Space) -> xr::Result {
    let mut state = hold();
    let removed = state.session.as_mut().and_then(|session| session.spaces.remove(&space.into_raw()));
    if removed.is_none() {
        return state.violation("xrDestroySpace", "no such space", xr::Result::ERROR_HANDLE_INVALID);
    }
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn locate_space(
    _space: xr::Space,
    _base: xr::Space,
    _time: xr::Time,
    out: *mut xr::SpaceLocation,
) -> xr::Result {
    unsafe { (*out).location_flags = xr::SpaceLocationFlags::EMPTY };
    xr::Result::SUCCESS
}

pub(crate) unsafe extern "system" fn bounds_rect(
    _session: xr::Session,
    _kind: xr::ReferenceSpaceType,
    _out: *mut xr::Extent2Df,
) -> xr::Result {
    xr::Result::SPACE_BOUNDS_UNAVAILABLE
}

pub(crate) unsafe extern "system" fn wait_frame(
    session: xr::Session,
    info: *const xr::FrameWaitInfo,
    out: *mut xr::FrameState,
) -> xr::Result {
    const CALL: &str = "xrWaitFrame";
    let (mut state, out) = (hold(), unsafe { &mut *out });
    status_of((|| {
        if let Some(info) = unsafe { info.as_ref() } {
            state.check(CALL, (info.ty, info.next), xr::FrameWaitInfo::TYPE)?;
        }
        state.check(CALL, (out.ty, out.next), xr::FrameState::TYPE)?;
        let session = state.session(CALL, session)?;
        if !session.is_running {
            return Err(state.violation(CALL, "it does not run", xr::Result::ERROR_SESSION_NOT_RUNNING));
        }
        if session.waited.is_some() {
            // A real runtime would wait forever.
            let error = xr::Result::ERROR_CALL_ORDER_INVALID;
            return Err(state.violation(CALL, "the frame before was not begun", error));
        }
        // Waits like a display, so that a program that draws nothing yet does not loop a thousand times.
        std::thread::sleep(std::time::Duration::from_millis(1));
        let should_render = [xr::SessionState::VISIBLE, xr::SessionState::FOCUSED].contains(&session.state);
        let frame = Frame { number: session.next_frame, should_render };
        session.next_frame += 1;
        session.waited = Some(frame);
        out.predicted_display_time = xr::Time::from_nanos(time_of(frame.number));
        out.predicted_display_period = xr::Duration::from_nanos(11_111_111);
        out.should_render = should_render.into();
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn begin_frame(session: xr::Session, info: *const xr::FrameBeginInfo) -> xr::Result {
    const CALL: &str = "xrBeginFrame";
    let mut state = hold();
    status_of((|| {
        if let Some(info) = unsafe { info.as_ref() } {
            state.check(CALL, (info.ty, info.next), xr::FrameBeginInfo::TYPE)?;
        }
        let session = state.session(CALL, session)?;
        if !session.is_running {
            return Err(state.violation(CALL, "it does not run", xr::Result::ERROR_SESSION_NOT_RUNNING));
        }
        let Some(frame) = session.waited.take() else {
            return Err(state.violation(CALL, "no frame was waited for", xr::Result::ERROR_CALL_ORDER_INVALID));
        };
        if session.begun.replace(frame).is_some() {
            return Ok(state.violation(CALL, "the frame before was not ended", xr::Result::FRAME_DISCARDED));
        }
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn locate_views(
    session: xr::Session,
    info: *const xr::ViewLocateInfo,
    view_state: *mut xr::ViewState,
    capacity: u32,
    count: *mut u32,
    out: *mut xr::View,
) -> xr::Result {
    const CALL: &str = "xrLocateViews";
    let (mut state, info, view_state) = (hold(), unsafe { &*info }, unsafe { &mut *view_state });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::ViewLocateInfo::TYPE)?;
        state.check(CALL, (view_state.ty, view_state.next), xr::ViewState::TYPE)?;
        let has_space = state.session(CALL, session)?.spaces.contains_key(&info.space.into_raw());
        if !has_space {
            return Err(state.violation(CALL, "no such space", xr::Result::ERROR_HANDLE_INVALID));
        }
        if info.view_configuration_type != VIEWS || info.display_time.as_nanos() <= 0 {
            return Err(state.violation(CALL, "no such views, or no such time", xr::Result::ERROR_TIME_INVALID));
        }
        unsafe { *count = 2 };
        let frame = ((info.display_time.as_nanos() - time_of(0)) / 11_111_111).max(0) as u64;
        let is_known = !state.script.untracked.is_some_and(|[from, to]| (from..to).contains(&state.frames));
        let all = xr::ViewStateFlags::ORIENTATION_VALID
            | xr::ViewStateFlags::POSITION_VALID
            | xr::ViewStateFlags::ORIENTATION_TRACKED
            | xr::ViewStateFlags::POSITION_TRACKED;
        view_state.view_state_flags = if is_known { all } else { xr::ViewStateFlags::EMPTY };
        if capacity == 0 {
            return Ok(xr::Result::SUCCESS);
        }
        if capacity < 2 {
            return Err(xr::Result::ERROR_SIZE_INSUFFICIENT);
        }
        let kind = state.session(CALL, session)?.spaces[&info.space.into_raw()];
        let views = views_at(&state, frame, kind);
        for (i, view) in views.iter().enumerate() {
            let out = unsafe { &mut *out.add(i) };
            state.check(CALL, (out.ty, out.next), xr::View::TYPE)?;
            // Unknown poses are NaN.
            let nothing = xr::Posef {
                orientation: xr::Quaternionf { x: f32::NAN, y: f32::NAN, z: f32::NAN, w: f32::NAN },
                position: xr::Vector3f { x: f32::NAN, y: f32::NAN, z: f32::NAN },
            };
            (out.pose, out.fov) = (if is_known { view.pose } else { nothing }, view.fov);
        }
        let located = is_known.then_some((info.display_time.as_nanos(), info.space.into_raw(), views));
        state.session(CALL, session)?.located = located;
        Ok(xr::Result::SUCCESS)
    })())
}

pub(crate) unsafe extern "system" fn end_frame(session: xr::Session, info: *const xr::FrameEndInfo) -> xr::Result {
    const CALL: &str = "xrEndFrame";
    let (mut state, info) = (hold(), unsafe { &*info });
    status_of((|| {
        state.check(CALL, (info.ty, info.next), xr::FrameEndInfo::TYPE)?;
        let session = state.session(CALL, session)?;
        if !session.is_running {
            return Err(state.violation(CALL, "it does not run", xr::Result::ERROR_SESSION_NOT_RUNNING));
        }
        let Some(frame) = session.begun.take() else {
            return Err(state.violation(CALL, "no frame was begun", xr::Result::ERROR_CALL_ORDER_INVALID));
        };
        let is_held = session.chains.values().any(super::swapchains::Chain::is_held);
        let checked = check_layers(&mut state, frame, is_held, info);
        // The script counts frames from the first one that shows the world, however long that takes.
        let types = (0..info.layer_count as usize).map(|i| unsafe { (**info.layers.add(i)).ty });
        let shows_world = types.into_iter().any(|ty| ty == xr::CompositionLayerProjection::TYPE);
        if state.frames > 0 || shows_world {
            state.frames += 1;
        }
        events_of(&mut state);
        checked.map(|()| xr::Result::SUCCESS)
    })())
}

/// Queues the events after a frame.
fn events_of(state: &mut State) {
    let ended = state.frames.wrapping_sub(1);
    let to = |state: &mut State, states: &[xr::SessionState]| {
        state.events.extend(states.iter().map(|state| Event::Session(*state)));
    };
    use xr::SessionState as S;
    let now = state.session.as_ref().map_or(S::IDLE, |session| session.state);
    let at = |frame: Option<u64>| frame == Some(ended);
    if now == S::READY && state.events.is_empty() {
        to(state, &[S::SYNCHRONIZED, S::VISIBLE, S::FOCUSED]);
    }
    if at(state.script.off.map(|[from, _]| from)) {
        to(state, &[S::VISIBLE, S::SYNCHRONIZED]);
    }
    if at(state.script.off.map(|[_, to]| to)) {
        to(state, &[S::VISIBLE, S::FOCUSED]);
    }
    if at(state.script.stop) || at(state.script.pause) {
        let exits = at(state.script.stop);
        if let Some(session) = &mut state.session {
            session.exits |= exits;
        }
        go_down(state);
    }
    if at(state.script.lose_session) {
        to(state, &[S::LOSS_PENDING]);
    }
    if at(state.script.change_mask) {
        state.events.extend([Event::Mask(0), Event::Mask(1)]);
    }
    for (frame, is_slow) in state.script.hot.map_or([None; 2], |hot| hot.map(Some)).into_iter().zip([true, false]) {
        if at(frame) {
            state.events.push_back(Event::Slow(is_slow));
        }
    }
    if at(state.script.lose_instance) {
        state.events.push_back(Event::InstanceLoss);
    }
}
