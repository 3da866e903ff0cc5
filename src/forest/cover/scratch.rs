//! DEMs and rasters for the tests of covers.
#![allow(clippy::disallowed_methods, reason = "a test writes into its own scratch folder")]

use std::path::PathBuf;

use geotiff_writer::{GeoTiffBuilder, ModelType, NumericSample};
use ndarray::Array2;
use png::{BitDepth, ColorType};

use super::Cover;
use crate::scene::CoverFiles;
use crate::source::georeference::{Crs, Georeference};
use crate::source::{GeoKeys, WorldMapping};

/// A DEM of 101 × 81 samples, 20 m apart, with its world.
pub(super) struct Dem(pub Georeference, pub [u32; 2]);

impl Dem {
    fn of(crs: Crs, crs_from_grid: [f64; 6]) -> Self {
        Self(Georeference { crs_from_grid, crs, geokeys: GeoKeys::default() }, [101, 81])
    }

    pub(super) fn utm() -> Self {
        let crs = Crs::Projected { metres_per_unit: 1.0, name: "EPSG:32610".into() };
        Self::of(crs, [600_000.0, 20.0, 0.0, 5_200_000.0, 0.0, -20.0])
    }

    /// Returns a DEM of less than 2 km around a place 100 km east of the centre of its zone, where grid north is
    /// tilted.
    pub(super) fn geographic() -> Self {
        let crs = Crs::Geographic {
            radians_per_unit: 1f64.to_radians(),
            semi_major_axis_m: 6_378_137.0,
            inverse_flattening: 298.257_223_563,
            name: "EPSG:4326".into(),
        };
        Self::of(crs, [-121.7, 2.5e-4, 0.0, 46.95, 0.0, -1.8e-4])
    }

    pub(super) fn local() -> Self {
        Self::of(Crs::Local, [0.0, 20.0, 0.0, 0.0, 0.0, -20.0])
    }

    pub(super) fn mapping(&self) -> WorldMapping {
        WorldMapping::new(&self.0, self.1[0], self.1[1]).unwrap()
    }

    pub(super) fn load(&self, files: &CoverFiles) -> Result<Cover, String> {
        Cover::load(files, &self.0, self.1).map(Option::unwrap).map_err(|error| {
            let error = error.to_string();
            assert!(!error.contains('\n') && error.chars().count() < 300, "{error}");
            error
        })
    }
}

/// A temporary folder for rasters.
pub(super) struct Scratch(pub tempfile::TempDir);

impl Scratch {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a raster of `value` at the centres of samples; returns its path.
    pub(super) fn tiff<T: NumericSample>(
        &self,
        builder: GeoTiffBuilder,
        [left, top]: [f64; 2],
        [wide, high]: [f64; 2],
        size: [usize; 2],
        value: impl Fn(f64, f64) -> T,
    ) -> PathBuf {
        let path = self.path("raster.tif");
        let at =
            |(row, column): (usize, usize)| value(left + (column as f64 + 0.5) * wide, top - (row as f64 + 0.5) * high);
        let samples = Array2::from_shape_fn((size[1], size[0]), at);
        builder.pixel_scale(wide, high).origin(left, top).write_2d(&path, samples.view()).unwrap();
        path
    }

    pub(super) fn png(&self, color: ColorType, depth: BitDepth, size: [u32; 2], bytes: &[u8]) -> PathBuf {
        let path = self.path("mask.png");
        let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), size[0], size[1]);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(bytes).unwrap();
        path
    }
}

pub(super) fn builder([columns, rows]: [usize; 2], epsg: u16) -> GeoTiffBuilder {
    let model = if epsg == 4326 { ModelType::Geographic } else { ModelType::Projected };
    GeoTiffBuilder::new(columns as u32, rows as u32).model_type(model).epsg(epsg)
}
