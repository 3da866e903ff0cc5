//! The fingerprint of a GeoTIFF that its sidecar stores: the length of the file and a hash of its first and last bytes.
//! A sidecar whose fingerprint differs from that of the file is outdated. A change that leaves the length and both ends
//! as they are goes unnoticed.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::bytes::{Cursor, fnv};
use crate::file::input::open_regular;

/// Number of bytes at each end of the .tif that the hash covers: enough for the IFDs of a COG of about 4,000 tiles,
/// which contain the offsets and lengths of the tiles.
pub(crate) const END_BYTES: u64 = 64 * 1024;

/// The fingerprint of a .tif.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fingerprint {
    /// Length of the .tif in bytes.
    pub tif_bytes: u64,
    /// FNV-1a hash of its first and last [`END_BYTES`], one after the other.
    pub tif_hash: u64,
}

impl Fingerprint {
    /// Computes the fingerprint of the file at `path` as it is now.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let mut file = open_regular(path)?;
        let tif_bytes = file.metadata()?.len();
        let mut ends = Vec::new();
        (&mut file).take(END_BYTES).read_to_end(&mut ends)?;
        file.seek(SeekFrom::Start(tif_bytes.saturating_sub(END_BYTES)))?;
        file.take(END_BYTES).read_to_end(&mut ends)?;
        Ok(Self { tif_bytes, tif_hash: fnv(&ends) })
    }

    /// Appends the fingerprint to `bytes`, as the sidecar stores it.
    pub(crate) fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.tif_bytes.to_le_bytes());
        bytes.extend(self.tif_hash.to_le_bytes());
    }

    /// Reads a fingerprint. Returns `None` at the end of the bytes.
    pub(crate) fn parse(bytes: &mut Cursor<'_>) -> Option<Self> {
        Some(Self { tif_bytes: bytes.u64()?, tif_hash: bytes.u64()? })
    }
}
