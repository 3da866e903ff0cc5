//! A raster aligned with a world: the mapping from positions to samples.

use std::path::Path;

use glam::{DMat2, DVec2};

use super::CoverError;
use super::resample::Grid;
use crate::file::message::printable;
use crate::source::alignment::{Alignment, Misaligned, border};
use crate::source::georeference::{Georeference, GeoreferenceError};
use crate::source::{HeightReader, WorldMapping};

/// Number of intervals along each border of a rectangle, for computing an extent.
const BORDER_PLACES: u32 = 32;

/// The DEM of a world.
pub(super) struct Ground<'a> {
    place: &'a Georeference,
    samples: [u32; 2],
    mapping: WorldMapping,
    /// South-west and north-east corners of its samples' extent, in the world.
    pub low_m: DVec2,
    pub high_m: DVec2,
}

impl<'a> Ground<'a> {
    pub(super) fn new(place: &'a Georeference, samples: [u32; 2]) -> Result<Self, GeoreferenceError> {
        let mapping = WorldMapping::new(place, samples[0], samples[1])?;
        let last = samples.map(|count| f64::from(count.max(1) - 1));
        let places = border([0.0, 0.0], last, BORDER_PLACES).map(|[column, row]| mapping.world_from_grid(column, row));
        let (low_m, high_m) = extent(places).unwrap_or_default();
        Ok(Self { place, samples, mapping, low_m, high_m })
    }
}

/// A raster with its mapping from the world.
pub(super) struct AlignedRaster<'a> {
    pub path: &'a Path,
    pub reader: Box<dyn HeightReader>,
    ground: &'a Ground<'a>,
    way: Alignment,
    /// The extent in the world, or a larger one.
    pub low_m: DVec2,
    pub high_m: DVec2,
    /// Samples per metre at the centre of the extent.
    per_m: DMat2,
}

impl<'a> AlignedRaster<'a> {
    /// Places a raster by its georeference.
    ///
    /// # Errors
    /// The georeference is unknown, or the raster does not overlap the world.
    pub(super) fn by_place(
        path: &'a Path,
        reader: Box<dyn HeightReader>,
        ground: &'a Ground<'a>,
    ) -> Result<Self, CoverError> {
        let aligned = Alignment::by_place((ground.place, ground.samples), (reader.georeference(), reader.size()));
        let (way, back) = aligned.map_err(|error| match error {
            Misaligned::Raster => CoverError::Nowhere { path: path.to_owned() },
            Misaligned::Dem => CoverError::WorldNowhere { path: path.to_owned() },
            Misaligned::NoWay(cause) => CoverError::NoWay { path: path.to_owned(), cause: printable(&cause, 120) },
        })?;
        let last = reader.size().map(|count| f64::from(count) - 0.5);
        let places: Vec<(DVec2, DVec2)> = border([-0.5; 2], last, BORDER_PLACES)
            .map(|[column, row]| {
                let [x, y] = back.map(column, row);
                (DVec2::new(column, row), ground.mapping.world_from_grid(x, y))
            })
            .collect();
        let placed =
            Self { path, reader, ground, way, low_m: ground.low_m, high_m: ground.high_m, per_m: DMat2::IDENTITY };
        // Projections are meaningless far from their zone. A raster for which that happens is taken to cover
        // everything.
        let is_sure = places.iter().all(|(sample, at_m)| placed.sample_at(*at_m).distance(*sample) < 0.5);
        let own = extent(places.into_iter().map(|(_, at_m)| at_m)).filter(|_| is_sure);
        let (low_m, high_m) = own.unwrap_or((ground.low_m, ground.high_m));
        Self { low_m, high_m, ..placed }.measured()
    }

    /// Stretches a raster over the whole DEM, with its upper edge in the north.
    ///
    /// # Errors
    /// None if the DEM has an extent.
    pub(super) fn stretched(
        path: &'a Path,
        reader: Box<dyn HeightReader>,
        ground: &'a Ground<'a>,
    ) -> Result<Self, CoverError> {
        let way = Alignment::stretched((ground.place, ground.samples), reader.size());
        let (low_m, high_m) = (ground.low_m, ground.high_m);
        Self { path, reader, ground, way, low_m, high_m, per_m: DMat2::IDENTITY }.measured()
    }

    /// Returns (column, row) at a position in the world; NaN if it is unknown.
    pub(super) fn sample_at(&self, at_m: DVec2) -> DVec2 {
        let on_ground = self.ground.mapping.grid_from_world(at_m);
        DVec2::from_array(self.way.map(on_ground.x, on_ground.y))
    }

    fn measured(self) -> Result<Self, CoverError> {
        let outside = || CoverError::OutsideWorld { path: self.path.to_owned() };
        let (low_m, high_m) = (self.low_m.max(self.ground.low_m), self.high_m.min(self.ground.high_m));
        if !low_m.cmplt(high_m).all() {
            return Err(outside());
        }
        let (middle_m, h_m) = (0.5 * (low_m + high_m), 1e-4 * (high_m - low_m).max_element());
        let slope = |by_m: DVec2| (self.sample_at(middle_m + by_m) - self.sample_at(middle_m - by_m)) / (2.0 * h_m);
        let per_m = DMat2::from_cols(slope(DVec2::X * h_m), slope(DVec2::Y * h_m));
        if !(per_m.is_finite() && per_m.determinant() != 0.0) {
            return Err(outside());
        }
        Ok(Self { per_m, ..self })
    }

    /// Returns the distance between its columns or between its rows, whichever is smaller, in metres.
    pub(super) fn spacing_m(&self) -> f64 {
        let steps_m = self.per_m.inverse();
        steps_m.x_axis.length().min(steps_m.y_axis.length())
    }

    /// Returns the number of samples for each point that is read for cells of a grid.
    pub(super) fn samples_per_point(&self, grid: &Grid) -> f64 {
        let points = f64::from(grid.points_along(self));
        self.per_m.determinant().abs() * (grid.cell_m / points).powi(2)
    }

    /// Returns the corner of samples at or next to a position toward the south-west, if the raster's axes are those of
    /// the world; otherwise the position itself.
    pub(super) fn corner_at(&self, at_m: DVec2) -> DVec2 {
        let [a, b, c, d] = self.per_m.to_cols_array();
        if b.abs() > 1e-9 * a.abs() || c.abs() > 1e-9 * d.abs() {
            return at_m;
        }
        let at = self.sample_at(at_m) + 0.5;
        let close = DVec2::splat(1e-6);
        let corner = DVec2::select([a > 0.0, d > 0.0].into(), (at + close).floor(), (at - close).ceil());
        at_m + self.per_m.inverse() * (corner - at)
    }
}

/// Returns the bounding box; `None` if any of the points is not finite.
fn extent(places: impl Iterator<Item = DVec2>) -> Option<(DVec2, DVec2)> {
    let nothing = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (low, high, is_finite) = places.fold((nothing.0, nothing.1, true), |(low, high, is_finite), at| {
        (low.min(at), high.max(at), is_finite && at.is_finite())
    });
    (is_finite && low.cmple(high).all()).then_some((low, high))
}
