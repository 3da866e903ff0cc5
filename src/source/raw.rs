//! Raw heightmaps (`.r16`, `.raw`): unsigned 16-bit samples by rows without a header, as game engines and World Machine
//! write them. Size, byte order, spacing and scale come from a sidecar file or from options.

use std::path::Path;

use super::SourceError;
use super::flat::{Description, FlatReader, Strides};
use super::place::{self, cannot_open};
use super::samples::SampleType;
use super::sidecar::RasterInfo;

/// Opens a file without a header.
pub(super) fn open(path: &Path, info: &RasterInfo) -> Result<FlatReader, SourceError> {
    let bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    let size = match info.size() {
        Some(size) => size,
        None => square(path, bytes)?,
    };
    place::check_size(path, size)?;
    let [width, height] = size;
    let needed = u64::from(width).saturating_mul(height.into()).saturating_mul(2);
    if bytes < needed {
        let check = match info.is_size_given() {
            true => "--raw-size".to_owned(),
            false => format!("width and height in {}.toml", path.display()),
        };
        let why = format!("{width}×{height} samples need {needed} bytes, but the file has {bytes}; check {check}");
        return Err(SourceError::Unclear { path: path.into(), why });
    }
    if bytes > needed {
        tracing::warn!("{}: is {} bytes longer than {width}×{height} samples", path.display(), bytes - needed);
    }
    let is_big_endian = info.is_big_endian().unwrap_or_else(|| {
        tracing::warn!("{}: its byte order is not given; little-endian is assumed", path.display());
        false
    });
    let meaning = info.meaning(path, SampleType::U16);
    let described = Description {
        size,
        strides: Strides { offset: 0, row: u64::from(width) * 2, sample: 2 },
        is_big_endian,
        meaning,
        georeference: info.georeference(path, size)?,
        identity: info.identity(path),
    };
    FlatReader::new(path, None, described)
}

/// Returns the size of a square with this number of bytes, with a warning that it is a guess.
fn square(path: &Path, bytes: u64) -> Result<[u32; 2], SourceError> {
    let side = (bytes / 2).isqrt();
    match u32::try_from(side) {
        Ok(short) if side * side * 2 == bytes => {
            tracing::warn!("{}: its size is not given; {side}×{side} samples are assumed", path.display());
            Ok([short; 2])
        }
        _ => {
            let name = path.display();
            let why = format!(
                "its size is unknown, and {bytes} bytes are not a square of samples; set width and height in {name}.toml"
            );
            Err(SourceError::Unclear { path: path.into(), why })
        }
    }
}
