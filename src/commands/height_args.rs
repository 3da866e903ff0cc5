//! Options of all commands that read heights, for what the files do not say themselves.

use clap::Args;

use super::arguments;
use crate::scene::{Scene, ranges};
use crate::source::{Encoding, OpenOptions, VoidMode};

/// How to read height files.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct HeightArgs {
    /// How a terrain-RGB picture, or a folder of terrain-RGB tiles, encodes heights as colours: mapbox or terrarium
    #[arg(long, hide_possible_values = true)]
    pub encoding: Option<Encoding>,
    /// Additional no-data value, besides those that the DEM declares: a height in metres, after scale, offset and unit
    #[arg(long, value_name = "METRES", value_parser = arguments::within(ranges::NO_DATA_M), allow_hyphen_values = true)]
    pub nodata: Option<f64>,
    /// Treatment of no-data: fill closes small holes smoothly, holes leaves them open [default: fill]
    #[arg(long, value_name = "MODE")]
    pub voids: Option<VoidMode>,
}

impl HeightArgs {
    /// Returns the options for the height readers.
    #[must_use]
    pub(crate) fn options(&self) -> OpenOptions {
        let voids = self.voids.unwrap_or(VoidMode::Fill);
        OpenOptions { encoding: self.encoding, no_data: self.nodata, voids, ..OpenOptions::default() }
    }

    /// Returns the scene with these options; options that are not given keep the scene's values.
    #[must_use]
    pub(crate) fn over(&self, mut scene: Scene) -> Scene {
        scene.heights.encoding = self.encoding.or(scene.heights.encoding);
        scene.heights.no_data = self.nodata.or(scene.heights.no_data);
        scene.heights.voids = self.voids.unwrap_or(scene.heights.voids);
        scene
    }
}
