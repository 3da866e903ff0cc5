//! USGS ASCII DEM: "Standards for Digital Elevation Models", USGS National Mapping Program, part 2, 1998.
//!
//! A header (record A) with fields at fixed positions is followed by profiles (records B) from west to east, each from
//! south to north with its own first northing, so that quadrangles in UTM have ragged edges. Records are padded to 1024
//! bytes, with line breaks in some files. A value is an integer times the vertical resolution, above the profile's
//! datum; -32767 is no-data. Older headers end after 864 bytes, and some after 893 bytes, as in GDAL.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::memory::{self, MemoryReader};
use super::place::{self, cannot_open, inconsistent};
use super::samples::{Meaning, SampleType, Tally, WarnOnce};
use super::text::number;
use super::{GeoKeys, SourceError};

/// Largest file in bytes. A file is read completely and held together with its heights: six bytes and four bytes for
/// each sample. A quadrangle has about ten megabytes.
const MAX_BYTES: u64 = 1 << 29;
/// Largest number of samples per byte of the file, with some more allowed in addition: profiles may be short, but a
/// quadrangle is mostly full.
const MAX_SAMPLES_PER_BYTE: u64 = 16;
const RECORD: usize = 1024;
const VOID: i64 = -32_767;
/// Number of values in the first record of a profile; further records have more.
const FIRST_VALUES: usize = 146;
const FURTHER_VALUES: usize = 170;

/// Returns whether a text begins with a record A: pattern and reference system codes at their positions.
pub(super) fn is_header(head: &[u8]) -> bool {
    let field = |first: usize| head.get(first..first + 6).unwrap_or_default();
    let systems: [&[u8]; 5] = [b"     0", b"     1", b"     2", b"     3", b" -9999"];
    head.len() >= 864 && [b"     1", b"     4"].iter().any(|code| field(150) == *code) && systems.contains(&field(156))
}

/// A scanner for numbers in free format; it skips white space between them.
struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn skip_space(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        self.at += rest.iter().take_while(|byte| byte.is_ascii_whitespace() || **byte == 0).count();
    }

    /// Reads an integer, which ends where the next one's sign begins: fields of six columns may leave no space.
    fn whole(&mut self) -> Option<i64> {
        self.skip_space();
        let rest = self.bytes.get(self.at..)?;
        let sign = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
        let digits = rest[sign..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let text = std::str::from_utf8(&rest[..sign + digits]).ok()?;
        self.at += text.len();
        text.parse().ok()
    }

    fn real(&mut self) -> Option<f64> {
        self.skip_space();
        let rest = self.bytes.get(self.at..)?;
        // A sign that does not belong to the exponent begins the next number.
        let belongs = |at: usize| match rest[at] {
            b'-' | b'+' => at == 0 || rest[at - 1].is_ascii_alphabetic(),
            byte => !byte.is_ascii_whitespace(),
        };
        let length = (0..rest.len().min(24)).take_while(|&at| belongs(at)).count();
        self.at += length;
        number(std::str::from_utf8(&rest[..length]).ok()?).filter(|number| number.is_finite())
    }
}

/// The fields of record A.
struct Header {
    size: [u32; 2],
    /// Position of the first sample in ground units: metres, feet, or arc seconds.
    first: [f64; 2],
    step: [f64; 2],
    /// Byte offset of the profiles.
    data: usize,
    metres_per_step: f64,
    metres_per_unit: f64,
    is_geographic: bool,
    keys: GeoKeys,
}

/// Reads a file.
pub(super) fn open(path: &Path) -> Result<MemoryReader, SourceError> {
    let length = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    if length > MAX_BYTES {
        return Err(place::unclear(path, "is too large to be read at once; convert it to GeoTIFF (gdal_translate)"));
    }
    let mut bytes = memory::room(path, [(length / 6) as u32, 1], length)?;
    File::open(path).and_then(|file| file.take(length).read_to_end(&mut bytes)).map_err(cannot_open(path))?;
    let header = read_header(path, &bytes)?;
    place::check_size(path, header.size)?;
    let [width, height] = header.size;
    let samples = u64::from(width) * u64::from(height);
    if samples > MAX_SAMPLES_PER_BYTE * length + (1 << 20) {
        return Err(inconsistent(path, format!("{width}×{height} samples do not fit in {length} bytes")));
    }
    memory::check_count(path, header.size)?;
    let scale = if header.is_geographic { 1.0 / 3600.0 } else { 1.0 };
    let crs_from_grid = place::north_up(header.first.map(|it| it * scale), header.step.map(|it| it * scale));
    let georeference = place::locate(path, crs_from_grid, header.keys.clone(), header.size)?;
    let mut heights_m = memory::room(path, header.size, samples)?;
    heights_m.resize(samples as usize, f32::NAN);
    read_profiles(path, &bytes, &header, &mut heights_m)?;
    let identity = place::identity(&[path], "");
    let unit_m = header.metres_per_unit;
    Ok(MemoryReader { path: path.into(), size: header.size, heights_m, unit_m, georeference, identity })
}

fn read_header(path: &Path, bytes: &[u8]) -> Result<Header, SourceError> {
    let missing = |what: &str| inconsistent(path, format!("its header has no {what}"));
    let text = |first: usize, length: usize| {
        let field = bytes.get(first..first + length).unwrap_or_default();
        String::from_utf8_lossy(field).trim().to_owned()
    };
    let whole = |first: usize, length: usize| text(first, length).parse::<i32>().ok();
    let real = |first: usize, length: usize| number(&text(first, length)).filter(|number| number.is_finite());

    let is_geographic = whole(156, 6) == Some(0);
    let mut corners = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for corner in 0..4 {
        for (axis, range) in corners.iter_mut().enumerate() {
            let value = real(546 + 48 * corner + 24 * axis, 24).ok_or_else(|| missing("corners"))?;
            *range = [range[0].min(value), range[1].max(value)];
        }
    }
    let resolution = |index: usize| real(816 + 12 * index, 12);
    let step = [0, 1].map(|axis| resolution(axis).filter(|step| *step > 0.0));
    let [Some(dx), Some(dy)] = step else { return Err(missing("spacing")) };
    let vertical = resolution(2).filter(|step| *step > 0.0).unwrap_or(1.0);
    let profiles = whole(858, 6).and_then(|count| u32::try_from(count).ok()).ok_or_else(|| missing("profiles"))?;

    let data = data_offset(bytes).ok_or_else(|| inconsistent(path, "no profile follows its header"))?;
    let [mut south, mut north] = corners[1];
    let mut west = corners[0][0];
    if !is_geographic {
        // The corners of a quadrangle are at arbitrary positions; samples are at whole multiples of the spacing.
        (south, north) = ((south / dy).floor() * dy, (north / dy).ceil() * dy);
        let mut scan = Scan { bytes, at: data };
        let numbers = [scan.whole(), scan.whole(), scan.whole(), scan.whole()];
        west = numbers
            .iter()
            .all(Option::is_some)
            .then(|| scan.real())
            .flatten()
            .ok_or_else(|| missing("first easting"))?;
    }
    let rows = (north - south) / dy + 1.5;
    if !(2.0..1e9).contains(&rows) {
        return Err(inconsistent(path, "its corners and its spacing do not match"));
    }
    let feet_or_metres = |code: Option<i32>| if code == Some(1) { 0.3048 } else { 1.0 };
    let metres_per_unit = feet_or_metres(whole(534, 6));
    Ok(Header {
        size: [profiles, rows as u32],
        first: [west, north],
        step: [dx, dy],
        data,
        metres_per_step: vertical,
        metres_per_unit,
        is_geographic,
        keys: crs_keys(whole(156, 6), whole(162, 6), whole(890, 2), whole(528, 6)),
    })
}

/// Returns the byte offset of the first profile, which begins with its row and column number.
fn data_offset(bytes: &[u8]) -> Option<usize> {
    let begins = |at: usize| {
        let mut scan = Scan { bytes, at };
        let numbers = (scan.whole(), scan.whole());
        (matches!(numbers, (Some(1), Some(0 | 1)))).then_some(scan.at)
    };
    // The profiles follow a header of 864 bytes at once; otherwise spaces or further fields come first.
    if begins(864).is_some_and(|end| end < RECORD) {
        return Some(864);
    }
    [RECORD, 893].into_iter().find(|&at| begins(at).is_some())
}

fn crs_keys(system: Option<i32>, zone: Option<i32>, datum: Option<i32>, unit: Option<i32>) -> GeoKeys {
    use super::geokeys::{self as key, GeoKey, USER_DEFINED};
    let (geographic, utm_base) = match datum {
        Some(2) => (4322, 32_200),
        Some(3) => (4326, 32_600),
        Some(4) => (4269, 26_900),
        _ => (4267, 26_700),
    };
    match (system, zone.and_then(|zone| u16::try_from(zone).ok()).filter(|zone| (1..=60).contains(zone))) {
        (Some(0), _) => place::epsg(geographic, true),
        (Some(1), Some(zone)) => place::epsg(utm_base + zone, false),
        _ => GeoKeys::from_keys(vec![
            GeoKey::short(key::MODEL_TYPE, 1),
            GeoKey::short(key::PROJECTED_CRS, USER_DEFINED),
            GeoKey::ascii(key::CITATION, "USGS DEM"),
            GeoKey::short(key::LINEAR_UNITS, if unit == Some(1) { 9003 } else { key::METRE }),
        ]),
    }
}

fn read_profiles(path: &Path, bytes: &[u8], header: &Header, heights_m: &mut [f32]) -> Result<(), SourceError> {
    let [width, height] = header.size.map(|size| size as usize);
    let meaning = Meaning {
        scale: header.metres_per_step,
        metres_per_unit: header.metres_per_unit,
        ..Meaning::metres(SampleType::F64, None)
    };
    let south = header.first[1] - (height as f64 - 1.0) * header.step[1];
    let mut tally = Tally::default();
    let mut scan = Scan { bytes, at: header.data };
    for column in 0..width {
        let truncated =
            || inconsistent(path, format!("it is truncated or not text in profile {} of {width}", column + 1));
        let start = scan.at;
        let mut next = || scan.whole().ok_or_else(truncated);
        let [_, _, count, _] = [next()?, next()?, next()?, next()?];
        let mut next = || scan.real().ok_or_else(truncated);
        let [_, first, datum, _, _] = [next()?, next()?, next()?, next()?, next()?];
        let count = usize::try_from(count).map_err(|_| truncated())?;
        let gap = ((first - south) / header.step[1]).round();
        if !(gap >= 0.0 && gap + count as f64 <= height as f64) {
            return Err(inconsistent(path, format!("profile {} does not fit between its corners", column + 1)));
        }
        let meaning = Meaning { offset: datum, ..meaning.clone() };
        for sample in 0..count {
            let value = scan.whole().ok_or_else(truncated)?;
            let row = height - 1 - (gap as usize + sample);
            if value != VOID {
                heights_m[row * width + column] = meaning.height_m(value as f64, &mut tally);
            }
        }
        scan.at = next_profile(&scan, start, count, column);
    }
    WarnOnce::default().warn(path, &tally);
    Ok(())
}

/// Returns the byte offset of the profile after number `column`. Some files have values beyond a profile's count in its
/// last record.
fn next_profile(scan: &Scan<'_>, start: usize, count: usize, column: usize) -> usize {
    let begins = |at: usize| {
        let mut scan = Scan { bytes: scan.bytes, at };
        scan.whole();
        scan.whole() == i64::try_from(column + 2).ok()
    };
    let records = 1 + count.saturating_sub(FIRST_VALUES).div_ceil(FURTHER_VALUES);
    let padded = start - start % RECORD + records * RECORD;
    if !begins(scan.at) && begins(padded) { padded } else { scan.at }
}
