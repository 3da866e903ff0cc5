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
//! tile_rows = "tms"       # or "xyz"; folders of tiles only (FOLDER.toml)
//! encoding = "terrarium"  # or "mapbox" or "gsi"; terrain-RGB only
//! interval_m = 0.1        # metres per step of "mapbox" or "gsi"
//! base_m = -10000.0       # height of the colour code 0 of "mapbox" or "gsi"
//! ```

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::georeference::{Crs, Georeference};
use super::place::{self, small_text, unclear};
use super::prj;
use super::samples::{Meaning, SampleType};
use super::tiff_sidecars::TiffSidecars;
use super::tile_json::TileJson;
use super::{Encoding, GeoKeys, HeightUnit, SourceError, TileRows, VoidMode, crs_catalogue as catalogue};
use crate::file::message::{quoted, shown};
use crate::file::toml_text;

/// The caller's description of a file that does not describe itself. It takes precedence over the sidecar file. Formats
/// that contain this information ignore it, with a warning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenOptions {
    /// Sample spacing in metres.
    pub spacing_m: Option<f64>,
    /// Columns and rows of a raw file.
    pub size: Option<[u32; 2]>,
    /// Metres per step of a 16-bit sample, or of a colour code.
    pub height_scale_m: Option<f64>,
    /// Height in metres of a sample or colour code of 0.
    pub height_offset_m: Option<f64>,
    /// Whether a raw file is big-endian.
    pub big_endian: Option<bool>,
    /// Encoding of heights in the colours of a picture.
    pub encoding: Option<Encoding>,
    /// Direction of the rows of tiles.
    pub tile_rows: Option<TileRows>,
    /// Unit of the heights of any format, unless the file declares another than metres.
    pub height_unit: Option<HeightUnit>,
    /// Additional no-data value for any format: a height in metres, or in `height_unit` if that is given.
    pub no_data: Option<f64>,
    /// Treatment of no-data; the default leaves holes, as in the file.
    pub voids: VoidMode,
}

impl OpenOptions {
    /// Returns whether the options change heights that a file declares completely.
    pub(crate) fn changes_heights(&self) -> bool {
        self.no_data.is_some() || self.height_unit.is_some_and(|unit| unit != HeightUnit::M)
    }

    /// Warns about the given options that a format does not use: all except those whose names are in `used`. `format` is
    /// the name of the format with its article.
    pub(crate) fn warn_unused(&self, path: &Path, format: &str, used: &[&str]) {
        let given = [
            ("--spacing", self.spacing_m.is_some()),
            ("--raw-size", self.size.is_some()),
            ("--height-scale", self.height_scale_m.is_some()),
            ("--height-offset", self.height_offset_m.is_some()),
            ("--raw-big-endian", self.big_endian.is_some()),
            ("--encoding", self.encoding.is_some()),
            ("--tile-rows", self.tile_rows.is_some()),
        ];
        let unused = given.into_iter().filter(|(name, is_given)| *is_given && !used.contains(name));
        let names: Vec<&str> = unused.map(|(name, _)| name).collect();
        if !names.is_empty() {
            let does = if names.len() == 1 { "does" } else { "do" };
            tracing::warn!("{}: {} {does} not apply to {format}; ignored", path.display(), names.join(", "));
        }
    }
}

/// Metres per degree of latitude.
const METRES_PER_DEGREE: f64 = 111_320.0;

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
    tile_rows: Option<TileRows>,
    interval_m: Option<f64>,
    base_m: Option<f64>,
}

/// The sidecar file of a file, combined with the caller's options.
#[derive(Clone, Debug)]
pub(super) struct RasterInfo {
    /// Path of the sidecar file, if it exists.
    pub sidecar_path: Option<PathBuf>,
    pub sidecar: Sidecar,
    /// The world file and the `.aux.xml`.
    found: TiffSidecars,
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
    ///
    /// # Errors
    /// Fails if the sidecar file is invalid, or if a spacing, in metres or degrees, a scale, an offset, a no-data value
    /// or an origin is not a usable number.
    pub(super) fn of(path: &Path, options: &OpenOptions) -> Result<Self, SourceError> {
        let sidecar_path = sidecar_path(path);
        let sidecar = match &sidecar_path {
            Some(sidecar_path) => {
                toml_text::read::<Sidecar>(&sidecar_path.to_string_lossy(), &small_text(sidecar_path)?)?
            }
            None => Sidecar::default(),
        };
        let found = if path.is_dir() { TiffSidecars::default() } else { TiffSidecars::of(path) };
        let info = Self { sidecar_path, sidecar, found, options: *options };
        info.check(path)?;
        Ok(info)
    }

    /// Checks the numbers of the sidecar file and of the options. Infinities would be no-data, or a grid without an end;
    /// a negative spacing would rotate the grid.
    fn check(&self, path: &Path) -> Result<(), SourceError> {
        let (own, given) = (&self.sidecar, &self.options);
        let spacings = [given.spacing_m, own.spacing_m, own.spacing_degrees];
        let scales = [given.height_scale_m, own.height_scale_m, own.interval_m];
        let [x, y] = own.origin.map_or([None; 2], |origin| origin.map(Some));
        let others = [given.height_offset_m, own.height_offset_m, own.base_m, given.no_data, own.no_data, x, y];
        let is_wrong = |number: f64| !number.is_finite();
        let cause = match () {
            () if spacings.into_iter().flatten().any(|it| is_wrong(it) || it <= 0.0) => {
                "its spacing must be a number above 0"
            }
            () if scales.into_iter().flatten().any(|it| is_wrong(it) || it == 0.0) => {
                "its height scale or interval must be a number other than 0"
            }
            () if others.into_iter().flatten().any(is_wrong) => {
                "its height offset, base, no-data value and origin must be finite numbers"
            }
            () => return Ok(()),
        };
        let file = self.sidecar_path.as_ref().and_then(|path| path.file_name());
        let file = file.map_or_else(String::new, |name| format!(" (see {})", shown(&name.to_string_lossy())));
        Err(unclear(path, format!("{cause}{file}")))
    }

    /// Returns the columns and rows of a raw file.
    pub(super) fn size(&self) -> Option<[u32; 2]> {
        self.options.size.or_else(|| Some([self.sidecar.width?, self.sidecar.height?]))
    }

    /// Returns whether the caller gives the columns and rows of a raw file.
    pub(super) fn is_size_given(&self) -> bool {
        self.options.size.is_some()
    }

    /// Returns whether a raw file is big-endian, if it is given.
    pub(super) fn is_big_endian(&self) -> Option<bool> {
        self.options.big_endian.or_else(|| self.sidecar.endian.map(|endian| endian == Endian::Big))
    }

    /// Returns the encoding of heights in colours, if it is given.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        self.options.encoding.or(self.sidecar.encoding)
    }

    /// Returns the direction of the rows of tiles, if it is given.
    pub(super) fn tile_rows(&self) -> Option<TileRows> {
        self.options.tile_rows.or(self.sidecar.tile_rows)
    }

    /// Adds what a description of tiles declares, unless the caller or the sidecar file says otherwise.
    pub(super) fn declare(&mut self, described: &TileJson) {
        if self.encoding().is_none() {
            self.sidecar.encoding = described.encoding;
            self.sidecar.interval_m = self.sidecar.interval_m.or(described.interval_m);
            self.sidecar.base_m = self.sidecar.base_m.or(described.base_m);
        }
    }

    /// Returns metres per step, if it is given.
    pub(super) fn height_scale_m(&self) -> Option<f64> {
        self.options.height_scale_m.or(self.sidecar.height_scale_m)
    }

    /// Returns metres per step of a colour code, if it is given.
    pub(super) fn colour_interval_m(&self) -> Option<f64> {
        self.options.height_scale_m.or(self.sidecar.interval_m).or(self.sidecar.height_scale_m)
    }

    /// Returns the height in metres of the colour code 0, if it is given.
    pub(super) fn colour_base_m(&self) -> Option<f64> {
        self.options.height_offset_m.or(self.sidecar.base_m).or(self.sidecar.height_offset_m)
    }

    /// Returns the distance between samples in metres, if it is given.
    pub(super) fn spacing_m(&self) -> Option<f64> {
        self.options.spacing_m.or(self.sidecar.spacing_m)
    }

    /// Returns the meaning of samples that are steps of a height, with a warning if their size is not given.
    pub(super) fn meaning(&self, path: &Path, sample_type: SampleType) -> Meaning {
        let mut meaning = Meaning::metres(sample_type, None);
        self.found.overrule(&mut meaning);
        self.found.warn_of_unit(path);
        if let Some(scale_m) = self.height_scale_m() {
            (meaning.scale, meaning.metres_per_unit, meaning.has_unit) = (scale_m, 1.0, false);
        } else if !self.found.knows_steps() {
            let name = path.display();
            tracing::warn!("{name}: has no height scale; 1 m per step is assumed (set height_scale_m in {name}.toml)");
        }
        if let Some(offset_m) = self.options.height_offset_m.or(self.sidecar.height_offset_m) {
            meaning.offset = offset_m / meaning.metres_per_unit;
        }
        meaning.no_data = self.sidecar.no_data.or(meaning.no_data);
        meaning
    }

    /// Returns the distance between samples on the ground in metres, if a sidecar file gives it.
    pub(super) fn spacing_beside_m(&self) -> Option<f64> {
        let of_place = |[x, a, _, _, c, _]: [f64; 6]| {
            let step = a.hypot(c);
            // Steps of a hundredth on the globe are degrees, not centimetres.
            let is_degrees = step < 0.02 && x.abs() <= 360.0;
            if is_degrees { step * METRES_PER_DEGREE } else { step }
        };
        let degrees = self.sidecar.spacing_degrees.map(|degrees| degrees * METRES_PER_DEGREE);
        self.spacing_m().or(degrees).or_else(|| self.found.own_place().map(of_place))
    }

    /// Returns whether anything gives the position of the grid: the `.toml`, a world file or an `.aux.xml`.
    pub(super) fn is_located(&self) -> bool {
        self.sidecar.origin.is_some() || self.found.own_place().is_some()
    }

    /// Returns the georeference of the grid: that of the `.toml` or the options, or of a world file or `.aux.xml`.
    pub(super) fn georeference(&self, path: &Path, size: [u32; 2]) -> Result<Georeference, SourceError> {
        if self.sidecar.origin.is_none()
            && let Some(place) = self.found.own_place()
        {
            return self.georeference_beside(path, place, size);
        }
        if self.sidecar.crs.is_some() && self.sidecar.origin.is_none() {
            return Err(unclear(path, "its sidecar file has a crs, but no origin = [x, y]"));
        }
        let (keys, metres_per_unit) = match &self.sidecar.crs {
            Some(crs) => crs_keys(path, crs)?,
            None => (place::local_metres(), Some(1.0)),
        };
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

    /// Returns the georeference of a world file or `.aux.xml`; a spacing that is given replaces theirs.
    fn georeference_beside(&self, path: &Path, place: [f64; 6], size: [u32; 2]) -> Result<Georeference, SourceError> {
        let keys = match (&self.sidecar.crs, self.found.geokeys()) {
            (Some(crs), _) => crs_keys(path, crs)?.0,
            (None, Some(keys)) => keys.clone(),
            (None, None) => prj::keys(path, place, size)?.0,
        };
        let georeference = place::locate(path, place, keys, size)?;
        let Some(spacing_m) = self.spacing_m() else { return Ok(georeference) };
        let unit = match georeference.crs {
            Crs::Local => 1.0,
            Crs::Projected { metres_per_unit, .. } => metres_per_unit,
            Crs::Geographic { .. } => {
                tracing::warn!("{}: its spacing is in degrees; that in metres is ignored", path.display());
                return Ok(georeference);
            }
        };
        let [x, a, b, y, c, d] = place;
        let [columns, rows] = [spacing_m / unit / a.hypot(c), spacing_m / unit / b.hypot(d)];
        place::locate(path, [x, a * columns, b * rows, y, c * columns, d * rows], georeference.geokeys, size)
    }

    /// Returns what the heights depend on: the file, its sidecar files and the options.
    pub(super) fn identity(&self, path: &Path) -> String {
        let prj = self.found.own_place().and_then(|_| place::sibling(path, "prj"));
        let sidecars = self.sidecar_path.iter().chain(&self.found.files).chain(&prj).map(PathBuf::as_path);
        let files: Vec<&Path> = std::iter::once(path).chain(sidecars).collect();
        place::identity(&files, &format!("{:?}", OpenOptions { voids: VoidMode::default(), ..self.options }))
    }
}

/// Returns the keys of a CRS of a sidecar file, and metres per unit; `None` for degrees.
fn crs_keys(path: &Path, crs: &str) -> Result<(GeoKeys, Option<f64>), SourceError> {
    let definition = place::code_of(crs).and_then(|code| Some((code, catalogue::look_up(code)?)));
    let (code, definition) =
        definition.ok_or_else(|| unclear(path, format!("the crs {} in its sidecar file is unknown", quoted(crs))))?;
    match definition.kind {
        catalogue::Kind::Projected => Ok((place::epsg(code, false), Some(definition.unit))),
        catalogue::Kind::Geographic => Ok((place::epsg(code, true), None)),
        catalogue::Kind::Geocentric => {
            Err(unclear(path, format!("the crs {} in its sidecar file is geocentric", quoted(crs))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_cannot_be_used_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.r16");
        let read = |text: &str, options: &OpenOptions| {
            crate::file::atomic::write(&folder.path().join("a.r16.toml"), text.as_bytes()).unwrap();
            RasterInfo::of(&path, options).map(drop).map_err(|error| error.to_string())
        };
        let none = OpenOptions::default();
        for (text, cause) in [
            ("spacing_m = -30", "spacing must be a number above 0"),
            ("spacing_m = 0", "spacing must be a number above 0"),
            ("spacing_degrees = -0.1", "spacing must be a number above 0"),
            ("spacing_degrees = inf", "spacing must be a number above 0"),
            ("height_scale_m = 0.0", "other than 0"),
            ("interval_m = nan", "other than 0"),
            ("height_offset_m = nan", "must be finite"),
            ("base_m = inf", "must be finite"),
            ("no_data = nan", "must be finite"),
            ("origin = [0, nan]", "must be finite"),
        ] {
            let error = read(text, &none).unwrap_err();
            assert!(error.contains(cause) && error.contains("(see a.r16.toml)"), "{text}: {error}");
        }
        let valid = "spacing_m = 30\nheight_scale_m = -0.1\nheight_offset_m = -5\nno_data = 0\norigin = [-1, 0]";
        assert_eq!(read(valid, &none), Ok(()));
        assert!(read(valid, &OpenOptions { spacing_m: Some(-1.0), ..none }).is_err());
        assert!(read(valid, &OpenOptions { height_offset_m: Some(f64::NAN), ..none }).is_err());
    }
}
