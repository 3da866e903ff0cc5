//! The log on standard error: warnings, and more with `-v`.

use std::fmt::{Debug, Write as _};
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};

use rustc_hash::FxHashSet;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::fmt::format::debug_fn;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

use crate::file::message::printable;
use crate::file::unpacked::by_archive;

/// Longest line of the log, in characters.
const LONGEST_LINE: usize = 4000;
/// Number of different warnings that are remembered.
const MAX_WARNINGS: usize = 4096;

/// Starts the log; `verbose` is the number of `-v`.
pub fn start(verbose: u8) {
    let level = match verbose {
        0 => "hachure=warn",
        1 => "hachure=info",
        _ => "hachure=debug,wgpu=info",
    };
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| level.into());
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .without_time()
        // Log lines also contain file names and text from servers.
        .fmt_fields(debug_fn(|writer, field, value| match field.name() {
            "message" => write!(writer, "{}", printable(&by_archive(format!("{value:?}")), LONGEST_LINE)),
            name => write!(writer, " {name}={}", printable(&format!("{value:?}"), LONGEST_LINE)),
        }))
        // Otherwise a log that cannot be written is reported with `eprintln!`, which panics on a closed pipe.
        .log_internal_errors(false);
    tracing_subscriber::registry().with(filter).with(Once::default()).with(lines).init();
}

/// Drops warnings that were printed before. One command may open a file several times, to find its place, to bake it
/// and to draw it, and a picture that is drawn in parts, frames and eyes causes the same warning in each of them.
#[derive(Default)]
struct Once(Mutex<FxHashSet<String>>);

impl Once {
    /// Returns whether a warning is new.
    fn is_new(&self, text: String) -> bool {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MAX_WARNINGS {
            known.clear();
        }
        known.insert(text)
    }
}

impl<S: Subscriber> Layer<S> for Once {
    fn event_enabled(&self, event: &Event<'_>, _context: Context<'_, S>) -> bool {
        if *event.metadata().level() != Level::WARN {
            return true;
        }
        let mut text = Text::default();
        event.record(&mut text);
        self.is_new(text.0)
    }
}

/// The fields of an event as text.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        // Writing to a String cannot fail.
        let _ = write!(self.0, "{}={};", field.name(), by_archive(format!("{value:?}")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_new_once() {
        let once = Once::default();
        assert!(once.is_new("a".into()) && once.is_new("b".into()) && !once.is_new("a".into()));
        // Memory is bounded.
        (0..2 * MAX_WARNINGS).for_each(|i| assert!(once.is_new(format!("{i}"))));
        assert!(once.0.lock().unwrap().len() <= MAX_WARNINGS);
    }
}
