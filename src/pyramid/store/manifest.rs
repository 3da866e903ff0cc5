//! The origin of a cached pyramid, which is also the manifest of its files: it records what was baked, and the
//! resulting .tif. Only files that a manifest describes are ever removed.
//!
//! ```text
//! 8 bytes  "HACHFRM2"
//! u64 u64  the fingerprint of the .tif
//! u64      FNV-1a of the numbers and the key
//! …        the key: everything that the heights depend on
//! ```
//!
//! The key itself is stored, because two keys may have the same hash.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

use crate::file::cache_folder;
use crate::pyramid::format::bytes::{Cursor, fnv};
use crate::pyramid::format::fingerprint::Fingerprint;

const MAGIC: &[u8; 8] = b"HACHFRM2";
/// Upper bound of the length of a manifest, in bytes: it names every member of a folder.
const LARGEST_BYTES: u64 = 64 << 20;

/// The origin of a cached pyramid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Manifest {
    fingerprint: Fingerprint,
    key: Vec<u8>,
}

/// Returns the path of the manifest of a pyramid.
pub(super) fn origin_path(tif: &Path) -> PathBuf {
    let mut path = OsString::from(tif);
    path.push(".from");
    path.into()
}

impl Manifest {
    /// Describes the .tif as it is now.
    pub(super) fn of(tif: &Path, key: &str) -> io::Result<Self> {
        Ok(Self { fingerprint: Fingerprint::of(tif)?, key: key.as_bytes().to_vec() })
    }

    /// Reads the manifest of a pyramid. Returns `None` if there is none, or if it is damaged.
    pub(super) fn read(tif: &Path) -> Option<Self> {
        let bytes = cache_folder::read(&origin_path(tif), LARGEST_BYTES)?;
        let mut rest = Cursor { bytes: bytes.strip_prefix(MAGIC)? };
        let numbers = rest.bytes.get(..16)?;
        let (fingerprint, sum) = (Fingerprint::parse(&mut rest)?, rest.u64()?);
        let key = rest.bytes.to_vec();
        (sum == fnv(&[numbers, &key].concat())).then_some(Self { fingerprint, key })
    }

    /// Returns the bytes of the file.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut numbers = Vec::new();
        self.fingerprint.put(&mut numbers);
        let sum = fnv(&[&numbers[..], &self.key].concat()).to_le_bytes();
        [MAGIC.as_slice(), &numbers, &sum, &self.key].concat()
    }

    /// Returns whether the manifest describes the .tif as it is now.
    pub(super) fn describes(&self, tif: &Path) -> bool {
        cache_folder::is_file(tif) && Fingerprint::of(tif).is_ok_and(|found| found == self.fingerprint)
    }
}

/// Writes the manifest of a pyramid that a test baked into a folder.
#[cfg(test)]
pub(crate) fn write_manifest(tif: &Path, key: &str) {
    let manifest = Manifest::of(tif, key).unwrap().to_bytes();
    cache_folder::write(&origin_path(tif), &manifest).unwrap();
}
