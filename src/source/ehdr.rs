//! ESRI rasters with a separate header: BIL, BIP, BSQ and GridFloat (`dem.bil` or `dem.flt`, and `dem.hdr`).
//!
//! Each line of the header has a keyword and a value, in any order and case ("BIL, BIP, and BSQ raster files" and
//! "Float to Raster", ArcGIS Desktop help). Missing entries have the same defaults as in GDAL: samples are unsigned
//! (signed if the no-data value is negative) and big-endian. ULXMAP and ULYMAP are the centre of the first sample;
//! XLLCORNER and YLLCORNER are the outer corner of the first sample of the last row.

use std::path::{Path, PathBuf};

use super::SourceError;
use super::flat::{Description, FlatReader, Strides};
use super::place::{self, cannot_open, ending, inconsistent, small_text};
use super::prj;
use super::samples::{Meaning, SampleType, parse_no_data};
use super::text::number;
use super::tiff_sidecars::from_world_file;
use crate::file::message::quoted;

/// Extensions of data files; the data of a header is searched with these.
pub(super) const DATA_ENDINGS: [&str; 9] = ["bil", "flt", "bsq", "bip", "bin", "dem", "img", "dat", "raw"];

/// The keywords of a header with their values.
struct Fields<'a> {
    path: &'a Path,
    fields: Vec<(String, String)>,
}

impl<'a> Fields<'a> {
    fn parse(path: &'a Path, text: &str) -> Self {
        let fields = text.lines().filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_ascii_lowercase(), words.next()?.to_ascii_lowercase()))
        });
        Self { path, fields: fields.collect() }
    }

    fn text(&self, names: &[&str]) -> Option<&str> {
        self.fields.iter().find(|(name, _)| names.contains(&name.as_str())).map(|(_, value)| value.as_str())
    }

    fn number(&self, names: &[&str]) -> Result<Option<f64>, SourceError> {
        let Some(text) = self.text(names) else { return Ok(None) };
        let number = number(text).filter(|number| number.is_finite());
        number.map(Some).ok_or_else(|| inconsistent(self.path, format!("its {} is {}", names[0], quoted(&text))))
    }

    fn whole(&self, names: &[&str]) -> Result<Option<u64>, SourceError> {
        let Some(number) = self.number(names)? else { return Ok(None) };
        // 2^53, up to which an f64 is exact.
        match number.fract() == 0.0 && (0.0..9.0e15).contains(&number) {
            true => Ok(Some(number as u64)),
            false => Err(inconsistent(self.path, format!("its {} is {number:?}", names[0]))),
        }
    }
}

/// Returns whether a text is the header of such a file.
pub(super) fn is_header(text: &str) -> bool {
    let fields = Fields::parse(Path::new(""), text);
    fields.text(&["nrows", "rows"]).is_some() && fields.text(&["ncols", "cols"]).is_some()
}

/// Opens the data with its header.
pub(super) fn open(data: &Path, header: &Path) -> Result<FlatReader, SourceError> {
    let text = small_text(header)?;
    let fields = Fields::parse(header, &text);
    let count = |names: &[&str]| match fields.whole(names)? {
        Some(count) if (1..=u64::from(u32::MAX)).contains(&count) => Ok(count as u32),
        Some(count) => Err(inconsistent(header, format!("its {} is {count}", names[0]))),
        None => Err(inconsistent(header, format!("its {} is missing", names[0]))),
    };
    let size = [count(&["ncols", "cols"])?, count(&["nrows", "rows"])?];
    place::check_size(data, size)?;
    let bands = fields.whole(&["nbands", "bands"])?.unwrap_or(1).max(1);
    let no_data_names = ["nodata_value", "nodata"];
    let no_data = fields.text(&no_data_names).and_then(parse_no_data);
    let sample_type = sample_type(data, &fields, size, bands, no_data)?;
    let meaning = Meaning::metres(sample_type, no_data);

    let is_big_endian = match fields.text(&["byteorder"]) {
        Some(order) => order.starts_with('m'),
        None => {
            tracing::warn!("{}: has no byte order; big-endian is assumed", header.display());
            true
        }
    };
    let strides = strides(&fields, size, bands, sample_type.bytes() as u64)?;
    let (crs_from_grid, world) = crs_from_grid(data, &fields, size)?;
    let (keys, prj) = match (fields.text(&["projection"]), fields.text(&["datum"])) {
        (Some("geographic"), Some("wgs84")) => (place::wgs84(), None),
        _ => prj::keys(data, crs_from_grid, size)?,
    };
    let files: Vec<&Path> = [data, header].into_iter().chain(prj.as_deref()).chain(world.as_deref()).collect();
    let georeference = place::locate(data, crs_from_grid, keys, size)?;
    let identity = place::identity(&files, "");
    FlatReader::new(data, None, Description { size, strides, is_big_endian, meaning, georeference, identity })
}

fn sample_type(
    data: &Path,
    fields: &Fields<'_>,
    [width, height]: [u32; 2],
    bands: u64,
    no_data: Option<f64>,
) -> Result<SampleType, SourceError> {
    let is_float_file = ending(data) == "flt";
    let bits = match fields.whole(&["nbits"])? {
        Some(bits) => bits,
        None if is_float_file => 32,
        None => {
            let bytes = std::fs::metadata(data).map_err(cannot_open(data))?.len();
            let samples = u64::from(width).saturating_mul(height.into()).saturating_mul(bands);
            bytes / samples * 8
        }
    };
    let kind = match fields.text(&["pixeltype"]) {
        Some(kind) => kind,
        None if bits == 32 && (is_float_file || fields.text(&["nbits"]).is_none()) => "float",
        None if no_data.is_some_and(|no_data| no_data < 0.0) => "signedint",
        None => "unsignedint",
    };
    let format = match kind.as_bytes().first() {
        Some(b'f') => 3,
        Some(b's') => 2,
        _ => 1,
    };
    (bits % 8 == 0).then_some(bits / 8).and_then(|bytes| SampleType::from_format(format, bytes as usize)).ok_or_else(
        || SourceError::Unsupported { path: data.into(), what: format!("a sample of {bits} bits ({kind:?})") },
    )
}

fn strides(
    fields: &Fields<'_>,
    [width, height]: [u32; 2],
    bands: u64,
    sample_bytes: u64,
) -> Result<Strides, SourceError> {
    let offset = fields.whole(&["skipbytes"])?.unwrap_or(0);
    let row_of_band = u64::from(width) * sample_bytes;
    let band_row = fields.whole(&["bandrowbytes"])?;
    let total_row = fields.whole(&["totalrowbytes"])?;
    let too_large = || inconsistent(fields.path, "its rows are longer than any file");
    let all_bands = |bytes: u64| bytes.checked_mul(bands).ok_or_else(too_large);
    // An offset beyond the end of the file is caught by the check of its length.
    match fields.text(&["layout"]).unwrap_or("bil") {
        "bip" => Ok(Strides {
            offset,
            row: total_row.map_or_else(|| all_bands(row_of_band), Ok)?,
            sample: all_bands(sample_bytes)?,
        }),
        "bsq" => {
            let row = match bands {
                1 => total_row.or(band_row).unwrap_or(row_of_band),
                _ => row_of_band,
            };
            u64::from(height).checked_mul(row).ok_or_else(too_large)?;
            Ok(Strides { offset, row, sample: sample_bytes })
        }
        _ => {
            let row = total_row.map_or_else(|| all_bands(band_row.unwrap_or(row_of_band)), Ok)?;
            Ok(Strides { offset, row, sample: sample_bytes })
        }
    }
}

/// Returns the place of the samples, and the world file if it gives that place because the header does not.
fn crs_from_grid(
    data: &Path,
    fields: &Fields<'_>,
    [_, height]: [u32; 2],
) -> Result<([f64; 6], Option<PathBuf>), SourceError> {
    let cell = fields.number(&["cellsize"])?;
    let step = [fields.number(&["xdim"])?.or(cell), fields.number(&["ydim"])?.or(cell)];
    let rows = f64::from(height) - 1.0;
    let first = |axis: usize, upper_left: &str, corner: &str, centre: &str| {
        let step = step[axis].unwrap_or(1.0);
        let to_top = if axis == 1 { rows * step } else { 0.0 };
        Ok::<_, SourceError>(
            match (fields.number(&[upper_left])?, fields.number(&[corner])?, fields.number(&[centre])?) {
                (Some(first), ..) => Some(first),
                (None, Some(corner), _) => Some(corner + 0.5 * step + to_top),
                (None, None, Some(centre)) => Some(centre + to_top),
                (None, None, None) => None,
            },
        )
    };
    let place = [first(0, "ulxmap", "xllcorner", "xllcenter")?, first(1, "ulymap", "yllcorner", "yllcenter")?];
    match (place, step) {
        ([Some(x), Some(y)], [dx, dy]) => Ok((place::north_up([x, y], [dx.unwrap_or(1.0), dy.unwrap_or(1.0)]), None)),
        (_, [dx, dy]) => {
            if let Some((place, world)) = from_world_file(data) {
                return Ok((place, Some(world)));
            }
            tracing::warn!("{}: has no georeference", fields.path.display());
            Ok((place::north_up([0.0, rows], [dx.unwrap_or(1.0), dy.unwrap_or(1.0)]), None))
        }
    }
}

/// Returns the data file of a header, or the header of a data file: either may be named.
pub(super) fn partner(path: &Path) -> Option<PathBuf> {
    let ending = ending(path);
    if ending != "hdr" {
        return DATA_ENDINGS.contains(&&*ending).then(|| place::sibling(path, "hdr")).flatten();
    }
    let bare = path.with_extension("");
    let named = DATA_ENDINGS.iter().find_map(|data| place::sibling(path, data));
    named.or_else(|| Some(bare).filter(|bare| bare.is_file()))
}
