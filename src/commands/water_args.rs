//! Options of all commands that draw, for water that the heights do not show.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use crate::file::message::named;
use crate::scene::Scene;

/// Where additional water is.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct WaterArgs {
    /// Water besides level land: GeoJSON polygons (.geojson), or a raster whose non-zero samples are water; replaces
    /// the scene's polygons or mask
    #[arg(long, value_name = "FILE")]
    pub water: Option<PathBuf>,
}

impl WaterArgs {
    /// Checks that the file exists, so that the error comes before a world is opened.
    ///
    /// # Errors
    /// Fails if there is no such file.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        match &self.water {
            // A file that may not be looked at is reported when it is opened.
            Some(file) if !file.try_exists().unwrap_or(true) => bail!("{}: there is no such file", named(file)),
            _ => Ok(()),
        }
    }

    /// Returns the scene with this water; if the option is not given, the scene's water stays.
    #[must_use]
    pub(crate) fn apply_to(&self, mut scene: Scene) -> Scene {
        if let Some(file) = &self.water {
            scene.water = std::mem::take(&mut scene.water).with(file);
        }
        scene
    }
}
