//! Reads bytes of files that are on this machine, behind HTTP(S), or in an S3 bucket. Knows nothing of heights.
//!
//! A file is read in blocks of 64 KiB. Adjacent missing blocks are fetched with one request. Fetched blocks stay in
//! memory (32 MiB for each file; the least recently used are dropped first) and, for remote files, in a folder on disk
//! under a key made of the file's URL and version. A failed request is repeated after a pause; a file that changes
//! while it is read is an error. Each request has deadlines, and each file has a time limit over all its requests:
//! whatever a server does, it cannot make its reader wait longer.
//!
//! ```text
//! read ─▶ blocks (memory) ─▶ disk (folder) ─▶ retry, patience ─▶ transport (file, HTTP, S3) ─▶ http
//! ```
//!
//! Bytes that arrive have no checksum of their own. A decoder that finds corrupt bytes reports them with
//! [`RemoteFile::invalidate`]; the next read requests them again. While [`RemoteFile::read_twice`] is on, every block
//! is requested twice and the answers must agree: this is for headers, which have no checksum.
//!
//! The reasons are in `docs/decisions/remote-files.md`.
#![cfg_attr(not(feature = "network"), allow(dead_code, reason = "some items are used by the network code alone"))]

mod url;
pub(crate) mod blocks;
#[cfg(feature = "network")]
mod bucket;
pub(crate) mod disk;
mod error;
pub(crate) mod file;
#[cfg(feature = "network")]
mod http;
#[cfg_attr(not(feature = "network"), path = "no_network.rs")]
mod network;
mod patience;
mod retry;
mod settings;
mod traffic;
mod transport;

pub(crate) use self::url::{name_of, sidecar_url};
pub use error::RemoteError;
pub(crate) use file::RemoteFile;
pub use settings::Settings;
pub use traffic::Traffic;

/// Called now and then while waiting; returns true when the bytes are no longer needed.
pub(crate) type Cancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// A [`Cancelled`] that never cancels.
pub(crate) fn never() -> bool {
    false
}

/// A 64-bit FNV-1a hash, fed in pieces. It detects accidental corruption, not attacks.
#[derive(Clone, Copy)]
pub(crate) struct Fnv(u64);

impl Fnv {
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(crate) fn add(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)))
    }

    pub(crate) fn finish(self) -> u64 {
        self.0
    }
}
