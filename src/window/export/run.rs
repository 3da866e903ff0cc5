//! Runs an export in the background: hachure itself, with the command line that the dialog shows.
//!
//! A program of its own shares no memory of the GPU's driver with the window, cannot end it, and is cancelled as in a
//! terminal: it removes the files that it has begun.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::file::message::printable;
use crate::file::progress_lines;
use crate::source::Progress;
use crate::window::background::{Background, NoResult};
use crate::window::works::BackgroundTask;

/// Interval at which the program is looked at.
const LOOK: Duration = Duration::from_millis(30);
/// Time in which a cancelled program removes its files; then it is ended.
const PATIENCE: Duration = Duration::from_secs(10);
/// Largest number of messages that are kept: the first and the last ones say most.
const MAX_MESSAGES: usize = 20;
/// Longest message in characters.
const LONGEST: usize = 480;

/// The end of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::window) enum End {
    /// The files are written; the lines are what the program printed: warnings, and a summary.
    Written(Vec<String>),
    /// The program failed, with its message.
    Failed(String),
    /// The user cancelled it.
    Cancelled,
}

/// An export that is running.
pub(in crate::window) struct Run {
    /// The progress of the export, and its cancellation.
    pub work: Arc<BackgroundTask>,
    /// The path of the output.
    pub output: String,
    end: Background<End>,
}

impl Run {
    /// Starts `program` with arguments, and calls `wake` when there is progress and at the end.
    pub(in crate::window) fn start(
        program: &Path,
        arguments: &[String],
        output: &str,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let name = Path::new(output).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let work = Arc::new(BackgroundTask::new(format!("Exporting {name}"), wake));
        let mut command = Command::new(program);
        command.args(arguments).env(progress_lines::VARIABLE, progress_lines::LINES);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let [of_thread, at_end] = [Arc::clone(&work), Arc::clone(&work)];
        let end = Background::start("export", move || run(command, &of_thread), move || at_end.wake());
        Self { work, output: output.to_owned(), end }
    }

    /// Takes the end of the export; `None` while it is running.
    pub(in crate::window) fn take(&self) -> Option<End> {
        let end = self.end.take()?;
        Some(end.unwrap_or_else(|NoResult| End::Failed("the export could not be started".to_owned())))
    }
}

impl Drop for Run {
    /// Cancels the export, and waits until its files are removed.
    fn drop(&mut self) {
        self.work.cancel();
        self.end.wait();
    }
}

/// Runs a program to its end.
fn run(mut command: Command, work: &Arc<BackgroundTask>) -> End {
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) => {
            return End::Failed(format!("cannot run {}: {error}", command.get_program().to_string_lossy()));
        }
    };
    let of_reader = Arc::clone(work);
    let errors = child.stderr.take().map(|stream| std::thread::spawn(move || read(stream, Some(&of_reader))));
    let printed = child.stdout.take().map(|stream| std::thread::spawn(move || read(stream, None)));
    let mut cancelled_at = None;
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => std::thread::sleep(LOOK),
            Err(error) => return End::Failed(error.to_string()),
        }
        match cancelled_at {
            None if work.is_cancelled() => {
                cancelled_at = Some(Instant::now());
                ask_to_end(&mut child);
            }
            Some(at) if at.elapsed() > PATIENCE => _ = child.kill(),
            _ => {}
        }
    };
    let lines = |reader: Option<JoinHandle<Vec<String>>>| reader.and_then(|it| it.join().ok()).unwrap_or_default();
    let (mut messages, printed) = (lines(errors), lines(printed));
    // A program that was already done when it was cancelled has written its files.
    if status.success() {
        messages.extend(printed);
        return End::Written(messages);
    }
    if cancelled_at.is_some() {
        return End::Cancelled;
    }
    let message = messages.pop().map(|line| line.strip_prefix("hachure: ").unwrap_or(&line).to_owned());
    End::Failed(message.unwrap_or_else(|| format!("the program ended without a message ({status})")))
}

/// Asks a program to end, so that it removes what it has begun to write.
#[cfg(unix)]
fn ask_to_end(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process};
    if kill_process(Pid::from_child(child), Signal::TERM).is_err() {
        let _ = child.kill();
    }
}

/// Ends a program. It leaves a temporary file behind.
#[cfg(not(unix))]
fn ask_to_end(child: &mut Child) {
    let _ = child.kill();
}

/// Reads lines to the end of a stream, reports progress, and returns the messages.
fn read(stream: impl Read, work: Option<&BackgroundTask>) -> Vec<String> {
    let mut messages = Vec::new();
    let mut lines = BufReader::new(stream);
    let mut line = Vec::new();
    while lines.read_until(b'\n', &mut line).is_ok_and(|bytes| bytes > 0) {
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_end();
        match (work, progress_lines::parse(text)) {
            (Some(work), Some((what, done))) => work.report(what, done),
            _ if text.is_empty() => {}
            _ => {
                if messages.len() >= MAX_MESSAGES {
                    messages.remove(MAX_MESSAGES / 2);
                }
                messages.push(printable(&text.strip_prefix("WARN ").unwrap_or(text).replace('\u{1b}', ""), LONGEST));
            }
        }
        line.clear();
    }
    messages
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use std::sync::mpsc::{Receiver, channel};

    use super::*;

    fn start(script: &str) -> (Run, Receiver<()>) {
        let (sender, woken) = channel();
        let sender = std::sync::Mutex::new(sender);
        let arguments = ["-c".to_owned(), script.to_owned()];
        let wake = move || _ = sender.lock().unwrap().send(());
        (Run::start(Path::new("/bin/sh"), &arguments, "/tmp/a.png", wake), woken)
    }

    fn end(run: &Run, woken: &Receiver<()>) -> End {
        loop {
            if let Some(end) = run.take() {
                return end;
            }
            woken.recv_timeout(Duration::from_secs(30)).unwrap();
        }
    }

    #[test]
    fn progress_and_messages_are_read() {
        let script = "[ \"$HACHURE_PROGRESS\" = lines ] && echo 'progress 0.5000 drawing' >&2; echo 'nearly blank' >&2; \
             echo '4 sheets'";
        let (run, woken) = start(script);
        assert_eq!(end(&run, &woken), End::Written(vec!["nearly blank".to_owned(), "4 sheets".to_owned()]));
        assert_eq!(run.work.step(), ("drawing".to_owned(), 0.5));
        assert_eq!(run.work.title, "Exporting a.png");
    }

    #[test]
    fn a_failure_is_its_last_message() {
        let (run, woken) = start("echo 'a warning' >&2; echo 'hachure: --pens: no' >&2; exit 2");
        assert_eq!(end(&run, &woken), End::Failed("--pens: no".to_owned()));
        let (run, woken) = start("exit 3");
        assert!(matches!(end(&run, &woken), End::Failed(message) if message.contains("without a message")));
        let (sender, woken) = channel();
        let sender = std::sync::Mutex::new(sender);
        let run = Run::start(Path::new("/no/such/program"), &[], "a", move || _ = sender.lock().unwrap().send(()));
        assert!(matches!(end(&run, &woken), End::Failed(message) if message.contains("cannot run /no/such/program")));
    }

    #[test]
    fn a_cancelled_program_tidies_up() {
        let folder = tempfile::tempdir().unwrap();
        let [began, tidied] = ["began", "tidied"].map(|name| folder.path().join(name));
        let script = format!(
            "trap 'touch {}; exit 143' TERM; echo 'progress 0.1 drawing' >&2; touch {}; while :; do sleep 0.05; done",
            tidied.display(),
            began.display()
        );
        let wait_for = |path: &Path| {
            let begun = Instant::now();
            while !path.exists() {
                assert!(begun.elapsed() < Duration::from_secs(30));
                std::thread::sleep(LOOK);
            }
        };
        let (run, woken) = start(&script);
        wait_for(&began);
        assert_eq!(run.take(), None);
        run.work.cancel();
        assert_eq!(end(&run, &woken), End::Cancelled);
        assert!(tidied.exists());
        // A window that closes cancels the export, too.
        std::fs::remove_file(&began).unwrap();
        std::fs::remove_file(&tidied).unwrap();
        let (run, _woken) = start(&script);
        wait_for(&began);
        drop(run);
        assert!(tidied.exists());
    }
}
