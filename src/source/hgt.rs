//! SRTM tiles: `N46E008.hgt`, alone or in a ZIP archive.
//!
//! A tile is a square degree of big-endian 16-bit metres, without any header. 1201 × 1201 samples are 3″ apart, 3601 ×
//! 3601 are 1″ apart, and 1801 × 3601 are 2″ × 1″ apart (beyond 50° of latitude); samples are on the degree's edges.
//! The name gives the lower left corner, -32768 is no-data, longitude and latitude are on WGS 84. "The Shuttle Radar
//! Topography Mission (SRTM) Collection User Guide", NASA LP DAAC, 2015, sections 2.1.2 and 2.2.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::SourceError;
use super::flat::{Description, FlatReader, Strides};
use super::place::{self, cannot_open, foreign_message, inconsistent, unclear};
use super::samples::{Meaning, SampleType};
use crate::file::message::{quoted, shown};

/// The existing sizes of tiles.
const SIZES: [[u32; 2]; 3] = [[1201, 1201], [1801, 3601], [3601, 3601]];

/// The largest tile in bytes.
const MAX_BYTES: u64 = 3601 * 3601 * 2;

/// Returns the size in samples of a tile of `bytes` bytes.
pub(super) fn size_by_length(bytes: u64) -> Option<[u32; 2]> {
    SIZES.into_iter().find(|[width, height]| u64::from(width * height) * 2 == bytes)
}

/// Returns longitude and latitude in degrees of the lower left sample, from a name such as `N46E008.SRTMGL1.hgt`.
pub(super) fn corner_by_name(name: &str) -> Option<[f64; 2]> {
    let bytes = name.as_bytes().get(..7)?;
    let number = |digits: &[u8], limit: u32| {
        let is_number = digits.iter().all(u8::is_ascii_digit);
        let value = digits.iter().fold(0, |value, digit| value * 10 + u32::from(digit.wrapping_sub(b'0')));
        (is_number && value <= limit).then_some(f64::from(value))
    };
    let sign = |letter: u8, positive: u8, negative: u8| match letter.to_ascii_uppercase() {
        letter if letter == positive => Some(1.0),
        letter if letter == negative => Some(-1.0),
        _ => None,
    };
    let latitude = sign(bytes[0], b'N', b'S')? * number(&bytes[1..3], 90)?;
    Some([sign(bytes[3], b'E', b'W')? * number(&bytes[4..7], 180)?, latitude])
}

/// Opens a tile.
pub(super) fn open(path: &Path) -> Result<FlatReader, SourceError> {
    let bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    read(path, &name, bytes, None)
}

/// Opens the first tile in a ZIP archive.
pub(super) fn open_zip(path: &Path) -> Result<FlatReader, SourceError> {
    let file = File::open(path).map_err(cannot_open(path))?;
    let damaged = |error: zip::result::ZipError| inconsistent(path, foreign_message(&error));
    let mut archive = zip::ZipArchive::new(file).map_err(damaged)?;
    for index in 0..archive.len() {
        let mut member = archive.by_index(index).map_err(damaged)?;
        let member_name = member.name().map_err(damaged)?.into_owned();
        let name = member_name.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
        if !name.to_ascii_lowercase().ends_with(".hgt") || name.starts_with('.') {
            continue;
        }
        // The size in the archive's directory is not trusted: reading ends beyond the length of the longest tile.
        let mut bytes = Vec::new();
        let read_member = member.by_ref().take(MAX_BYTES + 1).read_to_end(&mut bytes);
        read_member.map_err(|error| inconsistent(path, format!("{}: {}", shown(&name), foreign_message(&error))))?;
        return read(path, &name, bytes.len() as u64, Some(bytes));
    }
    Err(SourceError::UnknownFormat { path: path.into(), looks_like: "is a ZIP archive without an .hgt in it" })
}

fn read(path: &Path, name: &str, bytes: u64, unpacked: Option<Vec<u8>>) -> Result<FlatReader, SourceError> {
    let size = size_by_length(bytes).ok_or_else(|| {
        inconsistent(
            path,
            format!("an .hgt has 1201×1201, 1801×3601 or 3601×3601 samples, but this file has {bytes} bytes"),
        )
    })?;
    let corner = corner_by_name(name).ok_or_else(|| {
        let name = quoted(name);
        unclear(path, format!("the name of an SRTM tile must give its position, as in N46E008.hgt; {name} does not"))
    })?;
    let [width, height] = size;
    let step = [1.0 / f64::from(width - 1), 1.0 / f64::from(height - 1)];
    let crs_from_grid = place::north_up([corner[0], corner[1] + 1.0], step);
    let described = Description {
        size,
        strides: Strides { offset: 0, row: u64::from(width) * 2, sample: 2 },
        is_big_endian: true,
        meaning: Meaning::metres(SampleType::I16, Some(-32768.0)),
        georeference: place::locate(path, crs_from_grid, place::wgs84(), size)?,
        identity: place::identity(&[path], ""),
    };
    FlatReader::new(path, unpacked, described)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_give_the_position_of_a_tile() {
        assert_eq!(corner_by_name("N46E008.hgt"), Some([8.0, 46.0]));
        assert_eq!(corner_by_name("s29w072.SRTMGL1.hgt"), Some([-72.0, -29.0]));
        for wrong in ["N46E08.hgt", "X46E008", "N4", "", "N99E008.hgt", "N46E999.hgt", "né6E008.hgt"] {
            assert_eq!(corner_by_name(wrong), None, "{wrong}");
        }
    }
}
