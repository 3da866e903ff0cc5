//! All that the runtime knows, behind one lock; and its log.

use std::collections::{BTreeMap, VecDeque};
use std::io::Write as _;
use std::sync::{Mutex, MutexGuard};

use openxr_sys as xr;

use super::input::Input;
use super::script::Script;
use super::swapchains::Chain;
use super::vulkan::Vulkan;

/// The only instance, system and session have these numbers.
pub const INSTANCE: u64 = 0x101;
pub const SYSTEM: u64 = 0x201;
pub const SESSION: u64 = 0x301;

pub struct State {
    pub script: Script,
    pub has_instance: bool,
    /// `XR_KHR_visibility_mask`.
    pub enabled_masks: bool,
    pub asked_requirements: bool,
    pub vulkan: Option<Vulkan>,
    pub session: Option<Session>,
    pub paths: Vec<String>,
    pub input: Input,
    pub next_handle: u64,
    /// What `xrPollEvent` will tell.
    pub events: VecDeque<Event>,
    /// Frames that ended.
    pub frames: u64,
    pub violations: u64,
}

// SAFETY: the pointers in it are those that end a chain of structs: null.
unsafe impl Send for State {}

#[derive(Clone, Copy)]
pub enum Event {
    Session(xr::SessionState),
    InstanceLoss,
    /// Of an eye.
    Mask(u32),
}

pub struct Session {
    /// As the program was told.
    pub state: xr::SessionState,
    pub is_running: bool,
    /// The user or the program wants the end.
    pub exits: bool,
    pub spaces: BTreeMap<u64, xr::ReferenceSpaceType>,
    pub chains: BTreeMap<u64, Chain>,
    /// A frame that was waited for and not begun.
    pub waited: Option<Renderer>,
    /// A frame that was begun and not ended.
    pub begun: Option<Renderer>,
    /// Counted by `xrWaitFrame`.
    pub next_frame: u64,
    /// What was told of the views last: when, from where.
    pub located: Option<(i64, u64, [xr::View; 2])>,
    /// What was shown last.
    pub shown: Option<[xr::View; 2]>,
}

#[derive(Clone, Copy)]
pub struct Renderer {
    pub number: u64,
    pub should_render: bool,
}

/// The display time of a frame, in nanoseconds.
pub fn time_of(renderer: u64) -> i64 {
    1_000_000_000 + 11_111_111 * renderer as i64
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

/// The state; made when it is asked for first.
pub struct Held(MutexGuard<'static, Option<State>>);

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

pub fn hold() -> Held {
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
        }
    }

    pub fn handle(&mut self) -> u64 {
        self.next_handle += 1;
        self.next_handle
    }

    pub fn log(&self, line: &str) {
        let Some(path) = &self.script.log else { return };
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        writeln!(file.unwrap(), "{line}").unwrap();
    }

    /// Notes what the specification does not allow, and returns the error that it gives for it.
    pub fn violation(&mut self, call: &str, what: &str, error: xr::Result) -> xr::Result {
        self.violations += 1;
        self.log(&format!("violation: {call}: {what} ({error:?})"));
        error
    }

    /// A struct must have its type, and nothing that is not known follows it.
    pub fn check(
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
                "something unknown follows a struct",
                xr::Result::ERROR_VALIDATION_FAILURE,
            ));
        }
        Ok(())
    }

    /// Whether the instance is there and its handle is right.
    pub fn instance(&mut self, call: &str, instance: xr::Instance) -> Result<(), xr::Result> {
        use xr::Handle as _;
        if !self.has_instance || instance.into_raw() != INSTANCE {
            return Err(self.violation(call, "no such instance", xr::Result::ERROR_HANDLE_INVALID));
        }
        match self.script.break_instance {
            Some(renderer) if self.frames > renderer => Err(xr::Result::ERROR_INSTANCE_LOST),
            _ => Ok(()),
        }
    }

    /// The session, if the handle is right.
    pub fn session(&mut self, call: &str, session: xr::Session) -> Result<&mut Session, xr::Result> {
        use xr::Handle as _;
        if self.session.is_none() || session.into_raw() != SESSION {
            return Err(self.violation(call, "no such session", xr::Result::ERROR_HANDLE_INVALID));
        }
        if self.script.break_instance.is_some_and(|renderer| self.frames > renderer) {
            return Err(xr::Result::ERROR_INSTANCE_LOST);
        }
        if self.script.break_session.is_some_and(|renderer| self.frames > renderer) {
            return Err(xr::Result::ERROR_SESSION_LOST);
        }
        self.session.as_mut().ok_or(xr::Result::ERROR_HANDLE_INVALID)
    }
}

/// The two calls of an array: how many there are, and then all of them.
pub fn array<T: Copy>(values: &[T], capacity: u32, count: *mut u32, out: *mut T) -> xr::Result {
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

/// A text into a field.
pub fn text(value: &str, out: &mut [std::ffi::c_char]) {
    out.fill(0);
    for (to, from) in out.iter_mut().zip(value.bytes()) {
        *to = from as std::ffi::c_char;
    }
}

/// The error or the success of a function that may leave early.
pub fn told(result: Result<xr::Result, xr::Result>) -> xr::Result {
    result.unwrap_or_else(|error| error)
}
