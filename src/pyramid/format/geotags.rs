//! The TIFF tags that georeference a level and give the meaning of its heights.

use geotiff_reader::geokeys;
use geotiff_writer::{GeoKeyDirectory, GeoKeyValue, GeoTransform, RasterType};
use tiff_reader::{Tag, TagValue};

use crate::source::georeference::{Crs, Georeference};

const MODEL_PIXEL_SCALE: u16 = 33550;
const MODEL_TIEPOINT: u16 = 33922;
const MODEL_TRANSFORMATION: u16 = 34264;
const GEO_KEY_DIRECTORY: u16 = 34735;
const GEO_DOUBLE_PARAMS: u16 = 34736;
const GEO_ASCII_PARAMS: u16 = 34737;
const GDAL_METADATA: u16 = 42112;
const GDAL_NODATA: u16 = 42113;

const SEMI_MAJOR_AXIS: u16 = 2057;
const INVERSE_FLATTENING: u16 = 2059;

const PROJECTED: u16 = 1;
const GEOGRAPHIC: u16 = 2;
const PIXEL_IS_AREA: u16 = 1;
const USER_DEFINED: u16 = 32767;
const DEGREE: u16 = 9102;
const METRE: u16 = 9001;
const FOOT: u16 = 9002;
const US_SURVEY_FOOT: u16 = 9003;

/// Returns the tags of the full-resolution image: transform, coordinate reference system, unit of height, no-data
/// value.
fn full_resolution_tags(georeference: &Georeference) -> Result<Vec<Tag>, String> {
    let mut tags = place_tags(georeference)?;
    let metadata =
        "<GDALMetadata>\n  <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">m</Item>\n</GDALMetadata>\n";
    tags.push(Tag::new(GDAL_METADATA, TagValue::Ascii(metadata.into())));
    tags.push(no_data_tag());
    Ok(tags)
}

/// Returns the georeferencing tags of any image: its transform and its coordinate reference system.
///
/// # Errors
/// Returns a message if the geokeys do not fit a key directory.
pub(crate) fn place_tags(georeference: &Georeference) -> Result<Vec<Tag>, String> {
    let mut tags = transform_tags(georeference);
    let (directory, doubles, text) = directory(georeference).serialize().map_err(|error| error.to_string())?;
    tags.push(Tag::new(GEO_KEY_DIRECTORY, TagValue::Short(directory)));
    if !doubles.is_empty() {
        tags.push(Tag::new(GEO_DOUBLE_PARAMS, TagValue::Double(doubles)));
    }
    if !text.is_empty() {
        tags.push(Tag::new(GEO_ASCII_PARAMS, TagValue::Ascii(text)));
    }
    Ok(tags)
}

/// Returns the tag that declares NaN as the no-data value.
fn no_data_tag() -> Tag {
    Tag::new(GDAL_NODATA, TagValue::Ascii("nan".into()))
}

/// Returns the transform tags. `Georeference` counts sample centres; the file declares PixelIsArea, whose origin is the
/// outer corner of the first sample.
fn transform_tags(georeference: &Georeference) -> Vec<Tag> {
    let [x0, x_column, x_row, y0, y_column, y_row] = georeference.crs_from_grid;
    let transform = GeoTransform {
        origin_x: x0 - 0.5 * x_column - 0.5 * x_row,
        pixel_width: x_column,
        skew_x: x_row,
        origin_y: y0 - 0.5 * y_column - 0.5 * y_row,
        skew_y: y_column,
        pixel_height: y_row,
    };
    match transform.to_tiepoint_and_scale_with_raster_type(RasterType::PixelIsArea) {
        Some((tiepoint, scale)) => vec![
            Tag::new(MODEL_PIXEL_SCALE, TagValue::Double(scale.to_vec())),
            Tag::new(MODEL_TIEPOINT, TagValue::Double(tiepoint.to_vec())),
        ],
        None => vec![Tag::new(MODEL_TRANSFORMATION, TagValue::Double(transform.to_transformation_matrix().to_vec()))],
    }
}

/// Returns the source file's own geokeys if it has any, otherwise those of the CRS.
fn directory(georeference: &Georeference) -> GeoKeyDirectory {
    let mut keys = GeoKeyDirectory::new();
    if georeference.geokeys.keys.is_empty() {
        set_crs(&mut keys, &georeference.crs);
    }
    for key in &georeference.geokeys.keys {
        keys.set(key.id, (&key.value).into());
    }
    keys.set(geokeys::GT_RASTER_TYPE, GeoKeyValue::Short(PIXEL_IS_AREA));
    keys.keys.sort_by_key(|key| key.id);
    keys
}

fn set_crs(keys: &mut GeoKeyDirectory, crs: &Crs) {
    match crs {
        Crs::Local => {}
        Crs::Projected { metres_per_unit, name } => {
            keys.set(geokeys::GT_MODEL_TYPE, GeoKeyValue::Short(PROJECTED));
            match epsg(name) {
                Some(code) => keys.set(geokeys::PROJECTED_CRS_TYPE, GeoKeyValue::Short(code)),
                None => {
                    keys.set(geokeys::PROJECTED_CRS_TYPE, GeoKeyValue::Short(USER_DEFINED));
                    keys.set(geokeys::GT_CITATION, GeoKeyValue::Ascii(name.clone()));
                    keys.set(geokeys::PROJ_LINEAR_UNITS, GeoKeyValue::Short(linear_unit(*metres_per_unit)));
                }
            }
        }
        Crs::Geographic { semi_major_axis_m, inverse_flattening, name, .. } => {
            keys.set(geokeys::GT_MODEL_TYPE, GeoKeyValue::Short(GEOGRAPHIC));
            match epsg(name) {
                Some(code) => keys.set(geokeys::GEODETIC_CRS_TYPE, GeoKeyValue::Short(code)),
                None => {
                    keys.set(geokeys::GEODETIC_CRS_TYPE, GeoKeyValue::Short(USER_DEFINED));
                    keys.set(geokeys::GEODETIC_CITATION, GeoKeyValue::Ascii(name.clone()));
                    keys.set(geokeys::GEODETIC_DATUM, GeoKeyValue::Short(USER_DEFINED));
                    keys.set(geokeys::GEOG_ANGULAR_UNITS, GeoKeyValue::Short(DEGREE));
                    keys.set(SEMI_MAJOR_AXIS, GeoKeyValue::Double(vec![*semi_major_axis_m]));
                    keys.set(INVERSE_FLATTENING, GeoKeyValue::Double(vec![*inverse_flattening]));
                }
            }
        }
    }
}

/// Returns the code of a name like `EPSG:32610` if it fits a GeoTIFF key.
fn epsg(name: &str) -> Option<u16> {
    let (authority, code) = name.split_once(':')?;
    (authority.trim().eq_ignore_ascii_case("epsg"))
        .then(|| code.trim().parse().ok())?
        .filter(|&code| code < USER_DEFINED)
}

fn linear_unit(metres_per_unit: f64) -> u16 {
    let is = |unit: f64| (metres_per_unit / unit - 1.0).abs() < 1e-9;
    if is(1200.0 / 3937.0) {
        US_SURVEY_FOOT
    } else if is(0.3048) {
        FOOT
    } else {
        METRE
    }
}

/// Returns the tags of a level. Overviews carry no georeference of their own (GDAL takes it from the full resolution),
/// only the no-data value.
pub(crate) fn tags_of_level(level: usize, georeference: &Georeference) -> Result<Vec<Tag>, String> {
    if level == 0 { full_resolution_tags(georeference) } else { Ok(vec![no_data_tag()]) }
}
