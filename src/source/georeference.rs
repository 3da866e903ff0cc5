//! Where a grid of samples lies: its coordinate reference system and its place in it, and the way from grid
//! coordinates to the world's metres (east, north).

use serde::{Deserialize, Serialize};

/// The place of a height grid. Grid coordinates are (column, row) of sample *centres*: sample (0, 0) is the first of
/// the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Georeference {
    /// `crs_from_grid` as `[x0, dx/dcolumn, dx/drow, y0, dy/dcolumn, dy/drow]` in units of the CRS.
    pub crs_from_grid: [f64; 6],
    /// What the CRS coordinates mean.
    pub crs: Crs,
}

/// As much of a coordinate reference system as the world's frame needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Crs {
    /// The file names none: its units are taken as metres.
    Local,
    /// Eastings and northings.
    Projected {
        /// 1 for metres, 0.3048006… for US survey feet.
        metres_per_unit: f64,
        /// For people: `EPSG:32610`, or the citation in the file.
        name: String,
    },
    /// Longitudes and latitudes.
    Geographic {
        /// π/180 for degrees.
        radians_per_unit: f64,
        /// Of the ellipsoid.
        semi_major_axis_m: f64,
        /// Of the ellipsoid; 0 for a sphere.
        inverse_flattening: f64,
        /// For people.
        name: String,
    },
}
