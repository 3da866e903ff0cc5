//! Some cases run through the program itself: its exit status, and its standard error.

use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use super::kinds::Kind;
use super::rule;
use super::seeds::Seed;

/// The time limit: a case that takes a second alone takes much longer on a loaded machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Returns whether a case also runs through the program: three of a short run, every 500th of a long one.
pub(crate) fn is_due(index: u64, cases: u64) -> bool {
    index.is_multiple_of((cases / 3).clamp(1, 500))
}

/// Returns what is wrong with the program's response to the current files of a seed.
pub(crate) fn fault(kind: &Kind, seed: &Seed) -> Option<String> {
    let arguments = kind.arguments?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
    command.args(arguments).arg(seed.entry()).env("HACHURE_CACHE", seed.folder.with_extension("cache"));
    command.env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let Some(output) = output(command) else { return Some(format!("hachure {arguments:?} hangs")) };
    let error = String::from_utf8_lossy(&output.stderr);
    // Warnings may precede the line with the error.
    let last = error.trim_end_matches('\n').rsplit('\n').next().unwrap_or_default();
    let is_foreign = |c: char| c.is_control() && c != '\n';
    // The last line is checked by another rule.
    let before = error.trim_end_matches('\n').strip_suffix(last).unwrap_or_default();
    let is_noisy = error.contains("panicked") || before.chars().any(is_foreign);
    let printed = String::from_utf8_lossy(&output.stdout);
    match (output.status.code(), last.strip_prefix("hachure: ")) {
        _ if is_noisy => Some(format!("hachure {arguments:?} prints {error:?}")),
        (Some(0), _) if printed.chars().any(is_foreign) => Some(format!("hachure {arguments:?} prints {printed:?}")),
        (Some(0), _) => None,
        (Some(1), Some(line)) => rule::fault(seed, line),
        (status, _) => Some(format!("hachure {arguments:?} ends with {status:?} and prints {error:?}")),
    }
}

/// Returns the output of a process, or `None` if it does not end in time.
fn output(mut command: Command) -> Option<Output> {
    let child = command.spawn().unwrap();
    let id = child.id();
    let (send, answer) = std::sync::mpsc::channel();
    drop(std::thread::spawn(move || send.send(child.wait_with_output())));
    let start = Instant::now();
    let output = answer.recv_timeout(PATIENCE);
    if output.is_err() {
        println!("process {id} did not end within {:?}", start.elapsed());
        // A process that hangs is a failure of this test and must not outlive it.
        drop(Command::new("kill").arg("-9").arg(id.to_string()).status());
    }
    output.ok().map(Result::unwrap)
}
