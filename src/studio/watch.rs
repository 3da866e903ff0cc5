//! Reports when files of a style change outside of the program.
//!
//! Editors replace files in different ways: they truncate and write, or write another file and rename it. So the folders
//! of the files are watched, not the files, and a change is reported when nothing has happened for a moment.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use notify::event::{AccessKind, AccessMode};
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

/// How long nothing must happen before a change is reported: an editor that truncates a file writes it soon.
const QUIET: Duration = Duration::from_millis(40);
/// A change is reported after this time at the latest.
const LATEST: Duration = Duration::from_millis(160);

/// Watches files from a thread of its own.
pub(crate) struct FileWatch {
    messages: Sender<Message>,
    changes: Receiver<()>,
}

enum Message {
    /// Something happened in a folder.
    Event(Event),
    /// These files are to be watched from now on, and no others.
    Follow(Vec<PathBuf>),
    /// Nothing is to be watched any more.
    End,
}

impl FileWatch {
    /// Starts to watch no files yet. `wake` is called from another thread when there is something to
    /// [take](FileWatch::take). Returns `None`, and logs why, if the system cannot watch files.
    pub(crate) fn start(wake: impl Fn() + Send + 'static) -> Option<Self> {
        let (messages, received) = mpsc::channel();
        let (report, changes) = mpsc::channel();
        let events = messages.clone();
        let watcher = notify::recommended_watcher(move |event: notify::Result<Event>| match event {
            // If the receiver is gone, the program ends.
            Ok(event) => _ = events.send(Message::Event(event)),
            Err(error) => tracing::info!("cannot watch files: {error}"),
        });
        let watcher = watcher.inspect_err(|error| tracing::warn!("cannot watch files: {error}")).ok()?;
        let thread = std::thread::Builder::new().name("files of styles".to_owned());
        let watch = move || {
            follow_events(watcher, &received, || {
                if report.send(()).is_ok() {
                    wake();
                }
            });
        };
        thread.spawn(watch).inspect_err(|error| tracing::warn!("cannot watch files: {error}")).ok()?;
        Some(Self { messages, changes })
    }

    /// Watches these files from now on, and no others.
    pub(crate) fn follow(&self, files: &[PathBuf]) {
        // If the thread is gone, nothing can be watched.
        let _ = self.messages.send(Message::Follow(files.to_vec()));
    }

    /// Returns whether files have changed since the last call.
    pub(crate) fn take(&self) -> bool {
        self.changes.try_iter().count() > 0
    }

    /// Waits for a change.
    #[cfg(test)]
    pub(super) fn wait(&self, at_most: Duration) -> bool {
        self.changes.recv_timeout(at_most).is_ok()
    }
}

/// The files that are watched, each with the folders that hold it: a link may be replaced, and what it leads to.
#[derive(Default)]
struct Followed {
    files: BTreeSet<PathBuf>,
    folders: BTreeSet<PathBuf>,
}

impl Followed {
    fn of(files: &[PathBuf]) -> Self {
        let absolute = files.iter().filter_map(|file| std::path::absolute(file).ok());
        let both = absolute.flat_map(|file| {
            let folder = file.parent().and_then(|folder| folder.canonicalize().ok());
            let named = folder.and_then(|folder| Some(folder.join(file.file_name()?)));
            [named, file.canonicalize().ok()]
        });
        let files: BTreeSet<PathBuf> = both.flatten().collect();
        let folders = files.iter().filter_map(|file| file.parent().map(Path::to_owned)).collect();
        Self { files, folders }
    }

    /// Returns whether an event changes one of the files. Reading a file is an event, too.
    fn is_changed_by(&self, event: &Event) -> bool {
        let is_reading = match event.kind {
            EventKind::Access(AccessKind::Close(AccessMode::Write)) => false,
            EventKind::Access(_) => true,
            _ => false,
        };
        !is_reading && event.paths.iter().any(|path| self.files.contains(path))
    }
}

fn follow_events(mut watcher: RecommendedWatcher, messages: &Receiver<Message>, report: impl Fn()) {
    let mut followed = Followed::default();
    // Time of the first change that is not reported yet.
    let mut changed_at: Option<Instant> = None;
    loop {
        let message = match changed_at {
            None => messages.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(first) => messages.recv_timeout(QUIET.min((first + LATEST).saturating_duration_since(Instant::now()))),
        };
        match message {
            Ok(Message::Event(event)) if followed.is_changed_by(&event) => {
                changed_at.get_or_insert_with(Instant::now);
            }
            Ok(Message::Event(_)) => {}
            Ok(Message::Follow(files)) => {
                let next = Followed::of(&files);
                for folder in followed.folders.difference(&next.folders) {
                    // A folder that is gone is not watched anyway.
                    let _ = watcher.unwatch(folder);
                }
                for folder in next.folders.difference(&followed.folders) {
                    if let Err(error) = watcher.watch(folder, RecursiveMode::NonRecursive) {
                        tracing::warn!("{}: cannot watch this folder: {error}", folder.display());
                    }
                }
                followed = next;
            }
            Err(RecvTimeoutError::Timeout) => {
                changed_at = None;
                report();
            }
            Ok(Message::End) | Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

impl Drop for FileWatch {
    fn drop(&mut self) {
        // The system's watcher, which the thread owns, has a sender of its own.
        let _ = self.messages.send(Message::End);
    }
}
