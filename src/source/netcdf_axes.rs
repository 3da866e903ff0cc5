//! The axes of a grid in netCDF, and its place on the earth (CF conventions 1.8, sections 4.1, 4.2 and 5.6).

use std::path::{Path, PathBuf};

use netcdf_reader::{NcFile, NcVariable};

use super::georeference::{self, Crs, Georeference};
use super::netcdf::{damaged, text};
use super::place::{self, unclear};
use super::samples::BandMetadata;
use super::{GeoKeys, SourceError, prj, wkt};
use crate::file::message::quoted;

/// Largest deviation of a coordinate from even spacing, as a fraction of the spacing.
const TOLERANCE: f64 = 0.05;
/// The grid mapping of longitudes and latitudes, and that of a globe with other poles.
const LATITUDE_LONGITUDE: &str = "latitude_longitude";
const ROTATED: &str = "rotated_latitude_longitude";

/// The directions of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    East,
    North,
}

impl Direction {
    /// Returns the direction of a coordinate variable: by its attributes, or else by its name.
    fn of(coordinates: &NcVariable) -> Option<Self> {
        let lower = |name: &str| text(coordinates, name).unwrap_or_default().to_ascii_lowercase();
        let by_units = |units: &str| match units {
            "degrees_east" | "degree_east" | "degrees_e" | "degree_e" | "degreese" | "degreee" => Some(Self::East),
            "degrees_north" | "degree_north" | "degrees_n" | "degree_n" | "degreesn" | "degreen" => Some(Self::North),
            _ => None,
        };
        let by_name = |name: &str| match name {
            "longitude" | "projection_x_coordinate" | "grid_longitude" | "lon" | "rlon" | "x" | "easting" => {
                Some(Self::East)
            }
            "latitude" | "projection_y_coordinate" | "grid_latitude" | "lat" | "rlat" | "y" | "northing" => {
                Some(Self::North)
            }
            _ => None,
        };
        by_name(&lower("standard_name"))
            .or_else(|| by_name(&lower("axis")))
            .or_else(|| by_units(&lower("units")))
            .or_else(|| by_name(&coordinates.name().to_ascii_lowercase()))
    }
}

/// Returns whether the last dimension of a variable is that of the rows, and the one before that of the columns.
///
/// # Errors
/// Fails if both dimensions have the same direction.
pub(super) fn is_transposed(path: &Path, variables: &[NcVariable], variable: &NcVariable) -> Result<bool, SourceError> {
    let dimensions = variable.dimensions();
    let [first, last] = [2, 1].map(|from_end| {
        let name = &dimensions[dimensions.len() - from_end].name;
        variables.iter().find(|it| it.name() == name.as_str() && it.shape().len() == 1).and_then(Direction::of)
    });
    match (first, last) {
        (Some(first), Some(last)) if first == last => {
            let direction = if first == Direction::East { "east" } else { "north" };
            Err(unclear(path, format!("both dimensions of {} run {direction}", quoted(variable.name()))))
        }
        (Some(Direction::East), _) | (_, Some(Direction::North)) => Ok(true),
        _ => Ok(false),
    }
}

/// The coordinates of a dimension.
pub(super) struct Axis {
    /// The first coordinate.
    first: f64,
    /// The distance between two.
    step: f64,
    /// The unit of the coordinates, in lower case.
    unit: Option<String>,
    /// Whether they are degrees of a globe with other poles.
    is_rotated: bool,
}

impl Axis {
    /// Reads the coordinates of a dimension of `count` entries.
    ///
    /// # Errors
    /// Fails if there are none, or if they are not evenly spaced.
    pub(super) fn of(
        path: &Path,
        file: &NcFile,
        variables: &[NcVariable],
        name: &str,
        count: u32,
    ) -> Result<Self, SourceError> {
        let coordinates = variables.iter().find(|it| it.name() == name && it.shape() == [u64::from(count)]);
        let coordinates =
            coordinates.ok_or_else(|| unclear(path, format!("has no coordinates for its dimension {name:?}")))?;
        let values = file.read_variable_unpacked(name).map_err(|error| damaged(path, &error))?;
        let values: Vec<f64> = values.iter().copied().collect();
        let irregular =
            || unclear(path, format!("its coordinates {name:?} are not evenly spaced; gdalwarp resamples it"));
        let (Some(&first), Some(last)) = (values.first(), values.last()) else { return Err(irregular()) };
        let step = (last - first) / (f64::from(count) - 1.0);
        let is_even =
            values.iter().enumerate().all(|(i, it)| (it - (first + i as f64 * step)).abs() <= TOLERANCE * step.abs());
        if step == 0.0 || !step.is_finite() || !is_even {
            return Err(irregular());
        }
        let unit = text(coordinates, "units").map(|unit| unit.to_ascii_lowercase());
        let is_rotated = text(coordinates, "standard_name").is_some_and(|name| name.starts_with("grid_l"));
        Ok(Self { first, step, unit, is_rotated })
    }

    fn is_degrees(&self) -> bool {
        self.unit.as_deref().is_some_and(|unit| unit.starts_with("degree"))
    }
}

/// Returns metres per unit of a variable, if its unit is one of length.
pub(super) fn unit_m(variable: &NcVariable) -> Option<f64> {
    metres(text(variable, "units")?.to_ascii_lowercase())
}

fn metres(unit: String) -> Option<f64> {
    BandMetadata { unit: Some(unit), ..BandMetadata::default() }.metres_per_unit()
}

/// Returns the georeference of a grid of `size` samples, and the `.prj` file if it gave the CRS.
///
/// # Errors
/// Fails if the grid mapping is one that hachure cannot place.
pub(super) fn georeference(
    path: &Path,
    variables: &[NcVariable],
    variable: &NcVariable,
    axes: [&Axis; 2],
    size: [u32; 2],
) -> Result<(Georeference, Option<PathBuf>), SourceError> {
    let transform =
        |[x, y]: [f64; 2]| [axes[0].first * x, axes[0].step * x, 0.0, axes[1].first * y, 0.0, axes[1].step * y];
    let as_stored = transform([1.0; 2]);
    let (mapping, wkt) = grid_mapping(variables, variable);
    let is_degrees = axes.iter().all(|axis| axis.is_degrees());
    let mapping = if axes.iter().any(|axis| axis.is_rotated) { Some(ROTATED.to_owned()) } else { mapping };
    let (keys, prj) = match (wkt, mapping.filter(|name| name != LATITUDE_LONGITUDE)) {
        // Well-Known Text of rotated poles describes the globe that was rotated.
        (_, Some(name)) if name == ROTATED => return Err(unplaced(path, &name)),
        (Some(keys), _) => (keys, None),
        (None, Some(name)) => match prj::given(path)? {
            Some((keys, prj)) => (keys, Some(prj)),
            None if is_degrees => return Err(unplaced(path, &name)),
            None => {
                tracing::warn!(
                    "{}: its grid mapping {} has no crs_wkt, so that its place on the earth is unknown; a .prj file gives it",
                    path.display(),
                    quoted(&name)
                );
                (GeoKeys::default(), None)
            }
        },
        (None, None) if is_degrees => (place::wgs84(), None),
        (None, None) => prj::keys(path, as_stored, size)?,
    };
    // Coordinates have units of their own, which need not be those of the CRS.
    let located = |source| SourceError::Georeference { path: path.into(), source };
    let name = path.display().to_string();
    let unit_m = match georeference::from_transform(as_stored, keys.clone(), &name).map_err(located)?.crs {
        Crs::Local => Some(1.0),
        Crs::Projected { metres_per_unit, .. } => Some(metres_per_unit),
        Crs::Geographic { .. } => None,
    };
    let factors = axes.map(|axis| match (axis.unit.clone().and_then(metres), unit_m) {
        (Some(own_m), Some(unit_m)) => own_m / unit_m,
        _ => 1.0,
    });
    Ok((place::locate(path, transform(factors), keys, size)?, prj))
}

fn unplaced(path: &Path, mapping: &str) -> SourceError {
    let why = format!("its grid mapping is {}, which hachure cannot place; gdalwarp resamples it", quoted(mapping));
    unclear(path, why)
}

/// Returns the name of a variable's grid mapping, and the keys of the CRS that it gives in Well-Known Text.
fn grid_mapping(variables: &[NcVariable], variable: &NcVariable) -> (Option<String>, Option<GeoKeys>) {
    let named = text(variable, "grid_mapping");
    let name = named.as_deref().and_then(|named| named.split([':', ' ']).next());
    let Some(mapping) = variables.iter().find(|it| Some(it.name()) == name) else { return (None, None) };
    let keys = ["crs_wkt", "spatial_ref"].iter().find_map(|name| wkt::keys(&text(mapping, name)?));
    (text(mapping, "grid_mapping_name"), keys)
}
