//! The link between a sidecar and its GeoTIFF: the length of that file and a hash of its first and last bytes. A
//! sidecar whose link does not match is outdated.

use std::fs;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::bytes::{Cursor, fnv};

/// Number of bytes at each end of the .tif that the hash covers: all directories of a COG of ordinary size.
pub(crate) const LINK_BYTES: u64 = 64 * 1024;

/// A fingerprint of a .tif, stored in its sidecar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Link {
    /// Length of the .tif in bytes.
    pub tif_bytes: u64,
    /// FNV-1a hash of its first and last 64 KiB.
    pub tif_hash: u64,
}

impl Link {
    /// Computes the link to the file at `path` as it is now.
    pub(crate) fn to(path: &Path) -> io::Result<Self> {
        let mut file = fs::File::open(path)?;
        let tif_bytes = file.metadata()?.len();
        let mut ends = Vec::new();
        (&mut file).take(LINK_BYTES).read_to_end(&mut ends)?;
        file.seek(SeekFrom::Start(tif_bytes.saturating_sub(LINK_BYTES)))?;
        file.take(LINK_BYTES).read_to_end(&mut ends)?;
        Ok(Self { tif_bytes, tif_hash: fnv(&ends) })
    }

    pub(crate) fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.tif_bytes.to_le_bytes());
        bytes.extend(self.tif_hash.to_le_bytes());
    }

    pub(crate) fn parse(bytes: &mut Cursor<'_>) -> Option<Self> {
        Some(Self { tif_bytes: bytes.u64()?, tif_hash: bytes.u64()? })
    }
}
