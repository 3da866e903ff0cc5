//! Bytes of files that lie elsewhere: on this machine, behind HTTP(S), in an S3 bucket. Knows nothing of heights.
//!
//! A file is read in blocks of 64 KiB. Blocks that adjoin and are missing come with one request; what came stays in
//! memory (32 MiB for each file, the longest unused first to go) and, for files of other machines, in a folder on disk
//! under the name that the address and the version of the file give. A request that fails is made again after a while;
//! a file that changes under the reader is an error. A request has deadlines, and a file has a patience over all its
//! requests: whatever a server does, it cannot hold its reader for longer.
//!
//! ```text
//! read ─▶ blocks (memory) ─▶ disk (folder) ─▶ retry, patience ─▶ transport (file, HTTP, S3) ─▶ http
//! ```
//!
//! Bytes that arrive have no checksum of their own. Who decodes them finds what is corrupt and says so with
//! [`RemoteFile::invalidate`]; the next read asks the server again. While [`RemoteFile::read_twice`] is on, every block
//! is asked for twice and the answers must agree: for headers, which have no checksum.
//!
//! Why: `docs/decisions/remote-files.md`.
#![cfg_attr(not(feature = "network"), allow(dead_code, reason = "some of it is of use to the network alone"))]

mod address;
mod blocks;
#[cfg(feature = "network")]
mod bucket;
mod disk;
mod error;
mod file;
#[cfg(feature = "network")]
mod http;
#[cfg_attr(not(feature = "network"), path = "no_network.rs")]
mod network;
mod patience;
mod retry;
mod settings;
mod traffic;
mod transport;

pub use address::{beside, is_remote, name_of};
pub use blocks::{BLOCK_BYTES, Block};
pub use disk::{CachedBlock, inspect};
pub use error::RemoteError;
pub use file::{Held, RemoteFile};
pub use settings::Settings;
pub use traffic::Traffic;

/// Asked now and then while waiting; true means that nobody wants the bytes any more.
pub type Cancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// Never.
pub fn never() -> bool {
    false
}

/// FNV-1a, 64 bits, in pieces: it finds accidents, not malice.
#[derive(Clone, Copy)]
pub(crate) struct Fnv(u64);

impl Fnv {
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub fn add(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)))
    }

    pub fn finish(self) -> u64 {
        self.0
    }
}
