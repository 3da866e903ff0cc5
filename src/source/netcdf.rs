//! netCDF, classic and netCDF-4 (HDF5): the format of GEBCO and ETOPO. The heights are a variable over two dimensions
//! with coordinates (CF conventions 1.8, sections 4, 5.6 and 8.1), read by windows.

use std::path::{Path, PathBuf};

use netcdf_reader::{NcFile, NcSliceInfo, NcSliceInfoElem, NcVariable};

use super::georeference::Georeference;
use super::memory;
use super::place::{self, check_window, inconsistent, unclear};
use super::reader::{HeightReader, Window};
use super::samples::{BandMetadata, MAX_HEIGHT_M};
use super::{GeoKeys, SourceError, prj, wkt};

/// Names of variables that hold heights, most usual first.
const NAMES: [&str; 12] = [
    "elevation",
    "z",
    "band1",
    "topo",
    "height",
    "altitude",
    "bathymetry",
    "dem",
    "bed",
    "surface",
    "topography",
    "data",
];
/// Standard names of heights begin so.
const STANDARD_NAMES: [&str; 5] = ["height", "surface_altitude", "altitude", "bedrock_altitude", "sea_floor"];
/// Largest number of coordinates of a dimension.
const MAX_COORDINATES: u64 = 1 << 24;
/// Largest deviation of a coordinate from even spacing, as a fraction of the spacing.
const TOLERANCE: f64 = 0.05;
/// Side of a block of samples.
const BLOCK: u32 = 1024;

/// A file that is read by windows.
struct NetCdfReader {
    path: PathBuf,
    file: NcFile,
    variable: String,
    /// Number of dimensions of length 1 before rows and columns.
    before: usize,
    size: [u32; 2],
    unit_m: f64,
    georeference: Georeference,
}

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<Box<dyn HeightReader>, SourceError> {
    let damaged = |error: netcdf_reader::Error| damaged(path, &error);
    let file = NcFile::open(path).map_err(damaged)?;
    let variables = file.variables().map_err(damaged)?;
    let variable = heights(path, variables)?;
    let shape = variable.shape();
    let before = shape.len() - 2;
    let [rows, columns] =
        [&variable.dimensions()[before].name, &variable.dimensions()[before + 1].name].map(String::clone);
    let name = variable.name().to_owned();
    let unit = variable.attribute("units").and_then(|units| units.value.as_string());
    let unit = BandMetadata { unit: unit.map(|unit| unit.trim().to_ascii_lowercase()), ..BandMetadata::default() };
    let unit_m = unit.metres_per_unit().unwrap_or(1.0);
    let keys = grid_mapping(variables, variable);
    let size = [shape[before + 1], shape[before]];
    if size.iter().any(|count| *count > MAX_COORDINATES) {
        return Err(inconsistent(path, format!("{}×{} samples are too many", size[0], size[1])));
    }
    let size = size.map(|count| count as u32);
    place::check_size(path, size)?;
    let [x, y] = [(&columns, size[0]), (&rows, size[1])].map(|(name, count)| axis(path, &file, variables, name, count));
    let ([x0, dx], [y0, dy]) = (x?, y?);
    let crs_from_grid = [x0, dx, 0.0, y0, 0.0, dy];
    let is_degrees = [&columns, &rows].iter().all(|name| {
        let units = variables.iter().find(|it| it.name() == name.as_str()).and_then(|it| it.attribute("units"));
        units.and_then(|it| it.value.as_string()).is_some_and(|units| units.starts_with("degree"))
    });
    let keys = match keys {
        Some(keys) => keys,
        None if is_degrees => place::wgs84(),
        None => prj::keys(path, crs_from_grid, size)?.0,
    };
    let georeference = place::locate(path, crs_from_grid, keys, size)?;
    Ok(Box::new(NetCdfReader { path: path.into(), file, variable: name, before, size, unit_m, georeference }))
}

/// Returns the variable of heights: the only numbers over two dimensions, or the one with a usual name.
fn heights<'a>(path: &Path, variables: &'a [NcVariable]) -> Result<&'a NcVariable, SourceError> {
    let is_grid = |variable: &&NcVariable| {
        let shape = variable.shape();
        // Further dimensions, such as one moment of time, may have one entry each.
        shape.len() >= 2 && shape[..shape.len() - 2].iter().all(|count| *count == 1) && variable.dtype().is_primitive()
    };
    let grids: Vec<&NcVariable> = variables.iter().filter(is_grid).collect();
    let standard = |variable: &&&NcVariable| {
        let name = variable.attribute("standard_name").and_then(|name| name.value.as_string()).unwrap_or_default();
        STANDARD_NAMES.iter().any(|known| name.starts_with(known))
    };
    let named = || NAMES.iter().find_map(|name| grids.iter().find(|it| it.name().eq_ignore_ascii_case(name)));
    if let Some(found) = named().or_else(|| grids.iter().find(standard)) {
        return Ok(found);
    }
    match grids[..] {
        [only] => Ok(only),
        [] => Err(unclear(path, "this netCDF or HDF5 file has no variable over two dimensions, so no heights")),
        _ => {
            let names: Vec<&str> = grids.iter().take(4).map(|it| it.name()).collect();
            let why = format!("has several variables ({}), none named elevation or z", names.join(", "));
            Err(unclear(path, why))
        }
    }
}

/// Returns the first coordinate and the spacing of a dimension.
fn axis(path: &Path, file: &NcFile, variables: &[NcVariable], name: &str, count: u32) -> Result<[f64; 2], SourceError> {
    let known = variables.iter().any(|it| it.name() == name && it.shape() == [u64::from(count)]);
    if !known {
        return Err(unclear(path, format!("has no coordinates for its dimension {name:?}")));
    }
    let values = file.read_variable_unpacked(name).map_err(|error| damaged(path, &error))?;
    let values: Vec<f64> = values.iter().copied().collect();
    let irregular = || unclear(path, format!("its coordinates {name:?} are not evenly spaced; gdalwarp resamples it"));
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return Err(irregular()) };
    let step = (last - first) / (f64::from(count) - 1.0);
    let is_even =
        values.iter().enumerate().all(|(i, it)| (it - (first + i as f64 * step)).abs() <= TOLERANCE * step.abs());
    (step != 0.0 && step.is_finite() && is_even).then_some([*first, step]).ok_or_else(irregular)
}

/// Returns the keys of the CRS that the variable's grid mapping gives in Well-Known Text.
fn grid_mapping(variables: &[NcVariable], variable: &NcVariable) -> Option<GeoKeys> {
    let text = |of: &NcVariable, name: &str| of.attribute(name).and_then(|it| it.value.as_string());
    let mapping = text(variable, "grid_mapping")?;
    let mapping = variables.iter().find(|it| it.name() == mapping.split([':', ' ']).next().unwrap_or_default())?;
    ["crs_wkt", "spatial_ref"].iter().find_map(|name| wkt::keys(&text(mapping, name)?))
}

fn damaged(path: &Path, error: &netcdf_reader::Error) -> SourceError {
    inconsistent(path, error.to_string().split_whitespace().collect::<Vec<_>>().join(" "))
}

impl HeightReader for NetCdfReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        check_window(&self.path, window, self.size)?;
        if window.samples() == 0 {
            return Ok(Vec::new());
        }
        let mut heights_m = memory::window_room(&self.path, window)?;
        let part = |first: u32, count: u32| {
            let (start, end) = (u64::from(first), u64::from(first) + u64::from(count));
            NcSliceInfoElem::Slice { start, end, step: 1 }
        };
        let mut selections = vec![NcSliceInfoElem::Index(0); self.before];
        selections.extend([part(window.y, window.height), part(window.x, window.width)]);
        let values = super::geotiff::guarded(&self.path, || {
            let values = self.file.read_variable_slice_unpacked_masked(&self.variable, &NcSliceInfo { selections });
            values.map_err(|error| damaged(&self.path, &error))
        })?;
        if values.len() != window.samples() {
            return Err(inconsistent(&self.path, "a part of it decodes to the wrong size"));
        }
        heights_m.extend(values.iter().map(|value| {
            let height_m = value * self.unit_m;
            if height_m.abs() <= MAX_HEIGHT_M { height_m as f32 } else { f32::NAN }
        }));
        Ok(heights_m)
    }

    fn declared_unit_m(&self) -> Option<f64> {
        Some(self.unit_m).filter(|unit_m| *unit_m != 1.0)
    }

    fn block(&self) -> [u32; 2] {
        self.size.map(|count| count.min(BLOCK))
    }

    fn identity(&self) -> String {
        place::identity(&[&self.path], &self.variable)
    }
}
