//! `[[images]]` of a scene: images that are draped on the land. [`crate::imagery`] reads them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

/// An image on the land.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageFile {
    /// A GeoTIFF, PNG, WebP or JPEG file.
    pub path: PathBuf,
}

/// An entry of `[[images]]` of a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ImageToml {
    file: String,
}

impl ImageToml {
    /// Returns the file of an entry of the scene file `scene`; the error is the key and what is wrong with it.
    pub(super) fn file(&self, scene: &Path) -> Result<ImageFile, (&'static str, &'static str)> {
        match self.file.as_str() {
            "" => Err(("images.file", "it is empty")),
            name if name.contains("://") => Err(("images.file", "it must be a local file, not a URL")),
            name => Ok(ImageFile { path: scene.parent().unwrap_or(Path::new("")).join(name) }),
        }
    }
}
