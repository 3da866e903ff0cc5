//! What can go wrong with a file that lies elsewhere.

use std::io;

use crate::file::message::{named, printable};

/// Characters of a cause, at most: it may be in the words of a server.
const LONGEST_CAUSE: usize = 180;

/// Why bytes could not be had. The message is one line with the address, without the secrets in it, and the cause.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RemoteError {
    /// It cannot be understood.
    #[error("{}: {}", named(name), printable(cause, LONGEST_CAUSE))]
    BadAddress {
        /// The address.
        name: String,
        /// What is wrong with it.
        cause: String,
    },
    /// The server, or the file system, knows no such file.
    #[error("{}: there is no such file", named(name))]
    NotFound {
        /// The address.
        name: String,
    },
    /// The server wants to know who asks, or knows and does not give.
    #[error("{}: access is denied ({})", named(name), printable(cause, LONGEST_CAUSE))]
    Denied {
        /// The address.
        name: String,
        /// In the server's words.
        cause: String,
    },
    /// The server does not do what is needed: ranges of bytes.
    #[error("{}: {}", named(name), printable(cause, LONGEST_CAUSE))]
    Unusable {
        /// The address.
        name: String,
        /// What it does not do.
        cause: String,
    },
    /// The file is another one than when it was opened.
    #[error("{}: has changed since it was opened", named(name))]
    Changed {
        /// The address.
        name: String,
    },
    /// All tries failed.
    #[error("{}: no answer after {}: {}", named(name), times(*tries), printable(cause, LONGEST_CAUSE))]
    Failed {
        /// The address.
        name: String,
        /// How many requests were made.
        tries: u32,
        /// Of the last one.
        cause: String,
    },
    /// It kept its reader waiting for too long, over all its requests.
    #[error(
        "{}: given up after {seconds} s of waiting ({}): {}",
        named(name), times(*tries), printable(cause, LONGEST_CAUSE)
    )]
    GivenUp {
        /// The address.
        name: String,
        /// The patience that was used up.
        seconds: f32,
        /// How many requests were made for the bytes in question; none if the file had been given up before.
        tries: u32,
        /// Of the last one.
        cause: String,
    },
    /// The file on this machine.
    #[error("{}: {source}", named(name))]
    Io {
        /// Its path.
        name: String,
        /// The system's reason.
        source: io::Error,
    },
    /// Bytes beyond the end were asked for.
    #[error("{}: has {size} bytes, and {length} from {offset} on were asked for", named(name))]
    OutOfRange {
        /// The address.
        name: String,
        /// First byte.
        offset: u64,
        /// How many.
        length: u64,
        /// How many there are.
        size: u64,
    },
    /// Nobody wants the bytes any more.
    #[error("no longer wanted")]
    Cancelled,
}

fn times(tries: u32) -> String {
    match tries {
        0 => "before".to_owned(),
        1 => "1 try".to_owned(),
        tries => format!("{tries} tries"),
    }
}

impl RemoteError {
    /// Whether it was tried again until there was no use in it.
    pub fn is_final(&self) -> bool {
        !matches!(self, Self::Cancelled | Self::Io { .. })
    }

    /// Whether there is no such file for all that we may know: some servers deny what they do not have.
    pub fn is_absent(&self) -> bool {
        matches!(self, Self::NotFound { .. } | Self::Denied { .. })
    }
}
