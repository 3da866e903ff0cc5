//! Opening COGs, local or remote, as stores of tiles without baking them.

use std::path::Path;
use std::sync::{Arc, Once};

use super::cache::cache_folder;
use super::cog_store::CogStore;
use super::tile_store::TileStore;
use crate::pyramid::error::PyramidError;
use crate::remote::{RemoteError, RemoteFile, Settings, sidecar_url};
use crate::source::VoidMode;
use crate::source::tiff_sidecars::needs_sidecars;

/// Bytes of cached decoded blocks, shared by all threads: 48 tiles of 512 × 512 f32.
const DECODED_BYTES: usize = 48 << 20;

/// The subfolder of the cache folder for blocks of remote files.
const REMOTE_FOLDER: &str = "remote";

/// Opens the COG at `url`: `http://`, `https://`, or `s3://bucket/key` with the credentials of the `AWS_*` environment
/// variables. Blocks of it are stored in the cache folder. If it is a baked pyramid with its sidecar, its measured
/// errors are used.
///
/// # Errors
/// [`PyramidError::Remote`] if reading fails, [`PyramidError::NoOverviews`] if it must be baked first, or the reason
/// why it cannot be read as heights.
pub fn open_remote(url: &str, voids: VoidMode) -> Result<Arc<dyn TileStore>, PyramidError> {
    // Without a cache folder, nothing is cached on disk; everything else works.
    static WARNED: Once = Once::new();
    let warn =
        |error: &PyramidError| WARNED.call_once(|| tracing::warn!("{error}; blocks of remote files are not cached"));
    let cache = cache_folder(None).inspect_err(warn).ok().map(|folder| folder.join(REMOTE_FOLDER));
    open_remote_as(url, Settings { cache, ..Settings::default() }, DECODED_BYTES, voids).map(|store| store as _)
}

/// Like [`open_remote`] with other settings: about `decoded_bytes` of decoded blocks are cached, and small holes are
/// not filled.
///
/// # Errors
/// The errors of [`open_remote`].
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
    let sidecar = match file.open_sidecar(&sidecar_url(url, ".tiles"), settings) {
        Ok(sidecar) => Some(sidecar),
        Err(error) if error.is_absent() => None,
        Err(error) => return Err(error.into()),
    };
    CogStore::open(file, sidecar, decoded_bytes, voids).map(Arc::new)
}

/// Opens the GeoTIFF at `path` directly, with estimated errors. Returns `None` if the file does not suit that (not a
/// COG, no overviews, damaged, or not a height file at all); baking it will report the reason. The sidecar of a baked
/// pyramid is ignored; see [`Pyramid::open`](super::pyramid::Pyramid::open).
///
/// # Errors
/// If the file does not exist or cannot be read.
pub fn open_local_cog(path: &Path) -> Result<Option<Arc<dyn TileStore>>, PyramidError> {
    open_local_cog_with(path, VoidMode::Holes)
}

/// Like [`open_local_cog`], with or without filling small holes.
///
/// # Errors
/// The errors of [`open_local_cog`].
pub(crate) fn open_local_cog_with(path: &Path, voids: VoidMode) -> Result<Option<Arc<dyn TileStore>>, PyramidError> {
    let io = |source| PyramidError::Io { path: path.to_owned(), what: "opening", source };
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Ok(None);
    }
    if needs_sidecars(path) {
        return Ok(None);
    }
    // A path that is not Unicode is rare, and such a file can still be baked.
    let Some(location) = path.to_str().filter(|location| !location.contains("://")) else { return Ok(None) };
    let opened = RemoteFile::open(location, Settings::default())
        .map_err(PyramidError::from)
        .and_then(|file| CogStore::open(file, None, DECODED_BYTES, voids));
    match opened {
        Ok(store) => Ok(Some(Arc::new(store))),
        Err(error @ (PyramidError::Remote(RemoteError::Io { .. }) | PyramidError::Unread { .. })) => Err(error),
        Err(error) => {
            tracing::debug!("{error}: this file has to be baked first");
            Ok(None)
        }
    }
}
