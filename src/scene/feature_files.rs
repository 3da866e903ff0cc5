//! `[[features]]` of a scene: files of points, lines and areas. [`crate::draped`] reads them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

/// A file of features that are drawn on the land.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureFile {
    /// A GeoJSON, GPX, CSV, GeoPackage or FlatGeobuf file.
    pub path: PathBuf,
    /// The layer of the file; `None` reads all of its layers.
    pub layer: Option<String>,
}

/// An entry of `[[features]]` of a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FeatureToml {
    file: String,
    layer: Option<String>,
}

impl FeatureToml {
    /// Returns the file of an entry of the scene file `scene`; the error is the key and what is wrong with it.
    pub(super) fn file(&self, scene: &Path) -> Result<FeatureFile, (&'static str, &'static str)> {
        match self.file.as_str() {
            "" => Err(("features.file", "it is empty")),
            name if name.contains("://") => Err(("features.file", "it must be a local file, not a URL")),
            name => Ok(FeatureFile {
                path: scene.parent().unwrap_or(Path::new("")).join(name),
                layer: self.layer.clone(),
            }),
        }
    }
}
