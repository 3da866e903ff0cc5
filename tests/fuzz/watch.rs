//! Runs a case on a separate thread and watches it for panics (also those that are caught), time and memory.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use super::kinds::Kind;
use super::seeds::Seed;
use super::{memory, rule};
use hachure::internals::chain;
use hachure::internals::one_line;

/// The limits of a case.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub time: Duration,
    pub memory_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { time: Duration::from_secs(20), memory_bytes: 1_000_000_000 }
    }
}

/// The result of a case.
#[derive(Debug)]
pub(crate) struct Case {
    /// Description of the failure, if any.
    pub what: Option<String>,
    /// The line with which the file was refused.
    pub refusal: Option<String>,
    /// The increase of the peak memory during the case.
    pub peak_bytes: Option<u64>,
}

/// A function that reads a file or refuses it, and may fail in any other way.
type Open = fn(&Path) -> anyhow::Result<()>;
type Answer = Result<Option<String>, ()>;

/// The first panic of a case, with its place.
static PANIC: Mutex<Option<String>> = Mutex::new(None);

fn first_panic() -> Option<String> {
    PANIC.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Records panics instead of printing them, because those that a decoder catches would be missed otherwise. Tests run
/// on threads with names and keep the usual hook.
fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let is_test = std::thread::current().name().is_some_and(|name| name.contains("::") || name.contains("_"));
            if is_test {
                return before(panic);
            }
            let mut first = PANIC.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| panic.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
        }));
    });
}

/// Runs cases on a worker thread within limits.
pub(crate) struct Watch {
    limits: Limits,
    work: Sender<(Open, PathBuf)>,
    answers: Receiver<Answer>,
}

fn worker() -> (Sender<(Open, PathBuf)>, Receiver<Answer>) {
    let (work, todo) = channel::<(Open, PathBuf)>();
    let (answer, answers) = channel();
    // As large as the stack of a program's main thread.
    let thread = std::thread::Builder::new().name("case".into()).stack_size(8 << 20);
    let run = move || {
        for (open, path) in todo {
            let refusal = |error: anyhow::Error| one_line(&chain(error.as_ref()));
            let done = catch_unwind(AssertUnwindSafe(|| open(&path).err().map(refusal)));
            if answer.send(done.map_err(drop)).is_err() {
                break;
            }
        }
    };
    drop(thread.spawn(run).unwrap());
    (work, answers)
}

impl Watch {
    pub(crate) fn new(limits: Limits) -> Self {
        listen();
        let (work, answers) = worker();
        Self { limits, work, answers }
    }

    /// Opens the current files of a seed.
    pub(crate) fn run(&mut self, kind: &Kind, seed: &Seed) -> Case {
        // Memory and panics belong to the whole process, and tests run in parallel.
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let before = memory::reset();
        drop(first_panic());
        self.work.send((kind.open, seed.entry())).unwrap();
        let answer = self.answers.recv_timeout(self.limits.time);
        let peak_bytes = before.and_then(|before| Some(memory::peak_bytes()?.saturating_sub(before)));
        let panic = first_panic();
        let mut case = Case { what: None, refusal: None, peak_bytes };
        match answer {
            Err(RecvTimeoutError::Timeout) => {
                // The thread cannot be ended, so another one takes its place.
                (self.work, self.answers) = worker();
                case.what = Some(format!("a hang: no answer in {:?}", self.limits.time));
            }
            Err(RecvTimeoutError::Disconnected) => case.what = Some("its thread ended".to_owned()),
            Ok(Err(())) => case.what = Some(String::new()),
            Ok(Ok(refusal)) => {
                case.what = refusal.as_ref().and_then(|message| rule::fault(seed, message));
                case.refusal = refusal;
            }
        }
        if let Some(panic) = panic {
            case.what = Some(format!("a panic: {panic}"));
        }
        if let Some(bytes) = peak_bytes.filter(|&bytes| bytes > self.limits.memory_bytes) {
            case.what = Some(format!("{} MB of memory", bytes / 1_000_000));
        }
        case
    }
}
