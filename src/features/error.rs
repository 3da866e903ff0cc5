//! The errors of reading layers of features.

use std::io;
use std::path::{Path, PathBuf};

use crate::file::message::{brief, named, printable, quoted};

/// Largest number of characters of a cause.
const LONGEST_CAUSE: usize = 400;
/// Largest number of names in a list of layers.
const MOST_NAMES: usize = 12;

/// The reason why a layer of features cannot be read. The message is one line that names the file and the cause;
/// `source()` returns the cause as a value where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FeatureError {
    /// The file system refused to open or to read the file, or one feature of it is too large.
    #[error("{}: cannot be read: {source}", named(path))]
    Read {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    /// The file has zero bytes, or only blanks.
    #[error("{}: is empty", named(path))]
    Empty { path: PathBuf },
    /// The file has none of the formats that are read here.
    #[error("{}: {looks_like}; hachure reads features from GeoJSON, GPX, CSV, GeoPackage and FlatGeobuf", named(path))]
    UnknownFormat {
        path: PathBuf,
        /// The format that the file appears to have, for example "is a ZIP archive; unpack it".
        looks_like: String,
    },
    /// The file contradicts its format, ends too early, or lacks something.
    #[error("{}: {cause}", named(path))]
    Content {
        path: PathBuf,
        /// The cause, as a clause that follows the name of the file.
        cause: String,
    },
    /// The choice of the layer is not clear.
    #[error("{}: {}", named(path), layers_text(wanted.as_deref(), layers))]
    Layers {
        path: PathBuf,
        /// The name that was asked for.
        wanted: Option<String>,
        /// The layers of the file.
        layers: Vec<String>,
    },
}

impl FeatureError {
    /// Returns the layers of a file from which one has to be chosen; none for other errors.
    pub(crate) fn layers(&self) -> &[String] {
        match self {
            Self::Layers { wanted: None, layers, .. } => layers,
            _ => &[],
        }
    }
}

/// An error before the name of the file is added.
#[derive(Debug)]
pub(super) enum Cause {
    Read(io::Error),
    Empty,
    UnknownFormat(String),
    Content(String),
    Layers { wanted: Option<String>, layers: Vec<String> },
}

impl Cause {
    /// Creates an error with a cause that follows the name of the file.
    pub(super) fn content(cause: impl Into<String>) -> Self {
        Self::Content(cause.into())
    }

    /// Adds the name of the file.
    pub(super) fn of(self, path: &Path) -> FeatureError {
        let path = path.to_owned();
        match self {
            Self::Read(source) => FeatureError::Read { path, source },
            Self::Empty => FeatureError::Empty { path },
            Self::UnknownFormat(looks_like) => {
                FeatureError::UnknownFormat { path, looks_like: printable(&looks_like, LONGEST_CAUSE) }
            }
            Self::Content(cause) => FeatureError::Content { path, cause: printable(&cause, LONGEST_CAUSE) },
            Self::Layers { wanted, layers } => FeatureError::Layers { path, wanted, layers },
        }
    }
}

impl From<io::Error> for Cause {
    fn from(error: io::Error) -> Self {
        Self::Read(error)
    }
}

/// Returns names as a list for a message.
pub(super) fn list(names: &[String]) -> String {
    let shown: Vec<String> = names.iter().take(MOST_NAMES).map(|name| brief(name)).collect();
    let more = names.len().saturating_sub(MOST_NAMES);
    match more {
        0 => shown.join(", "),
        _ => format!("{} and {more} more", shown.join(", ")),
    }
}

fn layers_text(wanted: Option<&str>, layers: &[String]) -> String {
    match (wanted, layers) {
        (Some(wanted), [only]) => format!("has no layer {}; its only layer is {}", quoted(wanted), quoted(only)),
        (Some(wanted), _) => format!("has no layer {}; its layers are {}", quoted(wanted), list(layers)),
        (None, _) => format!("has {} layers; choose one with --name-layer: {}", layers.len(), list(layers)),
    }
}
