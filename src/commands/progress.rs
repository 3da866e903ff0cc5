//! Progress of long work, as a bar on the terminal.

use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressStyle};

use crate::source::Progress;

/// A bar on standard error; silent where that is not a terminal.
pub struct Bar {
    bar: ProgressBar,
    what: Mutex<String>,
}

impl Default for Bar {
    fn default() -> Self {
        let bar = ProgressBar::new(1000);
        let style = ProgressStyle::with_template("{msg:28} {wide_bar} {percent:>3} % {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        Self { bar, what: Mutex::new(String::new()) }
    }
}

impl Progress for Bar {
    fn report(&self, what: &str, done: f32) {
        // A poisoned lock only means that another report panicked; the text is still a text.
        let mut last = self.what.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if *last != what {
            what.clone_into(&mut last);
            self.bar.reset();
            self.bar.set_message(what.to_owned());
        }
        self.bar.set_position((done.clamp(0.0, 1.0) * 1000.0) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
