//! From an address to a store of tiles: files that are flown over as they are.

use std::path::Path;
use std::sync::Arc;

use super::cache::cache_folder;
use super::cog_store::CogStore;
use super::tile_store::TileStore;
use crate::pyramid::error::PyramidError;
use crate::remote::{RemoteError, RemoteFile, Settings, beside};
use crate::source::VoidMode;
use crate::source::tiff_side_files::need_side_files;

/// Decoded blocks kept, shared by all threads: 48 tiles of 512 × 512 f32.
const DECODED_BYTES: usize = 48 << 20;

/// The subfolder of the cache folder for blocks of files on other machines.
const REMOTE_FOLDER: &str = "remote";

/// Opens the COG at `url`: `http://`, `https://`, or `s3://bucket/key` with what the `AWS_*` variables say. Blocks of
/// it are kept in the cache folder. If it is a baked pyramid with its sidecar beside it, its errors are the measured
/// ones.
///
/// # Errors
/// [`PyramidError::Remote`] if it cannot be had, [`PyramidError::NoOverviews`] if it must be baked first, or why it is
/// no height file.
pub fn open_remote(url: &str, voids: VoidMode) -> Result<Arc<dyn TileStore>, PyramidError> {
    // Without a folder there is no cache on disk, and flying goes on.
    let cache = cache_folder(None).ok().map(|folder| folder.join(REMOTE_FOLDER));
    open_remote_as(url, Settings { cache, ..Settings::default() }, DECODED_BYTES, voids).map(|store| store as _)
}

/// The same with settings of one's own, where about `decoded_bytes` of decoded blocks are kept, and with the file's voids.
///
/// # Errors
/// As [`open_remote`].
pub fn open_remote_with(url: &str, settings: Settings, decoded_bytes: usize) -> Result<Arc<CogStore>, PyramidError> {
    open_remote_as(url, settings, decoded_bytes, VoidMode::Holes)
}

fn open_remote_as(
    url: &str,
    settings: Settings,
    decoded_bytes: usize,
    voids: VoidMode,
) -> Result<Arc<CogStore>, PyramidError> {
    let file = RemoteFile::open(url, settings.clone())?;
    let sidecar = match file.open_beside(&beside(url, ".tiles"), settings) {
        Ok(sidecar) => Some(sidecar),
        Err(error) if error.is_absent() => None,
        Err(error) => return Err(error.into()),
    };
    CogStore::open(file, sidecar, decoded_bytes, voids).map(Arc::new)
}

/// Opens the GeoTIFF at `path` to fly over it as it is, with estimated errors. None if it is not fit for that (no COG,
/// no overviews, damaged, or no height file at all): whoever bakes it will say what is wrong. A baked pyramid is not
/// looked at as such; see [`Pyramid::open`](super::pyramid::Pyramid::open).
///
/// # Errors
/// If the file is not there or cannot be read.
pub fn open_local_cog(path: &Path) -> Result<Option<Arc<dyn TileStore>>, PyramidError> {
    open_local_cog_with(path, VoidMode::Holes)
}

/// The same, with small holes filled or not.
///
/// # Errors
/// As [`open_local_cog`].
pub fn open_local_cog_with(path: &Path, voids: VoidMode) -> Result<Option<Arc<dyn TileStore>>, PyramidError> {
    let io = |source| PyramidError::Io { path: path.to_owned(), what: "opening", source };
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Ok(None);
    }
    if need_side_files(path) {
        return Ok(None);
    }
    // A path that is no Unicode is rare, and such a file can still be baked.
    let Some(location) = path.to_str().filter(|location| !location.contains("://")) else { return Ok(None) };
    let opened = RemoteFile::open(location, Settings::default())
        .map_err(PyramidError::from)
        .and_then(|file| CogStore::open(file, None, DECODED_BYTES, voids));
    match opened {
        Ok(store) => Ok(Some(Arc::new(store))),
        Err(error @ (PyramidError::Remote(RemoteError::Io { .. }) | PyramidError::Unread { .. })) => Err(error),
        Err(error) => {
            tracing::debug!("{error}: not flown over as it is");
            Ok(None)
        }
    }
}
