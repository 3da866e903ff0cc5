//! Warnings of the library, which Python takes after each call.

use std::fmt::{Debug, Write as _};
use std::sync::{Mutex, PoisonError};

use pyo3::pyfunction;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};

/// Largest number of warnings that wait for Python.
const MOST: usize = 256;

static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Collects the warnings of the library.
struct Collector;

/// The message of an event.
#[derive(Default)]
struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            // Writing to a String cannot fail.
            let _ = write!(self.0, "{value:?}");
        }
    }
}

impl<S: Subscriber> Layer<S> for Collector {
    fn on_event(&self, event: &Event<'_>, _context: Context<'_, S>) {
        let metadata = event.metadata();
        if *metadata.level() != Level::WARN || !metadata.target().starts_with("hachure") {
            return;
        }
        let mut message = Message::default();
        event.record(&mut message);
        let mut warnings = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
        if warnings.len() < MOST && !warnings.contains(&message.0) {
            warnings.push(message.0);
        }
    }
}

/// Starts collecting. A second extension in the same process would leave the first one's log in place.
pub(crate) fn start() {
    let filter = tracing_subscriber::filter::LevelFilter::WARN;
    let _ = tracing::subscriber::set_global_default(tracing_subscriber::registry().with(filter).with(Collector));
}

/// Returns the warnings since the last call.
#[pyfunction]
pub(crate) fn take_warnings() -> Vec<String> {
    std::mem::take(&mut *WARNINGS.lock().unwrap_or_else(PoisonError::into_inner))
}
