//! Information about a picture or raw file that does not describe itself: the sidecar file `NAME.ext.toml`, and the
//! options of the caller.
//!
//! ```toml
//! width = 4097            # raw files only
//! height = 4097
//! spacing_m = 2.5         # between samples; spacing_degrees in a geographic CRS
//! height_scale_m = 0.1    # metres per step
//! height_offset_m = -50.0 # height of step 0
//! endian = "little"       # or "big"; raw files only
//! no_data = 0             # in steps
//! crs = "EPSG:32610"
//! origin = [594000.0, 5195000.0] # centre of the first sample, in the CRS
//! encoding = "terrarium"  # or "mapbox"; terrain-RGB only
//! interval_m = 0.1        # metres per step of "mapbox"
//! ```

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::georeference::Georeference;
use super::place::{self, small_text, unclear};
use super::{GeoKeys, SourceError, VoidMode, crs_catalogue as catalogue};
use crate::file::message::quoted;
use crate::file::toml_text;

/// The caller's description of a file that does not describe itself. It takes precedence over the sidecar file. Formats
/// that contain this information ignore it, with a warning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenOptions {
    /// Sample spacing in metres.
    pub spacing_m: Option<f64>,
    /// Columns and rows of a raw file.
    pub size: Option<[u32; 2]>,
    /// Metres per step of a 16-bit sample.
    pub height_scale_m: Option<f64>,
    /// Height in metres of a sample of 0.
    pub height_offset_m: Option<f64>,
    /// Whether a raw file is big-endian.
    pub big_endian: Option<bool>,
    /// Encoding of heights in the colours of a picture.
    pub encoding: Option<Encoding>,
    /// Additional no-data value for any format, as a height in metres.
    pub no_data: Option<f64>,
    /// Treatment of no-data; the default leaves holes, as in the file.
    pub voids: VoidMode,
}

impl OpenOptions {
    /// Returns the names of the given options that only PNG and raw files need.
    pub(super) fn for_heightmaps(&self) -> Vec<&'static str> {
        let given = [
            ("spacing", self.spacing_m.is_some()),
            ("size", self.size.is_some()),
            ("height scale", self.height_scale_m.is_some()),
            ("height offset", self.height_offset_m.is_some()),
            ("byte order", self.big_endian.is_some()),
            ("encoding", self.encoding.is_some()),
        ];
        given.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name).collect()
    }
}

/// The encodings of heights in the colours of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// (red × 256 + green + blue / 256) − 32768 metres.
    Terrarium,
    /// −10000 + (red × 65536 + green × 256 + blue) × 0.1 metres.
    Mapbox,
}

impl Encoding {
    pub const ALL: [Self; 2] = [Self::Mapbox, Self::Terrarium];

    /// Returns the name that options and sidecar files use.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Terrarium => "terrarium",
            Self::Mapbox => "mapbox",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Endian {
    Little,
    Big,
}

/// The sidecar file of a picture or raw file. Unknown keys are an error, because they would otherwise be ignored
/// silently.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sidecar {
    width: Option<u32>,
    height: Option<u32>,
    spacing_m: Option<f64>,
    spacing_degrees: Option<f64>,
    height_scale_m: Option<f64>,
    height_offset_m: Option<f64>,
    endian: Option<Endian>,
    pub no_data: Option<f64>,
    crs: Option<String>,
    origin: Option<[f64; 2]>,
    encoding: Option<Encoding>,
    pub interval_m: Option<f64>,
}

/// The sidecar file of a file, combined with the caller's options.
#[derive(Clone, Debug)]
pub(super) struct RasterInfo {
    /// Path of the sidecar file, if it exists.
    pub sidecar_path: Option<PathBuf>,
    pub sidecar: Sidecar,
    options: OpenOptions,
}

/// Returns the path of the sidecar file `NAME.ext.toml` of `NAME.ext`, if it exists.
pub(super) fn sidecar_path(path: &Path) -> Option<PathBuf> {
    let mut name = path.as_os_str().to_owned();
    name.push(".toml");
    Some(PathBuf::from(name)).filter(|path| path.is_file())
}

impl RasterInfo {
    /// Reads the sidecar file, if it exists.
    pub(super) fn of(path: &Path, options: &OpenOptions) -> Result<Self, SourceError> {
        let sidecar_path = sidecar_path(path);
        let sidecar = match &sidecar_path {
            Some(sidecar_path) => {
                toml_text::read::<Sidecar>(&sidecar_path.to_string_lossy(), &small_text(sidecar_path)?)?
            }
            None => Sidecar::default(),
        };
        let info = Self { sidecar_path, sidecar, options: *options };
        let numbers = [info.spacing_m(), info.sidecar.spacing_degrees, info.sidecar.interval_m, info.height_scale_m()];
        if numbers.into_iter().flatten().any(|number| !number.is_finite() || number == 0.0) {
            return Err(unclear(path, "its spacing and its height scale must be numbers other than 0"));
        }
        Ok(info)
    }

    /// Returns the columns and rows of a raw file.
    pub(super) fn size(&self) -> Option<[u32; 2]> {
        self.options.size.or_else(|| Some([self.sidecar.width?, self.sidecar.height?]))
    }

    /// Returns whether a raw file is big-endian, if it is given.
    pub(super) fn is_big_endian(&self) -> Option<bool> {
        self.options.big_endian.or_else(|| self.sidecar.endian.map(|endian| endian == Endian::Big))
    }

    /// Returns the encoding of heights in colours, if it is given.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        self.options.encoding.or(self.sidecar.encoding)
    }

    /// Returns metres per step, if it is given.
    pub(super) fn height_scale_m(&self) -> Option<f64> {
        self.options.height_scale_m.or(self.sidecar.height_scale_m)
    }

    /// Returns the height in metres of a sample of 0.
    pub(super) fn height_offset_m(&self) -> f64 {
        self.options.height_offset_m.or(self.sidecar.height_offset_m).unwrap_or(0.0)
    }

    fn spacing_m(&self) -> Option<f64> {
        self.options.spacing_m.or(self.sidecar.spacing_m)
    }

    /// Returns scale and offset of 16-bit steps, with a warning if the scale is not given.
    pub(super) fn steps(&self, path: &Path) -> [f64; 2] {
        let scale_m = self.height_scale_m().unwrap_or_else(|| {
            let name = path.display();
            tracing::warn!("{name}: has no height scale; 1 m per step is assumed (set height_scale_m in {name}.toml)");
            1.0
        });
        [scale_m, self.height_offset_m()]
    }

    /// Returns the georeference of the grid.
    pub(super) fn georeference(&self, path: &Path, size: [u32; 2]) -> Result<Georeference, SourceError> {
        let (keys, metres_per_unit) = self.crs_keys(path)?;
        let step = match (metres_per_unit, self.spacing_m(), self.sidecar.spacing_degrees) {
            (None, _, Some(degrees)) => degrees,
            (None, _, None) => return Err(unclear(path, "a geographic CRS needs spacing_degrees in its sidecar file")),
            (Some(unit), Some(spacing_m), _) => spacing_m / unit,
            (Some(unit), None, _) => {
                let name = path.display();
                tracing::warn!("{name}: has no sample spacing; 1 m is assumed (set spacing_m in {name}.toml)");
                1.0 / unit
            }
        };
        let first = self.sidecar.origin.unwrap_or_default();
        place::locate(path, place::north_up(first, [step; 2]), keys, size)
    }

    /// Returns the keys of the CRS, and metres per unit; `None` for degrees.
    fn crs_keys(&self, path: &Path) -> Result<(GeoKeys, Option<f64>), SourceError> {
        let Some(crs) = &self.sidecar.crs else { return Ok((place::local_metres(), Some(1.0))) };
        if self.sidecar.origin.is_none() {
            return Err(unclear(path, "its sidecar file has a crs, but no origin = [x, y]"));
        }
        let code = crs.to_ascii_uppercase().strip_prefix("EPSG:").and_then(|code| code.parse().ok());
        let definition = code.and_then(|code| Some((code, catalogue::look_up(code)?)));
        let (code, definition) = definition
            .ok_or_else(|| unclear(path, format!("the crs {} in its sidecar file is unknown", quoted(crs))))?;
        match definition.kind {
            catalogue::Kind::Projected => Ok((place::epsg(code, false), Some(definition.unit))),
            catalogue::Kind::Geographic => Ok((place::epsg(code, true), None)),
            catalogue::Kind::Geocentric => {
                Err(unclear(path, format!("the crs {} in its sidecar file is geocentric", quoted(crs))))
            }
        }
    }

    /// Returns what the heights depend on: the file, its sidecar file and the options.
    pub(super) fn identity(&self, path: &Path) -> String {
        let files: Vec<&Path> = std::iter::once(path).chain(self.sidecar_path.as_deref()).collect();
        place::identity(&files, &format!("{:?}", OpenOptions { voids: VoidMode::default(), ..self.options }))
    }
}
