//! A GeoTIFF and its sidecar: finding both, and replacing both together.
//!
//! Two files cannot be renamed at once. So the new sidecar is first renamed to a temporary name in the same folder,
//! then the GeoTIFF gets its final name, then the sidecar; a reader takes whichever of the two sidecars matches the
//! GeoTIFF. Whenever the machine stops, either the old pyramid or the new one is complete.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::fingerprint::Fingerprint;
use super::sidecar::{HEAD_BYTES, HeaderFault, Sidecar, is_sidecar, sidecar_path};
use crate::file::random_access::RandomAccess;
use crate::pyramid::error::PyramidError;

/// Returns the temporary name of a new sidecar.
pub(crate) fn next_path(tif: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(sidecar_path(tif).file_name().unwrap_or_default());
    name.push(".next");
    tif.with_file_name(name)
}

/// Opens the sidecar that matches the GeoTIFF at `tif` as it is now. Returns its header, and the file with the records.
pub(crate) fn open_sidecar(tif: &Path) -> Result<(Sidecar, RandomAccess), PyramidError> {
    let opened = open_fitting(tif, &sidecar_path(tif));
    if opened.is_err() && next_path(tif).exists() {
        // A bake was stopped between two renames.
        if let Ok(next) = open_fitting(tif, &next_path(tif)) {
            return Ok(next);
        }
    }
    opened
}

/// Returns whether the GeoTIFF has a sidecar, matching or not.
pub(crate) fn has_sidecar(tif: &Path) -> bool {
    sidecar_path(tif).exists() || next_path(tif).exists()
}

fn open_fitting(tif: &Path, path: &Path) -> Result<(Sidecar, RandomAccess), PyramidError> {
    let unreadable = || PyramidError::io(path, "reading the tile statistics");
    let stale = |cause: &str| PyramidError::StaleSidecar { path: path.to_owned(), cause: cause.into() };
    let corrupt = |cause: &str| PyramidError::CorruptSidecar { path: path.to_owned(), cause: cause.into() };
    let file = match RandomAccess::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(PyramidError::NoSidecar { path: tif.to_owned(), sidecar: sidecar_path(tif) });
        }
        opened => opened.map_err(unreadable())?,
    };
    let file_bytes = file.len().map_err(unreadable())?;
    let read = |count: usize| match count as u64 <= file_bytes {
        true => file.read(0, count).map_err(unreadable()),
        false => Err(corrupt("the file is truncated")),
    };
    let fault = |fault| match fault {
        HeaderFault::Stale(cause) => stale(cause),
        HeaderFault::Corrupt(cause) => corrupt(cause),
    };
    let header_bytes = Sidecar::header_bytes(&read(HEAD_BYTES)?).map_err(fault)?;
    let sidecar = Sidecar::parse_header(&read(header_bytes)?).map_err(fault)?;
    if sidecar.file_bytes() != file_bytes {
        return Err(corrupt("its length does not match its header"));
    }
    let fingerprint = Fingerprint::of(tif).map_err(PyramidError::io(tif, "opening"))?;
    if fingerprint != sidecar.fingerprint {
        return Err(stale("the GeoTIFF has changed since it was baked"));
    }
    Ok((sidecar, file))
}

/// Renames both files, which are completely written and synced under temporary names, to their final names.
pub(crate) fn commit(tif: &Path, sidecar: &Path, out: &Path) -> Result<(), PyramidError> {
    let next = next_path(out);
    let rename = |from: &Path, to: &Path| fs::rename(from, to).map_err(PyramidError::io(to, "writing"));
    rename(sidecar, &next)?;
    rename(tif, out)?;
    match rename(&next, &sidecar_path(out)) {
        // Another process baked the same pyramid and did the last step first.
        Err(PyramidError::Io { source, .. })
            if source.kind() == io::ErrorKind::NotFound && open_fitting(out, &sidecar_path(out)).is_ok() =>
        {
            Ok(())
        }
        renamed => renamed,
    }
}

/// Removes what an interrupted commit left behind, if the pyramid is complete without it.
pub(crate) fn tidy(out: &Path) {
    let next = next_path(out);
    if is_sidecar(&next) && open_fitting(out, &sidecar_path(out)).is_ok() {
        let _ = fs::remove_file(next);
    }
}
