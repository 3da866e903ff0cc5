//! The GeoTIFF keys of a file, stored unchanged so that pyramids baked from it can carry the same reference system.

use geotiff_reader::geokeys as upstream;
use serde::{Deserialize, Serialize};

pub(super) const MODEL_TYPE: u16 = 1024;
pub(super) const RASTER_TYPE: u16 = 1025;
pub(super) const CITATION: u16 = 1026;
pub(super) const GEOGRAPHIC_CRS: u16 = 2048;
pub(super) const GEOGRAPHIC_CITATION: u16 = 2049;
pub(super) const GEOGRAPHIC_DATUM: u16 = 2050;
pub(super) const PRIME_MERIDIAN: u16 = 2051;
pub(super) const PRIME_MERIDIAN_LONGITUDE: u16 = 2061;
pub(super) const ELLIPSOID: u16 = 2056;
pub(super) const PROJECTION: u16 = 3074;
pub(super) const PROJECTION_METHOD: u16 = 3075;
pub(super) const ANGULAR_UNITS: u16 = 2054;
pub(super) const ANGULAR_UNIT_SIZE: u16 = 2055;
pub(super) const SEMI_MAJOR_AXIS: u16 = 2057;
pub(super) const SEMI_MINOR_AXIS: u16 = 2058;
pub(super) const INVERSE_FLATTENING: u16 = 2059;
pub(super) const PROJECTED_CRS: u16 = 3072;
pub(super) const PROJECTED_CITATION: u16 = 3073;
pub(super) const LINEAR_UNITS: u16 = 3076;
pub(super) const LINEAR_UNIT_SIZE: u16 = 3077;
pub(super) const VERTICAL_CRS: u16 = 4096;
pub(super) const VERTICAL_CITATION: u16 = 4097;
pub(super) const VERTICAL_DATUM: u16 = 4098;
pub(super) const VERTICAL_UNITS: u16 = 4099;

/// The code by which a key says "user-defined".
pub(super) const USER_DEFINED: u16 = 32767;
pub(super) const METRE: u16 = 9001;
pub(super) const DEGREE: u16 = 9102;

/// The keys of a GeoTIFF; empty for a file without keys.
///
/// To write them with `geotiff-writer`, call `builder.geokey(key.id, (&key.value).into())` for each of `keys`.
///
/// Only the vertical unit may differ from the file: heights are converted to metres, so the keys say metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GeoKeys {
    /// EPSG code of the horizontal CRS, if the file gives one.
    pub epsg: Option<u32>,
    /// GTModelTypeGeoKey: 1 projected, 2 geographic, 3 geocentric.
    pub model_type: Option<u16>,
    /// GTRasterTypeGeoKey: 1 a pixel is an area, 2 a pixel is a point. It is the meaning of the *file's* tie point;
    /// `Georeference::crs_from_grid` has taken it into account already.
    pub raster_type: Option<u16>,
    /// All keys, including those above, in the file's order.
    pub keys: Vec<GeoKey>,
}

/// A GeoKey: an entry of the GeoKeyDirectory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GeoKey {
    /// Key number of the GeoTIFF standard.
    pub id: u16,
    pub value: GeoKeyValue,
}

/// The value of a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GeoKeyValue {
    Short(u16),
    /// Numbers, usually one.
    Double(Vec<f64>),
    /// ASCII text without the `|` that ends it in the file.
    Ascii(String),
}

impl GeoKeys {
    /// Parses the values of the tags 34735 (directory), 34736 (doubles) and 34737 (ASCII). A directory that cannot be
    /// parsed gives no keys.
    #[must_use]
    pub fn parse(directory: &[u16], doubles: &[f64], ascii: &str) -> Self {
        let Some(parsed) = upstream::GeoKeyDirectory::parse(directory, doubles, ascii) else {
            return Self::default();
        };
        Self::from_keys(parsed.keys.into_iter().map(|key| GeoKey { id: key.id, value: key.value.into() }).collect())
    }

    /// Builds the keys of a CRS that comes from another source than a GeoTIFF.
    pub(super) fn from_keys(keys: Vec<GeoKey>) -> Self {
        let mut this = Self { keys, ..Self::default() };
        this.model_type = this.short(MODEL_TYPE);
        this.raster_type = this.short(RASTER_TYPE);
        let code = |id| this.short(id).filter(|&code| code != 0 && code != USER_DEFINED);
        this.epsg = match this.model_type {
            Some(1) => code(PROJECTED_CRS),
            Some(2 | 3) => code(GEOGRAPHIC_CRS),
            _ => code(PROJECTED_CRS).or_else(|| code(GEOGRAPHIC_CRS)),
        }
        .map(u32::from);
        this
    }

    /// Returns the code that key `id` holds.
    #[must_use]
    pub(crate) fn short(&self, id: u16) -> Option<u16> {
        match self.value(id)? {
            GeoKeyValue::Short(code) => Some(*code),
            _ => None,
        }
    }

    /// Returns the first number that key `id` holds.
    #[must_use]
    pub(crate) fn double(&self, id: u16) -> Option<f64> {
        match self.value(id)? {
            GeoKeyValue::Double(values) => values.first().copied(),
            _ => None,
        }
    }

    /// Returns the text that key `id` holds.
    #[must_use]
    pub(crate) fn ascii(&self, id: u16) -> Option<&str> {
        match self.value(id)? {
            GeoKeyValue::Ascii(text) => Some(text),
            _ => None,
        }
    }

    /// Declares metres as the vertical unit, after the heights have been converted. A vertical CRS in feet has no code
    /// for its metric equivalent, so its code and citation are removed.
    pub(super) fn declare_vertical_metres(&mut self) {
        self.keys.retain(|key| ![VERTICAL_CRS, VERTICAL_CITATION, VERTICAL_DATUM, VERTICAL_UNITS].contains(&key.id));
        self.keys.push(GeoKey { id: VERTICAL_UNITS, value: GeoKeyValue::Short(METRE) });
    }

    fn value(&self, id: u16) -> Option<&GeoKeyValue> {
        self.keys.iter().find(|key| key.id == id).map(|key| &key.value)
    }
}

impl GeoKey {
    pub(super) fn short(id: u16, code: u16) -> Self {
        Self { id, value: GeoKeyValue::Short(code) }
    }

    pub(super) fn double(id: u16, value: f64) -> Self {
        Self { id, value: GeoKeyValue::Double(vec![value]) }
    }

    /// Builds a text key; characters that a GeoTIFF cannot hold are left out.
    pub(super) fn ascii(id: u16, text: &str) -> Self {
        Self { id, value: upstream::GeoKeyValue::Ascii(text.to_owned()).into() }
    }
}

impl From<upstream::GeoKeyValue> for GeoKeyValue {
    fn from(value: upstream::GeoKeyValue) -> Self {
        match value {
            upstream::GeoKeyValue::Short(code) => Self::Short(code),
            upstream::GeoKeyValue::Double(values) => Self::Double(values),
            // Writers reject other characters, and `|` ends a value in the file.
            upstream::GeoKeyValue::Ascii(text) => {
                Self::Ascii(text.chars().filter(char::is_ascii).map(|c| if c == '|' { ';' } else { c }).collect())
            }
        }
    }
}

impl From<&GeoKeyValue> for upstream::GeoKeyValue {
    fn from(value: &GeoKeyValue) -> Self {
        match value {
            GeoKeyValue::Short(code) => Self::Short(*code),
            GeoKeyValue::Double(values) => Self::Double(values.clone()),
            GeoKeyValue::Ascii(text) => Self::Ascii(text.clone()),
        }
    }
}
