//! netCDF, classic and netCDF-4 (HDF5): the format of GEBCO and ETOPO. The heights are a variable over two dimensions
//! with coordinates (CF conventions 1.8, sections 4, 5.6 and 8.1), read by windows.

use std::path::{Path, PathBuf};

use netcdf_reader::{NcFile, NcSliceInfo, NcSliceInfoElem, NcVariable};

use super::SourceError;
use super::georeference::Georeference;
use super::netcdf_axes::{self, Axis};
use super::place::{self, begin_window, foreign_message, inconsistent, unclear};
use super::reader::{HeightReader, Window};
use super::samples::MAX_HEIGHT_M;

/// Names of variables that hold heights, most common first.
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
/// Prefixes of CF standard names of heights.
const STANDARD_NAMES: [&str; 6] =
    ["height", "surface_altitude", "altitude", "bedrock_altitude", "sea_floor_depth", "depth_below"];
/// Prefixes of CF standard names of heights that count downwards.
const DEPTHS: [&str; 2] = ["sea_floor_depth", "depth"];
/// Largest number of coordinates of a dimension.
const MAX_COORDINATES: u64 = 1 << 24;
/// Side of a block of samples.
const BLOCK: u32 = 1024;

/// A file that is read by windows.
struct NetCdfReader {
    path: PathBuf,
    file: NcFile,
    variable: String,
    /// Number of dimensions of length 1 before rows and columns.
    before: usize,
    /// Whether the last dimension is that of the rows.
    is_transposed: bool,
    size: [u32; 2],
    unit_m: f64,
    /// Whether the values count downwards.
    is_depth: bool,
    georeference: Georeference,
    identity: String,
}

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<Box<dyn HeightReader>, SourceError> {
    let damaged = |error: netcdf_reader::Error| damaged(path, &error);
    let file = NcFile::open(path).map_err(damaged)?;
    let variables = file.variables().map_err(damaged)?;
    let variable = heights(path, variables)?;
    let shape = variable.shape();
    let before = shape.len() - 2;
    let is_transposed = netcdf_axes::is_transposed(path, variables, variable)?;
    // Indices of the dimensions of columns and of rows.
    let dimensions = if is_transposed { [before, before + 1] } else { [before + 1, before] };
    let name = variable.name().to_owned();
    let unit_m = netcdf_axes::unit_m(variable).unwrap_or(1.0);
    let size = dimensions.map(|dimension| shape[dimension]);
    if size.iter().any(|count| *count > MAX_COORDINATES) {
        return Err(inconsistent(path, format!("{}×{} samples are too many", size[0], size[1])));
    }
    let size = size.map(|count| count as u32);
    place::check_size(path, size)?;
    let axes = [0, 1].map(|axis| {
        let dimension = &variable.dimensions()[dimensions[axis]].name;
        Axis::of(path, &file, variables, dimension, size[axis])
    });
    let [x, y] = axes;
    let (georeference, prj) = netcdf_axes::georeference(path, variables, variable, [&x?, &y?], size)?;
    let files: Vec<&Path> = std::iter::once(path).chain(prj.as_deref()).collect();
    let (identity, is_depth) = (place::identity(&files, &name), is_depth(variable));
    Ok(Box::new(NetCdfReader {
        path: path.into(),
        file,
        variable: name,
        before,
        is_transposed,
        size,
        unit_m,
        is_depth,
        georeference,
        identity,
    }))
}

/// Returns whether the values of a variable count downwards, by its attributes.
fn is_depth(variable: &NcVariable) -> bool {
    match text(variable, "positive").map(|direction| direction.to_ascii_lowercase()).as_deref() {
        Some("down") => true,
        Some("up") => false,
        _ => text(variable, "standard_name").is_some_and(|name| DEPTHS.iter().any(|depth| name.starts_with(depth))),
    }
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
        let name = text(variable, "standard_name").unwrap_or_default();
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

/// Returns an attribute of a variable as text, without spaces around it.
pub(super) fn text(of: &NcVariable, name: &str) -> Option<String> {
    of.attribute(name).and_then(|it| it.value.as_string()).map(|text| text.trim().to_owned())
}

pub(super) fn damaged(path: &Path, error: &netcdf_reader::Error) -> SourceError {
    inconsistent(path, foreign_message(error))
}

impl HeightReader for NetCdfReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = begin_window(&self.path, window, self.size)?;
        if window.samples() == 0 {
            return Ok(heights_m);
        }
        let part = |first: u32, count: u32| {
            let (start, end) = (u64::from(first), u64::from(first) + u64::from(count));
            NcSliceInfoElem::Slice { start, end, step: 1 }
        };
        let mut selections = vec![NcSliceInfoElem::Index(0); self.before];
        let (rows, columns) = (part(window.y, window.height), part(window.x, window.width));
        selections.extend(if self.is_transposed { [columns, rows] } else { [rows, columns] });
        let values = super::geotiff::guarded(&self.path, || {
            let values = self.file.read_variable_slice_unpacked_masked(&self.variable, &NcSliceInfo { selections });
            values.map_err(|error| damaged(&self.path, &error))
        })?;
        if values.len() != window.samples() {
            return Err(inconsistent(&self.path, "a part of it decodes to the wrong size"));
        }
        let values = if self.is_transposed { values.reversed_axes() } else { values };
        let unit_m = if self.is_depth { -self.unit_m } else { self.unit_m };
        heights_m.extend(values.iter().map(|value| {
            let height_m = value * unit_m;
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
        self.identity.clone()
    }
}
