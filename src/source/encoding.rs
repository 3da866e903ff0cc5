//! Options that describe a height file: colour encoding, order of tile rows, unit of heights.

use serde::Deserialize;

/// The encodings of heights in the colours of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// (red × 256 + green + blue / 256) − 32768 metres.
    Terrarium,
    /// −10000 + (red × 65536 + green × 256 + blue) × 0.1 metres. Other files have another base and another interval.
    Mapbox,
    /// (red × 65536 + green × 256 + blue) × 0.01 metres in two's complement; (128, 0, 0) is no-data. The tiles of the
    /// Geospatial Information Authority of Japan.
    Gsi,
}

impl Encoding {
    pub const ALL: [Self; 3] = [Self::Mapbox, Self::Terrarium, Self::Gsi];

    /// Returns the name that options and sidecar files use.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Terrarium => "terrarium",
            Self::Mapbox => "mapbox",
            Self::Gsi => "gsi",
        }
    }

    /// Returns the default of metres per step, and the height of code 0 in metres.
    pub(super) fn steps_m(self) -> [f64; 2] {
        match self {
            Self::Terrarium => [1.0 / 256.0, -32_768.0],
            Self::Mapbox => [0.1, -10_000.0],
            Self::Gsi => [0.01, 0.0],
        }
    }
}

/// The direction in which the rows of web map tiles are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum TileRows {
    /// From the north, as web maps do.
    Xyz,
    /// From the south: the Tile Map Service, `gdal2tiles` without `--xyz`, MBTiles.
    Tms,
}

impl TileRows {
    pub const ALL: [Self; 2] = [Self::Xyz, Self::Tms];

    /// Returns the name that options and sidecar files use.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Xyz => "xyz",
            Self::Tms => "tms",
        }
    }
}

/// The units of heights that a caller may give.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum HeightUnit {
    /// Metres.
    M,
    /// International feet, 0.3048 m.
    Ft,
    /// US survey feet, 1200/3937 m.
    UsFt,
}

impl HeightUnit {
    pub const ALL: [Self; 3] = [Self::M, Self::Ft, Self::UsFt];

    /// Returns the name that options use.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Ft => "ft",
            Self::UsFt => "us-ft",
        }
    }

    /// Returns metres per unit.
    #[must_use]
    pub(crate) fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Ft => 0.3048,
            Self::UsFt => 1200.0 / 3937.0,
        }
    }
}
