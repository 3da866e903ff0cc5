//! Keeps edits that are not saved in the cache folder, so that they survive a crash. A thread writes them, so that no
//! frame waits for a disk.
//!
//! A file holds the text of one style or camera path. Its name is a checksum of the path or preset, and its first line
//! names it, so that the edits of one style are never offered for another. Edits are kept until they are saved or undone;
//! leaving the program without saving keeps them, too.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;

use super::document::StyleDocument;
use crate::file::cache_folder;
use crate::file::input::LARGEST_STYLE_BYTES;

/// Begins the first line of a file, before the name of the style.
const HEAD: &str = "# Unsaved edits of ";

/// The edits that are not saved, in a folder of the cache.
pub(crate) struct Unsaved {
    folder: Option<PathBuf>,
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
}

/// A file of the cache, and its new content; `None` removes it.
struct Job {
    path: PathBuf,
    text: Option<String>,
}

impl Unsaved {
    /// Opens the folder in hachure's cache. Without a cache nothing is kept.
    pub(crate) fn open() -> Self {
        let own = cache_folder::root().and_then(|root| {
            cache_folder::open(&root).inspect_err(|error| tracing::info!("{}: {error}", root.display())).ok()
        });
        Self::within(own.map(|own| own.join("unsaved")))
    }

    /// Opens a folder.
    pub(crate) fn within(folder: Option<PathBuf>) -> Self {
        let (jobs, received) = mpsc::channel();
        let thread = std::thread::Builder::new().name("unsaved edits".to_owned()).spawn(move || work(&received));
        Self { folder, jobs: Some(jobs), thread: thread.ok() }
    }

    /// Keeps the text of a document if it has edits, and removes what was kept of it otherwise.
    pub(crate) fn keep(&self, document: &StyleDocument) {
        self.keep_text(&full_name(document), document.is_edited().then(|| document.text()));
    }

    /// Keeps a text under a name that does not depend on the current folder, or removes the kept one.
    pub(super) fn keep_text(&self, name: &str, text: Option<&str>) {
        let (Some(path), Some(jobs)) = (self.path(name), &self.jobs) else { return };
        let text = text.map(|text| format!("{}{text}", first_line(name)));
        // The thread ends only with this value.
        let _ = jobs.send(Job { path, text });
    }

    /// Returns edits of a style that an earlier run has kept, if they differ from the document.
    pub(crate) fn find(&self, document: &StyleDocument) -> Option<String> {
        let text = self.find_text(&full_name(document), LARGEST_STYLE_BYTES)?;
        (text != document.text()).then_some(text)
    }

    /// Returns the text that an earlier run has kept under a name.
    pub(super) fn find_text(&self, name: &str, max_bytes: u64) -> Option<String> {
        let bytes = cache_folder::read(&self.path(name)?, max_bytes)?;
        let text = String::from_utf8(bytes).ok()?;
        text.strip_prefix(&first_line(name)).map(str::to_owned)
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(format!("{:08x}.toml", crc32fast::hash(name.as_bytes()))))
    }
}

impl Drop for Unsaved {
    /// Waits until everything is written.
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // A panic there was printed there.
            let _ = thread.join();
        }
    }
}

/// Returns the name of a style that does not depend on the current folder.
fn full_name(document: &StyleDocument) -> String {
    document.path().map_or_else(|| document.name().to_owned(), lasting)
}

/// Returns the name of a file that does not depend on the current folder.
pub(super) fn lasting(path: &Path) -> String {
    let absolute = path.canonicalize().or_else(|_| std::path::absolute(path));
    absolute.unwrap_or_else(|_| path.to_owned()).display().to_string()
}

fn first_line(name: &str) -> String {
    format!("{HEAD}{}\n", name.replace(['\n', '\r'], " "))
}

/// Writes and removes files until the sender is gone. Of several jobs for a file only the last one is done.
fn work(jobs: &Receiver<Job>) {
    while let Ok(first) = jobs.recv() {
        let mut waiting = vec![first];
        while let Ok(next) = jobs.try_recv() {
            waiting.retain(|job| job.path != next.path);
            waiting.push(next);
        }
        for Job { path, text } in waiting {
            let done = match text {
                Some(text) => cache_folder::write(&path, text.as_bytes()),
                None if cache_folder::is_file(&path) => std::fs::remove_file(&path),
                None => Ok(()),
            };
            if let Err(error) = done {
                tracing::info!("{}: {error}", path.display());
            }
        }
    }
}
