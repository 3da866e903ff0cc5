//! Aligns a raster with a DEM: maps the samples of the DEM to those of the raster, whatever their reference systems.

use super::georeference::{Crs, Georeference};
use super::mosaic::SampleTransform;

/// Why a raster cannot be aligned with a DEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Misaligned {
    /// The raster has no reference system.
    Raster,
    /// The DEM has none.
    Dem,
    /// There is no transformation between them; the reason, as a clause.
    NoWay(String),
}

/// The mapping from samples of a DEM to those of a raster.
#[derive(Debug)]
pub(crate) enum Alignment {
    ByPlace(SampleTransform),
    /// Factor and offset of each axis: the raster covers the whole DEM.
    Stretched([f64; 2], [f64; 2]),
}

/// A raster or a DEM: its position, and its columns and rows.
pub(crate) type Grid<'a> = (&'a Georeference, [u32; 2]);

impl Alignment {
    /// Aligns a raster by its position. Also returns the mapping back.
    ///
    /// # Errors
    /// One of them has no reference system, or no transformation between them is known.
    pub(crate) fn by_place(dem: Grid<'_>, raster: Grid<'_>) -> Result<(Self, SampleTransform), Misaligned> {
        if !is_known(&raster.0.crs) {
            return Err(Misaligned::Raster);
        }
        if !is_known(&dem.0.crs) {
            return Err(Misaligned::Dem);
        }
        Self::by_coordinates(dem, raster)
    }

    /// Aligns a raster as [`Alignment::by_place`] does, and one without a reference system with a DEM that has none either:
    /// both then have the same coordinates, as a DEM and a map that was drawn of it.
    ///
    /// # Errors
    /// Only one of them has a reference system, or no transformation between them is known.
    pub(crate) fn by_coordinates(dem: Grid<'_>, raster: Grid<'_>) -> Result<(Self, SampleTransform), Misaligned> {
        let way = SampleTransform::to_grid(dem.0, raster.0, raster.1).map_err(Misaligned::NoWay)?;
        let back = SampleTransform::to_grid(raster.0, dem.0, dem.1).map_err(Misaligned::NoWay)?;
        Ok((Self::ByPlace(way), back))
    }

    /// Stretches a raster of `size` over a whole DEM, with its upper edge in the north.
    pub(crate) fn stretched((dem, samples): Grid<'_>, size: [u32; 2]) -> Self {
        // The raster is upright even if the DEM's rows run north or its columns run west.
        let [_, column_x, _, _, _, row_y] = dem.crs_from_grid;
        let axis = |axis: usize, is_turned: bool| {
            let size = f64::from(size[axis]);
            let factor = size / f64::from(samples[axis]);
            let shift = 0.5 * factor - 0.5;
            if is_turned { (-factor, size - 1.0 - shift) } else { (factor, shift) }
        };
        let (x, y) = (axis(0, column_x < 0.0), axis(1, row_y > 0.0));
        Self::Stretched([x.0, y.0], [x.1, y.1])
    }

    /// Returns the raster's (column, row) of a sample of the DEM; NaN where it is unknown.
    pub(crate) fn map(&self, column: f64, row: f64) -> [f64; 2] {
        match self {
            Self::ByPlace(way) => way.map(column, row),
            Self::Stretched(factor, shift) => [factor[0] * column + shift[0], factor[1] * row + shift[1]],
        }
    }
}

/// Returns whether a reference system identifies locations, so that it can be compared with or transformed to another one.
fn is_known(crs: &Crs) -> bool {
    match crs {
        Crs::Local => false,
        Crs::Projected { name, .. } => name != "unnamed",
        Crs::Geographic { .. } => true,
    }
}

/// Returns points along the border of a rectangle, `count` + 1 on each side.
pub(crate) fn border(low: [f64; 2], high: [f64; 2], count: u32) -> impl Iterator<Item = [f64; 2]> {
    (0..=count).flat_map(move |i| {
        let part = f64::from(i) / f64::from(count);
        let [x, y] = [0, 1].map(|axis| low[axis] + part * (high[axis] - low[axis]));
        [[x, low[1]], [x, high[1]], [low[0], y], [high[0], y]]
    })
}
