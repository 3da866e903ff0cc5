//! The errors that can occur between a height grid and its pyramid.

use std::io;
use std::path::{Path, PathBuf};

use crate::file::message::{chain, named, printable};
use crate::pyramid::tile::TileAddress;
use crate::remote::RemoteError;
use crate::source::SourceError;

/// The reason why a pyramid could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum PyramidError {
    /// The grid's fields contradict one another, or the grid is too small.
    #[error("{}: {cause}", named(path))]
    BadGrid {
        /// The file that was to be baked, or the name of heights in memory.
        path: PathBuf,
        /// The problem with the grid.
        cause: String,
    },
    /// No sample has a height.
    #[error("{}: every sample is no-data; there are no heights to draw", named(path))]
    NoHeights {
        /// The file that was to be baked.
        path: PathBuf,
    },
    /// The operating system refused to read or write a file.
    #[error("{}: {what}: {source}", named(path))]
    Io {
        path: PathBuf,
        /// The operation that failed, as a gerund: "writing", "reading a tile".
        what: &'static str,
        /// The operating system's reason.
        source: io::Error,
    },
    /// A tile could not be compressed, or the GeoTIFF not assembled.
    #[error("{}: cannot write the GeoTIFF: {}", named(path), chain(source.as_ref()))]
    Encode {
        path: PathBuf,
        /// The encoder's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The GeoTIFF is damaged, or another program wrote it.
    #[error("{}: cannot read the GeoTIFF: {}", named(path), chain(source.as_ref()))]
    Decode {
        path: PathBuf,
        /// The decoder's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The GeoTIFF does not have the levels that its sidecar describes, or reading back gave other heights than were
    /// written.
    #[error("{}: {cause}", named(path))]
    Mismatch {
        path: PathBuf,
        /// The difference, as the end of a sentence.
        cause: String,
    },
    /// The GeoTIFF has no sidecar file with tile statistics: it has to be baked first.
    #[error("{}: its tile statistics are missing ({}); bake it again", named(path), named(sidecar))]
    NoSidecar {
        path: PathBuf,
        /// The path where the sidecar was expected.
        sidecar: PathBuf,
    },
    /// The tile statistics belong to another version of the GeoTIFF, or of hachure: it has to be baked again.
    #[error("{}: outdated tile statistics: {cause}; bake it again", named(path))]
    StaleSidecar {
        /// Path of the sidecar file.
        path: PathBuf,
        /// The reason, as a sentence.
        cause: String,
    },
    /// The sidecar is damaged: the pyramid has to be baked again.
    #[error("{}: damaged tile statistics: {cause}; bake it again", named(path))]
    CorruptSidecar {
        /// Path of the sidecar file.
        path: PathBuf,
        /// The damage, as a sentence.
        cause: String,
    },
    /// The pyramid has no tile with this address.
    #[error("{}: no tile {} {} {} (level, x, y)", named(path), address.level, address.x, address.y)]
    NoSuchTile {
        /// The pyramid that was read.
        path: PathBuf,
        /// The requested tile.
        address: TileAddress,
    },
    /// The cache folder of baked pyramids cannot be written.
    #[error(
        "{}: cannot write the cache: {}; set HACHURE_CACHE to use another folder",
        named(folder), chain(source.as_ref())
    )]
    Cache {
        /// The cache folder.
        folder: PathBuf,
        /// The reason of the operating system or of the encoder.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The operating system names no folder for caches.
    #[error("found no cache folder for baked terrain; set HACHURE_CACHE to a folder")]
    NoCacheFolder,
    /// The file has too few overviews to be drawn without baking.
    #[error("{}: {cause}; bake it first, where the file is stored: hachure bake FILE -o OUT.tif", named(path))]
    NoOverviews {
        /// The path or URL of the file.
        path: PathBuf,
        /// The missing part, as a sentence.
        cause: String,
    },
    /// A server sent damaged bytes at every attempt.
    #[error("{}: the server sent damaged data for {what}: {}", named(path), printable(cause, 180))]
    Sent {
        /// The URL of the file.
        path: PathBuf,
        /// The content of the bytes, for example "tile 0 3 4".
        what: String,
        /// The damage, as a clause.
        cause: String,
    },
    /// Reading the file, local or remote, failed.
    #[error(transparent)]
    Remote(RemoteError),
    /// Reading bytes failed while they were decoded. The message of the source names the file.
    #[error(transparent)]
    Unread {
        /// The source's error.
        source: SourceError,
    },
    /// The file cannot be read as heights.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The request for the tile was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// The bake was stopped.
    #[error("stopped")]
    Stopped,
    /// The work folder of a bake cannot be used.
    #[error("{}: {cause}", named(path))]
    Parts {
        /// The work folder.
        path: PathBuf,
        /// The reason, as the end of a sentence.
        cause: String,
    },
    /// Reading the heights to bake failed. The message of the loader names the file.
    #[error(transparent)]
    Load(Box<dyn std::error::Error + Send + Sync>),
}

impl From<RemoteError> for PyramidError {
    fn from(error: RemoteError) -> Self {
        if matches!(error, RemoteError::Cancelled) { Self::Cancelled } else { Self::Remote(error) }
    }
}

impl PyramidError {
    /// Returns whether baking again would cure the error.
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

    /// Returns whether trying again at once is pointless, because the reader has already made all sensible attempts.
    pub(crate) fn is_final(&self) -> bool {
        match self {
            Self::Remote(error) => error.is_final(),
            Self::Unread { .. } => true,
            _ => false,
        }
    }

    /// Converts an error about bytes from a server: the file on the server may be intact.
    pub(super) fn sent(self, path: &Path, what: &str) -> Self {
        let mut cause: &dyn std::error::Error = &self;
        while let Some(inner) = cause.source() {
            cause = inner;
        }
        let cause = crate::file::one_line(&cause.to_string());
        let cause = cause.trim_start_matches(&format!("{}: ", path.display())).to_owned();
        Self::Sent { path: path.to_owned(), what: what.to_owned(), cause }
    }

    /// Returns the error with its causes, in one line.
    pub(crate) fn message(&self) -> String {
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
