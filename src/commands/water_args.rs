//! Options of all commands that draw: water beside what the heights show.

use std::path::PathBuf;

use clap::Args;

use crate::scene::Scene;

/// Where water is.
#[derive(Clone, Debug, Default, Args)]
pub struct WaterArgs {
    /// Water beside what the heights show, in place of what the scene gives: GeoJSON polygons (.geojson), or a raster of
    /// which all but 0 is water
    #[arg(long, value_name = "FILE")]
    pub water: Option<PathBuf>,
}

impl WaterArgs {
    /// The scene with what the command line says of its water; where that says nothing, what the scene says stays.
    #[must_use]
    pub fn over(&self, mut scene: Scene) -> Scene {
        if let Some(file) = &self.water {
            scene.water = std::mem::take(&mut scene.water).with(file);
        }
        scene
    }
}
