//! Progress of long work: a bar on a terminal, otherwise lines of text.
//!
//! A program that runs hachure, such as the export dialog of a window, may read it ([`progress_lines`]).

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::file::{progress_lines, standard};
use crate::source::Progress;

/// Time between two lines of progress where standard error is not a terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// Time between two lines for a program.
const BETWEEN_REPORTS: Duration = Duration::from_millis(100);

/// A progress bar on standard error. Where that is not a terminal, it prints a line from time to time for work measured
/// in samples, and nothing for other work.
pub(crate) struct Bar {
    bar: ProgressBar,
    samples: Option<u64>,
    /// Whether a program reads the progress.
    is_read: bool,
    state: Mutex<State>,
}

struct State {
    what: String,
    /// Time and progress (0 to 1) at which the current step of the work began.
    start: (Instant, f32),
    last_line: Instant,
}

impl Default for Bar {
    fn default() -> Self {
        Self::new(None)
    }
}

impl Bar {
    /// Creates a bar that shows how many of `samples` are processed per second.
    pub(crate) fn of_samples(samples: u64) -> Self {
        Self::new(Some(samples))
    }

    fn new(samples: Option<u64>) -> Self {
        let bar = ProgressBar::new(1000);
        let style = ProgressStyle::with_template("{msg:28} {wide_bar} {percent:>3} % {prefix}{eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        let now = Instant::now();
        let is_read = progress_lines::are_read();
        Self {
            bar,
            samples,
            is_read,
            state: Mutex::new(State { what: String::new(), start: (now, 0.0), last_line: now }),
        }
    }
}

impl Progress for Bar {
    fn report(&self, what: &str, done: f32) {
        // A poisoned lock only means that another report panicked; the text is still valid.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let is_new = state.what != what;
        if self.is_read && (is_new || now - state.last_line > BETWEEN_REPORTS) {
            state.last_line = now;
            standard::print_to_stderr(&progress_lines::line(what, done));
        }
        if is_new {
            what.clone_into(&mut state.what);
            state.start = (now, done);
            self.bar.reset();
            self.bar.set_message(what.to_owned());
            self.bar.set_prefix("");
        }
        self.bar.set_position((done.clamp(0.0, 1.0) * 1000.0) as u64);
        let Some(samples) = self.samples else { return };
        let seconds = (now - state.start.0).as_secs_f64();
        let share = f64::from(done - state.start.1);
        if share <= 0.0 || seconds < 1.0 {
            return;
        }
        let millions = share * samples as f64 / seconds / 1e6;
        self.bar.set_prefix(format!("{millions:.1} M samples/s, "));
        if !self.is_read && now - state.last_line > BETWEEN_LINES && !std::io::stderr().is_terminal() {
            state.last_line = now;
            let left = Duration::from_secs_f64((seconds / share * f64::from(1.0 - done)).clamp(0.0, 1e9));
            let left = indicatif::HumanDuration(left);
            let percent = 100.0 * done;
            standard::print_to_stderr(&format!("{what}: {percent:.1} %, {millions:.1} M samples/s, {left} left"));
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
