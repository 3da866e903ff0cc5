//! DTED levels 0 to 2 (MIL-PRF-89020B): elevations of a cell by columns from the west, each column from the south.
//!
//! Three text records (UHL 80 bytes, DSI 648, ACC 2700) come before the columns. A column has a header of 8 bytes
//! (0xAA, a count in 3 bytes, its number from the west, the number of its first sample from the south), big-endian
//! samples of 16 bits, and a checksum of 4 bytes (the sum of all bytes before it). Samples are metres as sign and
//! magnitude; -32767 is no-data. Columns may be farther apart than rows, and are the more so the farther they are from
//! the equator.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::SourceError;
use super::georeference::Georeference;
use super::place::{self, begin_window, cannot_open, inconsistent};
use super::reader::{HeightReader, Window};

const LABEL: u64 = 80;
const HEADER: u64 = 80 + 648 + 2700;
const COLUMN_HEADER: usize = 8;
const CHECKSUM: usize = 4;

/// A DTED file that is read by columns.
pub(super) struct DtedReader {
    path: PathBuf,
    file: Mutex<File>,
    size: [u32; 2],
    /// Byte offset of each column; `None` for columns that the file leaves out.
    columns: Vec<Option<u64>>,
    georeference: Georeference,
    identity: String,
    warned: AtomicBool,
}

/// Returns the offset of the header: some files have tape labels before it. Returns `None` for files other than DTED.
pub(super) fn header_offset(head: &[u8]) -> Option<u64> {
    [0, LABEL, 2 * LABEL].into_iter().find(|&at| head.get(at as usize..).is_some_and(|head| head.starts_with(b"UHL1")))
}

const WRONG_CHECKSUMS: &str = "some columns have wrong checksums; they are read nevertheless";

impl DtedReader {
    /// Opens a file that begins as DTED does.
    pub(super) fn open(path: &Path, offset: u64) -> Result<Self, SourceError> {
        let mut file = File::open(path).map_err(cannot_open(path))?;
        let file_bytes = file.metadata().map_err(cannot_open(path))?.len();
        let mut header = vec![0; HEADER as usize];
        let read = file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(&mut header));
        read.map_err(|_| inconsistent(path, "it ends in its header"))?;
        let number = |first: usize, count: usize, what: &str| {
            let text = String::from_utf8_lossy(&header[first..first + count]).trim().to_owned();
            text.parse::<u32>().map_err(|_| inconsistent(path, format!("its {what} is {text:?}")))
        };
        let angle = |first: usize, what: &str| {
            let [degrees, minutes, seconds] =
                [number(first, 3, what)?, number(first + 3, 2, what)?, number(first + 5, 2, what)?].map(f64::from);
            let angle = degrees + minutes / 60.0 + seconds / 3600.0;
            Ok::<_, SourceError>(if matches!(header[first + 7], b'S' | b'W') { -angle } else { angle })
        };
        let size = [number(47, 4, "number of longitude lines")?, number(51, 4, "number of latitude points")?];
        place::check_size(path, size)?;
        let corner = [angle(4, "longitude")?, angle(12, "latitude")?];
        // Intervals are in tenths of an arc second.
        let steps = [number(20, 4, "longitude interval")?, number(24, 4, "latitude interval")?];
        let step = steps.map(|tenths| f64::from(tenths) / 36_000.0);
        let top = corner[1] + f64::from(size[1] - 1) * step[1];
        let crs_from_grid = place::north_up([corner[0], top], step);
        // DSI, bytes 145 to 149: the horizontal datum.
        let keys = match &header[80 + 144..80 + 149] {
            b"WGS72" => place::epsg(4322, true),
            _ => place::wgs84(),
        };
        let georeference = place::locate(path, crs_from_grid, keys, size)?;
        let columns = find_columns(path, &mut file, offset + HEADER, file_bytes, size)?;
        let identity = place::identity(&[path], "");
        let (file, warned) = (Mutex::new(file), AtomicBool::new(false));
        Ok(Self { path: path.into(), file, size, columns, georeference, identity, warned })
    }

    fn warn_of_checksums(&self) {
        if !self.warned.swap(true, Ordering::Relaxed) {
            tracing::warn!("{}: {WRONG_CHECKSUMS}", self.path.display());
        }
    }

    /// Reads one column with its header and checksum.
    fn column(&self, at: u64) -> Result<Vec<u8>, SourceError> {
        let mut bytes = vec![0; record_bytes(self.size[1])];
        // The position is set again below, so that a position left by a thread that panicked does not matter.
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut bytes));
        read.map_err(cannot_open(&self.path))?;
        drop(file);
        let (content, sum) = bytes.split_at(bytes.len() - CHECKSUM);
        let expected = sum.iter().fold(0u32, |value, &byte| (value << 8) | u32::from(byte));
        if content.iter().map(|&byte| u32::from(byte)).sum::<u32>() != expected {
            self.warn_of_checksums();
        }
        Ok(bytes)
    }
}

fn record_bytes(rows: u32) -> usize {
    COLUMN_HEADER + 2 * rows as usize + CHECKSUM
}

/// Returns the byte offset of each column. A complete file stores them in sequence; in a file that leaves some out each
/// column has its number.
fn find_columns(
    path: &Path,
    file: &mut File,
    first: u64,
    file_bytes: u64,
    [width, height]: [u32; 2],
) -> Result<Vec<Option<u64>>, SourceError> {
    let record = record_bytes(height) as u64;
    let present = (file_bytes.saturating_sub(first)) / record;
    if present >= u64::from(width) {
        return Ok((0..u64::from(width)).map(|column| Some(first + column * record)).collect());
    }
    tracing::warn!("{}: has {present} of its {width} columns; the others are no-data", path.display());
    let mut columns = vec![None; width as usize];
    for index in 0..present {
        let at = first + index * record;
        let mut header = [0; COLUMN_HEADER];
        file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut header)).map_err(cannot_open(path))?;
        let number = usize::from(u16::from_be_bytes([header[4], header[5]]));
        match columns.get_mut(number) {
            Some(column) if header[0] == 0xaa => *column = Some(at),
            _ => return Err(inconsistent(path, format!("its column {index} has no valid column header"))),
        }
    }
    match present {
        0 => Err(inconsistent(path, "it ends before its first column")),
        _ => Ok(columns),
    }
}

/// Decodes a sample in metres from sign and magnitude. Some writers used two's complement: a value that would be lower
/// than any ground is decoded as such.
fn height_m(bytes: [u8; 2]) -> f32 {
    let raw = u16::from_be_bytes(bytes);
    let magnitude = f32::from(raw & 0x7fff);
    match raw {
        0xffff => f32::NAN,
        0..=0x7fff => magnitude,
        _ if magnitude > 16_000.0 => match raw as i16 {
            i16::MIN..=-32_767 => f32::NAN,
            height => f32::from(height),
        },
        _ => -magnitude,
    }
}

impl HeightReader for DtedReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = begin_window(&self.path, window, self.size)?;
        heights_m.resize(window.samples(), f32::NAN);
        for column in 0..window.width as usize {
            let Some(at) = self.columns[window.x as usize + column] else { continue };
            let bytes = self.column(at)?;
            let (samples, _) = bytes[COLUMN_HEADER..bytes.len() - CHECKSUM].as_chunks::<2>();
            // The first row of the grid is the last sample of a column.
            let northmost = samples.len() - 1 - window.y as usize;
            for (row, range) in window.rows_in(window).enumerate() {
                heights_m[range.start + column] = height_m(samples[northmost - row]);
            }
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        [256.min(self.size[0]), self.size[1]]
    }

    fn warnings(&self) -> Vec<String> {
        let is_given = self.warned.load(Ordering::Relaxed);
        is_given.then(|| WRONG_CHECKSUMS.to_owned()).into_iter().collect()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_sign_and_magnitude() {
        assert_eq!(height_m([0x01, 0x02]), 258.0);
        assert_eq!(height_m([0x80, 0x05]), -5.0);
        assert_eq!(height_m([0xff, 0xfb]), -5.0, "two's complement");
        assert!(height_m([0xff, 0xff]).is_nan());
    }
}
