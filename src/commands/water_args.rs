//! Options of all commands that draw, for water that the heights do not show.

use std::path::PathBuf;

use clap::Args;

use crate::scene::Scene;

/// Where additional water is.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct WaterArgs {
    /// Additional water, instead of the scene's: GeoJSON polygons (.geojson), or a raster whose non-zero samples are
    /// water
    #[arg(long, value_name = "FILE")]
    pub water: Option<PathBuf>,
}

impl WaterArgs {
    /// Returns the scene with this water; if the option is not given, the scene's water stays.
    #[must_use]
    pub(crate) fn over(&self, mut scene: Scene) -> Scene {
        if let Some(file) = &self.water {
            scene.water = std::mem::take(&mut scene.water).with(file);
        }
        scene
    }
}
