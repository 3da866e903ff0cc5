//! Options of all commands that read heights: what is said of files that do not say it themselves.

use clap::Args;

use super::arguments;
use crate::scene::Scene;
use crate::source::{Encoding, OpenOptions, VoidMode};

/// What height files leave open.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct HeightArgs {
    /// How heights are packed into the colours of a terrain-RGB picture or tile folder: mapbox or terrarium
    #[arg(long, hide_possible_values = true)]
    pub encoding: Option<Encoding>,
    /// Heights that are voids, in metres, beside those that the DEM declares
    #[arg(long, value_name = "METRES", value_parser = arguments::number, allow_hyphen_values = true)]
    pub nodata: Option<f64>,
    /// What is done with voids: fill closes small holes smoothly, holes leaves them as they are [default: fill]
    #[arg(long, value_name = "MODE")]
    pub voids: Option<VoidMode>,
}

impl HeightArgs {
    /// For the readers.
    #[must_use]
    pub fn options(&self) -> OpenOptions {
        let voids = self.voids.unwrap_or(VoidMode::Fill);
        OpenOptions { encoding: self.encoding, no_data: self.nodata, voids, ..OpenOptions::default() }
    }

    /// The scene with what the command line says of its heights; where that says nothing, what the scene says stays.
    #[must_use]
    pub fn over(&self, mut scene: Scene) -> Scene {
        scene.heights.encoding = self.encoding.or(scene.heights.encoding);
        scene.heights.no_data = self.nodata.or(scene.heights.no_data);
        scene.heights.voids = self.voids.unwrap_or(scene.heights.voids);
        scene
    }
}
