//! The errors of reading remote files.

use std::io;

use crate::file::message::{named, printable};

/// Largest number of characters of a cause, which may come from a server.
const LONGEST_CAUSE: usize = 180;

/// The reason why bytes could not be read. The message is one line with the URL (without its secrets) and the
/// cause.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RemoteError {
    /// The URL cannot be parsed.
    #[error("{}: {}", named(name), printable(cause, LONGEST_CAUSE))]
    BadUrl { name: String, cause: String },
    /// The server or the file system has no such file.
    #[error("{}: there is no such file", named(name))]
    NotFound { name: String },
    /// The server requires authentication, or refuses access.
    #[error("{}: access is denied ({})", named(name), printable(cause, LONGEST_CAUSE))]
    Denied {
        name: String,
        /// The cause in the server's words.
        cause: String,
    },
    /// The server does not support byte ranges, or cannot be used for another reason.
    #[error("{}: {}", named(name), printable(cause, LONGEST_CAUSE))]
    Unusable { name: String, cause: String },
    /// The file has changed since it was opened.
    #[error("{}: has changed since it was opened", named(name))]
    Changed { name: String },
    /// All tries failed.
    #[error("{}: no answer after {}: {}", named(name), times(*tries), printable(cause, LONGEST_CAUSE))]
    Failed {
        name: String,
        /// Number of requests that were made.
        tries: u32,
        /// The cause of the last failure.
        cause: String,
    },
    /// The file kept its reader waiting for too long, over all its requests.
    #[error(
        "{}: gave up after {seconds} s of waiting ({}): {}",
        named(name), times(*tries), printable(cause, LONGEST_CAUSE)
    )]
    GivenUp {
        name: String,
        /// The time limit that was used up, in seconds.
        seconds: f32,
        /// Number of requests for these bytes; 0 if the file had been given up before.
        tries: u32,
        /// The cause of the last failure.
        cause: String,
    },
    /// Reading a local file failed.
    #[error("{}: {source}", named(name))]
    Io { name: String, source: io::Error },
    /// The requested range extends beyond the end of the file.
    #[error("{}: read past the end of the file ({length} bytes at {offset}; the file has {size})", named(name))]
    OutOfRange {
        name: String,
        /// First byte of the range.
        offset: u64,
        /// Length of the range in bytes.
        length: u64,
        /// Size of the file in bytes.
        size: u64,
    },
    /// The caller no longer needs the bytes.
    #[error("the request was cancelled")]
    Cancelled,
}

fn times(tries: u32) -> String {
    match tries {
        0 => "in earlier requests".to_owned(),
        1 => "1 try".to_owned(),
        tries => format!("{tries} tries"),
    }
}

impl RemoteError {
    /// Returns whether further tries are useless.
    pub(crate) fn is_final(&self) -> bool {
        !matches!(self, Self::Cancelled | Self::Io { .. })
    }

    /// Returns whether the file may not exist: some servers deny access to files that they do not have.
    pub(crate) fn is_absent(&self) -> bool {
        matches!(self, Self::NotFound { .. } | Self::Denied { .. })
    }
}
