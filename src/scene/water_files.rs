//! `[water]` of a scene: files that mark water. [`crate::world::given_water`] reads them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

/// Files that mark water, in addition to the water that is found in the heights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WaterFiles {
    /// A raster; non-zero values are water.
    pub mask: Option<PathBuf>,
    /// A GeoJSON file with polygons.
    pub polygons: Option<PathBuf>,
    /// Whether only these files count, and level areas in the heights are not water.
    pub only_given: bool,
}

/// Extensions of polygon files.
const POLYGON_ENDINGS: [&str; 2] = ["geojson", "json"];

impl WaterFiles {
    /// Returns the files, each with its key in the scene file.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&'static str, &PathBuf)> {
        let all = [("water.mask", &self.mask), ("water.polygons", &self.polygons)];
        all.into_iter().filter_map(|(key, file)| Some((key, file.as_ref()?)))
    }

    /// Returns these files with another one, which replaces that of the same kind: polygons or a mask, by its
    /// extension.
    #[must_use]
    pub fn with(mut self, file: &Path) -> Self {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let is_polygons = ending.is_some_and(|ending| POLYGON_ENDINGS.contains(&ending.as_str()));
        *(if is_polygons { &mut self.polygons } else { &mut self.mask }) = Some(file.to_owned());
        self
    }
}

/// `[water]` of a scene file.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct WaterToml {
    pub(super) sea_level_m: Option<f64>,
    polygons: Option<String>,
    mask: Option<String>,
    #[serde(default)]
    only_given: bool,
}

impl WaterToml {
    /// Validates the section and returns its files; the error is the key and what is wrong with it.
    pub(super) fn files(&self, scene: &Path) -> Result<WaterFiles, (&'static str, &'static str)> {
        let file = |key: &'static str, name: &Option<String>| match name.as_deref() {
            None => Ok(None),
            Some("") => Err((key, "it is empty")),
            Some(name) if name.contains("://") => Err((key, "it must be a local file, not a URL")),
            Some(name) => Ok(Some(scene.parent().unwrap_or(Path::new("")).join(name))),
        };
        let mask = file("water.mask", &self.mask)?;
        let polygons = file("water.polygons", &self.polygons)?;
        if self.only_given && mask.is_none() && polygons.is_none() {
            return Err(("water.only_given", "it needs water.mask or water.polygons"));
        }
        Ok(WaterFiles { mask, polygons, only_given: self.only_given })
    }
}
