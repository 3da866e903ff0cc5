//! Programs that hachure runs (ffmpeg): they end with hachure, and have a deadline.
//!
//! On Unix a program gets a process group of its own. A watchdog, which is a shell that waits for the end of a pipe
//! whose other end only hachure holds, kills the group when hachure ends in any way: by Ctrl-C, a panic, or `kill -9`.
//! On other systems the program sees that its standard input has ended, which makes ffmpeg stop.

use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Output, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time without progress after which a program is ended.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);
/// Interval at which a program that is waited for is looked at.
const LOOK: Duration = Duration::from_millis(5);
/// Largest output of a program that is read, in bytes.
const LARGEST_OUTPUT_BYTES: u64 = 8 << 20;

/// The script of the watchdog. It reads the process group, and then `done` if the program has ended before hachure. Its
/// arguments are a file and its folder, which are removed with the group.
const WATCHDOG: &str = "read -r group; read -r word; [ \"$word\" = done ] && exit; \
    [ -z \"$group\" ] || kill -s KILL -- \"-$group\"; [ -z \"$1\" ] || { rm -f -- \"$1\"; rmdir -- \"$2\"; }";

/// A running program that ends with hachure. Dropping it ends it.
pub(super) struct Guarded {
    child: Child,
    watchdog: Option<(Child, ChildStdin)>,
    is_over: bool,
}

impl Guarded {
    /// Starts a program. If hachure ends before it, `partial`, which the program writes in a folder of its own, is
    /// removed with that folder.
    pub(super) fn spawn(command: &mut Command, partial: Option<&Path>) -> io::Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        // The watchdog is started first: it takes longer to start than the program, which would have no guard meanwhile.
        let mut watchdog = watchdog(partial);
        let child = match command.spawn() {
            Ok(child) => child,
            Err(error) => {
                end_watchdog(watchdog, b"\ndone\n");
                return Err(error);
            }
        };
        if let Some((_, pipe)) = &mut watchdog {
            let _ = pipe.write_all(format!("{}\n", child.id()).as_bytes());
        }
        Ok(Self { child, watchdog, is_over: false })
    }

    pub(super) fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Ends the program with everything that it started.
    pub(super) fn kill(&mut self) {
        #[cfg(unix)]
        if !self.is_over {
            let _ = rustix::process::kill_process_group(
                rustix::process::Pid::from_child(&self.child),
                rustix::process::Signal::KILL,
            );
        }
        let _ = self.child.kill();
        let _ = self.wait();
    }

    /// Waits until the program ends, as long as `progress` returns another value within `patience`. A program without
    /// progress is ended; then this returns `None`.
    pub(super) fn wait_while<T: PartialEq>(
        &mut self,
        patience: Duration,
        mut progress: impl FnMut() -> T,
    ) -> io::Result<Option<ExitStatus>> {
        let (mut last, mut since) = (progress(), Instant::now());
        loop {
            if let Some(status) = self.child.try_wait()? {
                self.dismiss();
                return Ok(Some(status));
            }
            std::thread::sleep(LOOK);
            let now = progress();
            if now != last {
                (last, since) = (now, Instant::now());
            } else if since.elapsed() > patience {
                self.kill();
                return Ok(None);
            }
        }
    }

    fn wait(&mut self) -> io::Result<ExitStatus> {
        let status = self.child.wait();
        self.dismiss();
        status
    }

    /// Ends the watchdog: the process group no longer exists, and its number may be given to another one.
    fn dismiss(&mut self) {
        self.is_over = true;
        end_watchdog(self.watchdog.take(), b"done\n");
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        if !self.is_over {
            self.kill();
        }
    }
}

/// Sends the last words to a watchdog, and waits until it has ended.
fn end_watchdog(watchdog: Option<(Child, ChildStdin)>, words: &[u8]) {
    if let Some((mut watchdog, mut pipe)) = watchdog {
        let _ = pipe.write_all(words);
        drop(pipe);
        let _ = watchdog.wait();
    }
}

/// Starts a watchdog. Without a shell there is none.
#[cfg(unix)]
fn watchdog(partial: Option<&Path>) -> Option<(Child, ChildStdin)> {
    use std::os::unix::process::CommandExt;
    let folder = partial.and_then(Path::parent).unwrap_or(Path::new(""));
    let mut shell = Command::new("/bin/sh");
    shell.args(["-c", WATCHDOG, "hachure-watchdog"]).arg(partial.unwrap_or(Path::new(""))).arg(folder);
    // In a group of its own, Ctrl-C in a terminal does not end it before hachure.
    shell.process_group(0).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
    match shell.spawn() {
        Ok(mut watchdog) => watchdog.stdin.take().map(|pipe| (watchdog, pipe)),
        Err(error) => {
            tracing::debug!("cannot start a watchdog: {error}");
            None
        }
    }
}

#[cfg(not(unix))]
fn watchdog(_: Option<&Path>) -> Option<(Child, ChildStdin)> {
    None
}

/// Reads a pipe in the background, because a full pipe would block the program. Longer output is cut.
pub(super) fn read_in_background(pipe: Option<impl Read + Send + 'static>) -> Option<JoinHandle<Vec<u8>>> {
    pipe.map(|mut pipe| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            // Text that was read before an error is still useful. The rest is read so that the program is not blocked.
            let _ = (&mut pipe).take(LARGEST_OUTPUT_BYTES).read_to_end(&mut bytes);
            let _ = io::copy(&mut pipe, &mut io::sink());
            bytes
        })
    })
}

/// Runs a program without input and returns its output.
///
/// # Errors
/// Passes on the system's errors; also fails if the program does not end within `patience`.
pub(super) fn output(command: &mut Command, patience: Duration) -> io::Result<Output> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut program = Guarded::spawn(command, None)?;
    let stdout = read_in_background(program.child().stdout.take());
    let stderr = read_in_background(program.child().stderr.take());
    let Some(status) = program.wait_while(patience, || ())? else {
        return Err(io::Error::new(io::ErrorKind::TimedOut, format!("it did not end within {} s", patience.as_secs())));
    };
    Ok(Output { status, stdout: all_read(stdout), stderr: all_read(stderr) })
}

/// Returns what was read in the background, after the program has ended. Another process may still hold the pipe; it is
/// not waited for.
pub(super) fn all_read(thread: Option<JoinHandle<Vec<u8>>>) -> Vec<u8> {
    let (Some(thread), start) = (thread, Instant::now()) else { return Vec::new() };
    while !thread.is_finished() && start.elapsed() < Duration::from_secs(2) {
        std::thread::sleep(LOOK);
    }
    if thread.is_finished() { thread.join().unwrap_or_default() } else { Vec::new() }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", script]);
        shell
    }

    #[test]
    fn a_program_has_a_deadline() {
        let patience = Duration::from_millis(200);
        let output = output(&mut shell("echo a; echo b >&2; exit 3"), patience * 50).unwrap();
        assert_eq!((output.status.code(), output.stdout, output.stderr), (Some(3), b"a\n".to_vec(), b"b\n".to_vec()));
        // The shell's own child holds the pipe open: it is ended as well.
        let start = Instant::now();
        let error = super::output(&mut shell("sleep 100; true"), patience).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        assert!(start.elapsed() < Duration::from_secs(20));
        // Progress prolongs the deadline.
        let mut program = Guarded::spawn(&mut shell("sleep 0.5"), None).unwrap();
        let start = Instant::now();
        assert!(program.wait_while(patience, || start.elapsed().as_millis() / 50).unwrap().unwrap().success());
    }

    #[test]
    fn the_watchdog_ends_the_group_and_removes_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let work = folder.path().join("work");
        std::fs::create_dir(&work).unwrap();
        super::super::atomic::write(&work.join("film"), b"x").unwrap();
        let mut program = Guarded::spawn(&mut shell("sleep 100; true"), Some(&work.join("film"))).unwrap();
        // The end of hachure closes its end of the pipe.
        let (mut watchdog, pipe) = program.watchdog.take().unwrap();
        drop(pipe);
        assert!(!program.child.wait().unwrap().success());
        watchdog.wait().unwrap();
        assert!(!work.exists());
        program.is_over = true;
    }
}
