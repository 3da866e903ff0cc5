//! A GeoTIFF and its sidecar: how both are found and change places together.
//!
//! Two files cannot be renamed at once. So the new sidecar first takes a name of its own beside the old one, then the
//! GeoTIFF takes its name, then the sidecar; a reader takes whichever of the two sidecars fits the GeoTIFF. Whenever
//! the machine stops, the old pyramid is whole, or the new one.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::link::Link;
use super::sidecar::{HEAD_BYTES, HeaderFault, Sidecar, sidecar_path};
use crate::file::random_access::RandomAccess;
use crate::pyramid::error::PyramidError;

/// The sidecar on its way to its name.
fn next_path(tif: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(sidecar_path(tif).file_name().unwrap_or_default());
    name.push(".next");
    tif.with_file_name(name)
}

/// The header of the sidecar of the GeoTIFF at `tif`, which belongs to that file as it is now, and the file with the
/// records.
pub fn open_sidecar(tif: &Path) -> Result<(Sidecar, RandomAccess), PyramidError> {
    let opened = open_fitting(tif, &sidecar_path(tif));
    if opened.is_err() && next_path(tif).exists() {
        // A bake was stopped between two renames.
        if let Ok(next) = open_fitting(tif, &next_path(tif)) {
            return Ok(next);
        }
    }
    opened
}

/// Whether there is a sidecar of the GeoTIFF, fitting or not.
pub fn has_sidecar(tif: &Path) -> bool {
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
        false => Err(corrupt("it is cut short")),
    };
    let fault = |fault| match fault {
        HeaderFault::Stale(cause) => stale(cause),
        HeaderFault::Corrupt(cause) => corrupt(cause),
    };
    let header_bytes = Sidecar::header_bytes(&read(HEAD_BYTES)?).map_err(fault)?;
    let sidecar = Sidecar::parse_header(&read(header_bytes)?).map_err(fault)?;
    if sidecar.file_bytes() != file_bytes {
        return Err(corrupt("its length is wrong"));
    }
    let link = Link::to(tif).map_err(PyramidError::io(tif, "opening"))?;
    if link != sidecar.link {
        return Err(stale("the GeoTIFF has changed since"));
    }
    Ok((sidecar, file))
}

/// Gives both files, which are whole and on the disk under other names beside `out`, their names.
pub fn commit(tif: &Path, sidecar: &Path, out: &Path) -> Result<(), PyramidError> {
    let next = next_path(out);
    let rename = |from: &Path, to: &Path| fs::rename(from, to).map_err(PyramidError::io(to, "writing"));
    rename(sidecar, &next)?;
    rename(tif, out)?;
    match rename(&next, &sidecar_path(out)) {
        // Another process that bakes the same was faster with the last step.
        Err(PyramidError::Io { source, .. })
            if source.kind() == io::ErrorKind::NotFound && open_fitting(out, &sidecar_path(out)).is_ok() =>
        {
            Ok(())
        }
        renamed => renamed,
    }
}

/// Removes what an interrupted commit left, where the pyramid is whole without it.
pub fn tidy(out: &Path) {
    if open_fitting(out, &sidecar_path(out)).is_ok() {
        let _ = fs::remove_file(next_path(out));
    }
}
