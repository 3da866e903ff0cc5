//! The state of the runtime, behind one lock, and its log.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write as _;
use std::sync::{Mutex, MutexGuard};

use openxr_sys as xr;

use super::input::Input;
use super::script::Script;
use super::swapchains::Chain;
use super::vulkan::Vulkan;

/// Handles of the only instance, system and session.
pub(crate) const INSTANCE: u64 = 0x101;
pub(crate) const SYSTEM: u64 = 0x201;
pub(crate) const SESSION: u64 = 0x301;

pub(crate) struct State {
    pub script: Script,
    pub has_instance: bool,
    /// Whether the program enabled `XR_KHR_visibility_mask`.
    pub enabled_masks: bool,
    pub asked_requirements: bool,
    pub vulkan: Option<Vulkan>,
    pub session: Option<Session>,
    pub paths: Vec<String>,
    pub input: Input,
    pub next_handle: u64,
    /// Events that `xrPollEvent` has not returned yet.
    pub events: VecDeque<Event>,
    /// Number of frames that have ended.
    pub frames: u64,
    pub violations: u64,
    /// Number of frames that showed nothing, though the session was seen and the head was tracked.
    pub empty_frames: u64,
}

// SAFETY: the only pointers in it end chains of structs, so they are null.
unsafe impl Send for State {}

#[derive(Clone, Copy)]
pub(crate) enum Event {
    Session(xr::SessionState),
    InstanceLoss,
    /// The visibility mask of an eye changed.
    Mask(u32),
    /// The GPU has become too slow, or is fast enough again.
    Slow(bool),
}

pub(crate) struct Session {
    /// The last state that the program was notified of.
    pub state: xr::SessionState,
    pub is_running: bool,
    /// The user or the program requested the end.
    pub exits: bool,
    pub spaces: BTreeMap<u64, xr::ReferenceSpaceType>,
    pub chains: BTreeMap<u64, Chain>,
    /// The frame that was waited for and not begun.
    pub waited: Option<Frame>,
    /// The frame that was begun and not ended.
    pub begun: Option<Frame>,
    /// Number of the next frame that `xrWaitFrame` announces.
    pub next_frame: u64,
    /// The views that were located last: display time, space, and views.
    pub located: Option<(i64, u64, [xr::View; 2])>,
    /// The views that were shown last.
    pub shown: Option<[xr::View; 2]>,
}

#[derive(Clone, Copy)]
pub(crate) struct Frame {
    pub number: u64,
    pub should_render: bool,
}

/// Returns the display time of a frame, in nanoseconds.
pub(crate) fn time_of(frame: u64) -> i64 {
    1_000_000_000 + 11_111_111 * frame as i64
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

/// A lock on the state, which is created on first use.
pub(crate) struct Held(MutexGuard<'static, Option<State>>);

impl std::ops::Deref for Held {
    type Target = State;
    fn deref(&self) -> &State {
        self.0.as_ref().unwrap()
    }
}

impl std::ops::DerefMut for Held {
    fn deref_mut(&mut self) -> &mut State {
        self.0.as_mut().unwrap()
    }
}

pub(crate) fn hold() -> Held {
    let mut state = STATE.lock().unwrap();
    state.get_or_insert_with(State::new);
    Held(state)
}

impl State {
    fn new() -> Self {
        Self {
            script: Script::read(),
            has_instance: false,
            enabled_masks: false,
            asked_requirements: false,
            vulkan: None,
            session: None,
            paths: Vec::new(),
            input: Input::default(),
            next_handle: 0x1000,
            events: VecDeque::new(),
            frames: 0,
            violations: 0,
            empty_frames: 0,
        }
    }

    pub(crate) fn handle(&mut self) -> u64 {
        self.next_handle += 1;
        self.next_handle
    }

    pub(crate) fn log(&self, line: &str) {
        let Some(path) = &self.script.log else { return };
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        writeln!(file.unwrap(), "{line}").unwrap();
    }

    /// Logs a violation of the specification, and returns the error that the specification prescribes.
    pub(crate) fn violation(&mut self, call: &str, what: &str, error: xr::Result) -> xr::Result {
        self.violations += 1;
        self.log(&format!("violation: {call}: {what} ({error:?})"));
        error
    }

    /// Checks that a struct has its type, and that no unknown struct follows it in the chain.
    pub(crate) fn check(
        &mut self,
        call: &str,
        found: (xr::StructureType, *const std::ffi::c_void),
        expected: xr::StructureType,
    ) -> Result<(), xr::Result> {
        if found.0 != expected {
            let what = format!("a struct is of the type {:?}, not {expected:?}", found.0);
            return Err(self.violation(call, &what, xr::Result::ERROR_VALIDATION_FAILURE));
        }
        if !found.1.is_null() {
            return Err(self.violation(
                call,
                "an unknown struct follows in the chain",
                xr::Result::ERROR_VALIDATION_FAILURE,
            ));
        }
        Ok(())
    }

    /// Checks that the instance exists and its handle is right.
    pub(crate) fn instance(&mut self, call: &str, instance: xr::Instance) -> Result<(), xr::Result> {
        use xr::Handle as _;
        if !self.has_instance || instance.into_raw() != INSTANCE {
            return Err(self.violation(call, "no such instance", xr::Result::ERROR_HANDLE_INVALID));
        }
        match self.script.break_instance {
            Some(frame) if self.frames > frame => Err(xr::Result::ERROR_INSTANCE_LOST),
            _ => Ok(()),
        }
    }

    /// Returns the session, if the handle is right.
    pub(crate) fn session(&mut self, call: &str, session: xr::Session) -> Result<&mut Session, xr::Result> {
        use xr::Handle as _;
        if self.session.is_none() || session.into_raw() != SESSION {
            return Err(self.violation(call, "no such session", xr::Result::ERROR_HANDLE_INVALID));
        }
        if self.script.break_instance.is_some_and(|frame| self.frames > frame) {
            return Err(xr::Result::ERROR_INSTANCE_LOST);
        }
        if self.script.break_session.is_some_and(|frame| self.frames > frame) {
            return Err(xr::Result::ERROR_SESSION_LOST);
        }
        self.session.as_mut().ok_or(xr::Result::ERROR_HANDLE_INVALID)
    }
}

/// Implements the two calls that return an array: the first returns its length, the second its elements.
pub(crate) fn array<T: Copy>(values: &[T], capacity: u32, count: *mut u32, out: *mut T) -> xr::Result {
    unsafe { *count = values.len() as u32 };
    if capacity == 0 {
        return xr::Result::SUCCESS;
    }
    if (capacity as usize) < values.len() {
        return xr::Result::ERROR_SIZE_INSUFFICIENT;
    }
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), out, values.len()) };
    xr::Result::SUCCESS
}

/// Writes a text into a field of fixed length.
pub(crate) fn text(value: &str, out: &mut [std::ffi::c_char]) {
    out.fill(0);
    for (to, from) in out.iter_mut().zip(value.bytes()) {
        *to = from as std::ffi::c_char;
    }
}

/// Returns the error or the success of a function that may return early.
pub(crate) fn status_of(result: Result<xr::Result, xr::Result>) -> xr::Result {
    result.unwrap_or_else(|error| error)
}
