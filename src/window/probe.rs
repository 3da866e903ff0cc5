//! Aids for tests that drive the window from outside, with real mouse and key events: where its widgets are, and frames
//! that take long.
//!
//! - `HACHURE_WIDGETS=FILE` writes a file after each frame of the window. Its first line is [`HEADER`]; then each widget
//!   has a line with tabs between left, top, right and bottom in pixels of the window, role, name, value, and `disabled`
//!   if a click on it has no effect.
//! - `HACHURE_FRAME_MS=MS` makes each frame of the window last at least this long.
//!
//! Why: `docs/decisions/tests.md`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::accesskit::TreeUpdate;

use crate::file::{atomic, unnamed};

/// The first line of the file.
const HEADER: &str = "# hachure widgets\n";

/// The requests of the environment variables.
#[derive(Debug, Default)]
pub(super) struct Probe {
    file: Option<PathBuf>,
    frame: Duration,
    begun: Option<Instant>,
}

impl Probe {
    /// Reads the environment.
    pub(super) fn of_environment() -> Self {
        let file = std::env::var_os("HACHURE_WIDGETS").filter(|path| !path.is_empty()).map(PathBuf::from);
        let frame_ms = std::env::var("HACHURE_FRAME_MS").ok().and_then(|text| text.parse().ok());
        Self { file, frame: Duration::from_millis(frame_ms.unwrap_or(0)), begun: None }
    }

    /// Returns whether the names of widgets are needed.
    pub(super) fn wants_names(&self) -> bool {
        self.file.is_some()
    }

    /// Writes the widgets of a frame.
    pub(super) fn write(&self, update: Option<&TreeUpdate>, pixels_per_point: f32) {
        let (Some(file), Some(update)) = (&self.file, update) else { return };
        let is_own = |path: &std::path::Path| unnamed::head(path, HEADER.len()) == HEADER.as_bytes();
        let written = unnamed::check(file, false, is_own).map_err(|error| error.to_string()).and_then(|()| {
            atomic::write(file, lines(update, pixels_per_point).as_bytes()).map_err(|error| error.to_string())
        });
        if let Err(error) = written {
            tracing::warn!("HACHURE_WIDGETS: {error}");
        }
    }

    /// Waits until the frame has lasted for its intended time.
    pub(super) fn end_frame(&mut self) {
        if self.frame.is_zero() {
            return;
        }
        let begun = self.begun.take().unwrap_or_else(Instant::now);
        std::thread::sleep(self.frame.saturating_sub(begun.elapsed()));
        self.begun = Some(Instant::now());
    }
}

/// Returns the widgets as text.
fn lines(update: &TreeUpdate, pixels_per_point: f32) -> String {
    let scale = f64::from(pixels_per_point);
    let mut text = HEADER.to_owned();
    for (_, node) in &update.nodes {
        let Some(bounds) = node.bounds() else { continue };
        let name = node.label().unwrap_or_default();
        let value = match (node.value(), node.numeric_value()) {
            (Some(value), _) => value.to_owned(),
            (None, Some(number)) => number.to_string(),
            (None, None) => String::new(),
        };
        if name.is_empty() && value.is_empty() {
            continue;
        }
        let [left, top, right, bottom] =
            [bounds.x0, bounds.y0, bounds.x1, bounds.y1].map(|side| (side * scale).round());
        let [name, value] = [name, &value].map(|text| text.replace(['\t', '\n', '\r'], " "));
        let state = if node.is_disabled() { "disabled" } else { "" };
        text += &format!("{left}\t{top}\t{right}\t{bottom}\t{:?}\t{name}\t{value}\t{state}\n", node.role());
    }
    text
}
