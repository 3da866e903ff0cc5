//! Options of all commands that read heights, for what the files do not say themselves.

use clap::Args;

use super::arguments;
use crate::scene::{Scene, ranges};
use crate::source::{Encoding, HeightUnit, OpenOptions, TileRows, VoidMode};

/// How to read height files.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct HeightArgs {
    /// How a terrain-RGB picture, or tiles of terrain-RGB, encode heights as colours: mapbox, terrarium or gsi
    #[arg(long, hide_possible_values = true)]
    pub encoding: Option<Encoding>,
    /// Metres per step of a heightmap (16-bit PNG, raw) or of a colour code (mapbox, gsi) [default: from its
    /// NAME.ext.toml; else 1, or that of the encoding]
    #[arg(long, value_name = "METRES", value_parser = arguments::within(ranges::HEIGHT_SCALE_M), allow_hyphen_values = true)]
    pub height_scale: Option<f64>,
    /// Height of the value 0 of a heightmap or of a colour code, in metres [default: from its NAME.ext.toml; else 0, or
    /// that of the encoding]
    #[arg(long, value_name = "METRES", value_parser = arguments::within(ranges::HEIGHT_OFFSET_M), allow_hyphen_values = true)]
    pub height_offset: Option<f64>,
    /// Unit of the heights of a DEM that declares none: m, ft or us-ft. A DEM that declares metres is converted all the
    /// same, with a warning; one that declares another unit is refused [default: m]
    #[arg(long, value_name = "UNIT", hide_possible_values = true)]
    pub height_unit: Option<HeightUnit>,
    /// Direction of the rows of web map tiles: xyz counts from the north, tms from the south [default: as sidecar
    /// files say, or as tile edges match]
    #[arg(long, value_name = "ROWS", hide_possible_values = true)]
    pub tile_rows: Option<TileRows>,
    /// Additional no-data value, besides those that the DEM declares: a height in metres, after scale and offset, or in
    /// the unit of --height-unit
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
        OpenOptions {
            encoding: self.encoding,
            height_scale_m: self.height_scale,
            height_offset_m: self.height_offset,
            height_unit: self.height_unit,
            tile_rows: self.tile_rows,
            no_data: self.nodata,
            voids,
            ..OpenOptions::default()
        }
    }

    /// Returns the scene with these options; options that are not given keep the scene's values.
    #[must_use]
    pub(crate) fn apply_to(&self, mut scene: Scene) -> Scene {
        scene.heights.encoding = self.encoding.or(scene.heights.encoding);
        scene.heights.height_scale_m = self.height_scale.or(scene.heights.height_scale_m);
        scene.heights.height_offset_m = self.height_offset.or(scene.heights.height_offset_m);
        scene.heights.height_unit = self.height_unit.or(scene.heights.height_unit);
        scene.heights.tile_rows = self.tile_rows.or(scene.heights.tile_rows);
        scene.heights.no_data = self.nodata.or(scene.heights.no_data);
        scene.heights.voids = self.voids.unwrap_or(scene.heights.voids);
        scene
    }
}
