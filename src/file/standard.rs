//! Standard output and standard error, written without `println!` and `eprintln!`: those panic when nobody reads any
//! more or the disk behind them is full.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::FileError;

/// Writes `text` and a line's end to standard output. A reader that has heard enough (`… | head`) is no failure.
///
/// # Errors
/// Standard output cannot be written for another reason, such as a full disk.
pub fn print(text: &str) -> Result<(), FileError> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{}", text.trim_end()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(FileError::write(Path::new("standard output"), error))
        }
        _ => Ok(()),
    }
}

/// Writes `text` and a line's end to standard error. If that fails, there is nowhere left to report it.
pub fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
