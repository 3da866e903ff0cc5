//! Writes to standard output and standard error without `println!` and `eprintln!`, which panic when the reader has
//! closed the pipe or the disk is full.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::FileError;

/// Writes `text`, without whitespace at its end, and a line break to standard output. A reader that closes the pipe
/// early (`… | head`) is not an error.
///
/// # Errors
/// Fails if standard output cannot be written for another reason, such as a full disk.
pub(crate) fn print(text: &str) -> Result<(), FileError> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{}", text.trim_end()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(FileError::write(Path::new("standard output"), error))
        }
        _ => Ok(()),
    }
}

/// Writes `text` and a line break to standard error. If that fails, there is nowhere left to report it.
pub fn print_to_stderr(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
