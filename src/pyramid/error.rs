//! What can go wrong between a height grid and its pyramid.

use std::io;
use std::path::{Path, PathBuf};

use crate::file::message::{chain, named, printable};
use crate::pyramid::tile::TileAddress;
use crate::remote::RemoteError;
use crate::source::SourceError;

/// Why a pyramid could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum PyramidError {
    /// The grid's fields contradict one another, or it is too small.
    #[error("{}: {cause}", named(path))]
    BadGrid {
        /// The file that was to be baked.
        path: PathBuf,
        /// What is wrong with the grid.
        cause: String,
    },
    /// Not one sample has a height.
    #[error("{}: no sample has a height; all are void", named(path))]
    NoHeights {
        /// The file that was to be baked.
        path: PathBuf,
    },
    /// The system refused to read or write a file.
    #[error("{}: {what}: {source}", named(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done.
        what: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// A block could not be compressed or the container not written.
    #[error("{}: the GeoTIFF could not be written: {}", named(path), chain(source.as_ref()))]
    Encode {
        /// The GeoTIFF.
        path: PathBuf,
        /// The encoder's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The GeoTIFF is damaged, or not one of ours.
    #[error("{}: the GeoTIFF could not be read: {}", named(path), chain(source.as_ref()))]
    Decode {
        /// The GeoTIFF.
        path: PathBuf,
        /// The decoder's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The GeoTIFF does not have the levels that its sidecar describes, or what was read back is not what was written.
    #[error("{}: {cause}", named(path))]
    Mismatch {
        /// The GeoTIFF.
        path: PathBuf,
        /// What differs, as a sentence's end.
        cause: String,
    },
    /// There is no file of tile statistics beside the GeoTIFF: bake it first.
    #[error("{}: there are no tile statistics beside it ({})", named(path), named(sidecar))]
    NoSidecar {
        /// The GeoTIFF.
        path: PathBuf,
        /// Where its statistics would be.
        sidecar: PathBuf,
    },
    /// The tile statistics belong to another version of the GeoTIFF, or of hachure: bake again.
    #[error("{}: stale tile statistics: {cause}", named(path))]
    StaleSidecar {
        /// The sidecar.
        path: PathBuf,
        /// What does not fit.
        cause: String,
    },
    /// The file of tile statistics is damaged: bake again.
    #[error("{}: damaged tile statistics: {cause}", named(path))]
    CorruptSidecar {
        /// The sidecar.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// There is no such tile.
    #[error("{}: there is no tile {} {} {} (level, x, y)", named(path), address.level, address.x, address.y)]
    NoSuchTile {
        /// The pyramid that was asked.
        path: PathBuf,
        /// The tile asked for.
        address: TileAddress,
    },
    /// The folder of cached pyramids cannot be written.
    #[error(
        "{}: the cache cannot be written: {}; HACHURE_CACHE names another folder",
        named(folder), chain(source.as_ref())
    )]
    Cache {
        /// The folder of the cache.
        folder: PathBuf,
        /// The system's reason, or the encoder's.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The system names no folder for caches.
    #[error("no folder for baked terrain: set HACHURE_CACHE")]
    NoCacheFolder,
    /// The file has too few overviews to fly over it as it is.
    #[error("{}: {cause}; bake it first, where it lies: hachure bake FILE -o OUT.tif", named(path))]
    NoOverviews {
        /// The file or its address.
        path: PathBuf,
        /// What is missing.
        cause: String,
    },
    /// A server sent bytes that cannot be, as often as it was asked.
    #[error("{}: the server sends damaged bytes for {what}: {}", named(path), printable(cause, 180))]
    Sent {
        /// The address of the file.
        path: PathBuf,
        /// What they were to be.
        what: String,
        /// What is wrong with them.
        cause: String,
    },
    /// The file, here or elsewhere, could not be had.
    #[error(transparent)]
    Remote(RemoteError),
    /// Its bytes could not be had while they were decoded: the words of the source, which name the file.
    #[error(transparent)]
    Unread {
        /// The source's words.
        source: SourceError,
    },
    /// It is no height file that can be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// Nobody wants the tile any more.
    #[error("no longer wanted")]
    Cancelled,
    /// The bake was told to stop.
    #[error("stopped")]
    Stopped,
    /// The work folder of a bake holds something else.
    #[error("{}: {cause}", named(path))]
    Parts {
        /// The work folder.
        path: PathBuf,
        /// Why it cannot be used, as a sentence's end.
        cause: String,
    },
    /// The heights to bake could not be had: the loader's own words, which name the file.
    #[error(transparent)]
    Load(Box<dyn std::error::Error + Send + Sync>),
}

impl From<RemoteError> for PyramidError {
    fn from(error: RemoteError) -> Self {
        if matches!(error, RemoteError::Cancelled) { Self::Cancelled } else { Self::Remote(error) }
    }
}

impl PyramidError {
    /// Whether baking anew would cure it.
    pub fn wants_bake(&self) -> bool {
        matches!(
            self,
            Self::NoSidecar { .. }
                | Self::StaleSidecar { .. }
                | Self::CorruptSidecar { .. }
                | Self::Mismatch { .. }
                | Self::Decode { .. }
        )
    }

    /// Whether it is no use to ask again at once: whoever read it has tried for as long as it makes sense.
    pub fn is_final(&self) -> bool {
        match self {
            Self::Remote(error) => error.is_final(),
            Self::Unread { .. } => true,
            _ => false,
        }
    }

    /// The same where the bytes came from a server: the file may be whole.
    pub(super) fn sent(self, path: &Path, what: &str) -> Self {
        let mut cause: &dyn std::error::Error = &self;
        while let Some(inner) = cause.source() {
            cause = inner;
        }
        let cause = crate::file::one_line(&cause.to_string());
        let cause = cause.trim_start_matches(&format!("{}: ", path.display())).to_owned();
        Self::Sent { path: path.to_owned(), what: what.to_owned(), cause }
    }

    /// The error with its causes, in one line.
    pub fn told(&self) -> String {
        crate::file::one_line(&chain(self))
    }

    pub(super) fn io(path: &Path, what: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), what, source }
    }

    pub(super) fn encode<E: Into<Box<dyn std::error::Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Self {
        move |source| Self::Encode { path: path.to_owned(), source: source.into() }
    }

    pub(super) fn decode<E: Into<Box<dyn std::error::Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Self {
        move |source| Self::Decode { path: path.to_owned(), source: source.into() }
    }
}
