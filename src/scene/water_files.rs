//! `[water]` of a scene: files that say where water is. [`crate::world::given_water`] reads them.

use std::path::{Path, PathBuf};

/// Files that say where water is, beside what heights show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WaterFiles {
    /// A raster: what is not 0 is water.
    pub mask: Option<PathBuf>,
    /// Polygons as GeoJSON.
    pub polygons: Option<PathBuf>,
    /// Whether what heights show is no water.
    pub only_given: bool,
}

/// Files whose names end so are polygons.
const POLYGON_ENDINGS: [&str; 2] = ["geojson", "json"];

impl WaterFiles {
    /// The files, each with its key in the scene file.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &PathBuf)> {
        let all = [("water.mask", &self.mask), ("water.polygons", &self.polygons)];
        all.into_iter().filter_map(|(key, file)| Some((key, file.as_ref()?)))
    }

    /// With another file, which comes before that of the same kind: polygons or a mask, by its name.
    #[must_use]
    pub fn with(mut self, file: &Path) -> Self {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let is_polygons = ending.is_some_and(|ending| POLYGON_ENDINGS.contains(&ending.as_str()));
        *(if is_polygons { &mut self.polygons } else { &mut self.mask }) = Some(file.to_owned());
        self
    }
}
