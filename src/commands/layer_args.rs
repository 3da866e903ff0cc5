//! Options of all commands that draw, for features, lines of coordinates and images on the land.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::bail;
use clap::Args;

use crate::file::message::named;
use crate::scene::{FeatureFile, Graticule, ImageFile, Scene};

/// Which features and images are drawn on the land.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LayerArgs {
    /// Draw the points, lines and areas of this file on the land: GeoJSON, GPX, CSV with coordinates, GeoPackage
    /// or FlatGeobuf, in any reference system. All layers of the file are drawn; `--set features.file=LAYER` draws one.
    /// May be repeated, and adds to the files of the scene. `--set features.ink=#204080` and other values of that layer
    /// of the style say how features look
    #[arg(long, value_name = "FILE")]
    pub layer: Vec<PathBuf>,
    /// Draw meridians and parallels on the land, this far apart in degrees (0.1, 6' or 30"), or the lines of the grid of
    /// the heights' projection (1000m or 1km)
    #[arg(long, value_name = "STEP", value_parser = Graticule::from_str)]
    pub graticule: Option<Graticule>,
    /// Drape this image on the land: an orthophoto, a scanned map or another raster as GeoTIFF, PNG, JPEG or lossless WebP,
    /// in any reference system. The style says how much it colours and darkens the tones (`image.color`, `image.tone`);
    /// ink styles, also the default, show no colour unless you add `--set image.color=1`. May be repeated: each image
    /// covers those before it, and those of the scene
    #[arg(long, value_name = "FILE")]
    pub drape: Vec<PathBuf>,
}

impl LayerArgs {
    /// Checks that the files exist, so that the error comes before a world is opened.
    ///
    /// # Errors
    /// Fails for the first file that does not exist.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        // A file that may not be looked at is reported when it is opened.
        match self.layer.iter().chain(&self.drape).find(|file| !file.try_exists().unwrap_or(true)) {
            Some(file) => bail!("{}: there is no such file", named(file)),
            None => Ok(()),
        }
    }

    /// Returns the scene with these features and images after its own, and with this graticule instead of its own.
    #[must_use]
    pub(crate) fn apply_to(&self, mut scene: Scene) -> Scene {
        scene.graticule = self.graticule.or(scene.graticule);
        scene.features.extend(self.layer.iter().map(|path| FeatureFile { path: path.clone(), layer: None }));
        scene.images.extend(self.drape.iter().map(|path| ImageFile { path: path.clone() }));
        scene
    }
}
