//! Reads uncompressed samples that are stored row by row at fixed distances: the data of BIL, GridFloat, ENVI, `.hgt`
//! and raw files. Any window is read without the rest.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::SourceError;
use super::georeference::Georeference;
use super::place::{begin_window, cannot_open, inconsistent};
use super::reader::{HeightReader, Window};
use super::samples::{Meaning, Tally, WarnOnce};

/// Size of a block of rows in bytes, and the largest amount that is read at a time.
const BLOCK_BYTES: u64 = 1 << 20;

/// The positions of the samples of the first band in the file, in bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strides {
    /// Offset of the first sample.
    pub offset: u64,
    /// Distance from a sample to the one below it.
    pub row: u64,
    /// Distance from a sample to the next one in its row.
    pub sample: u64,
}

/// The file, or its unpacked contents.
enum Bytes {
    File(Mutex<File>),
    Memory(Vec<u8>),
}

/// An uncompressed raster that is read by windows.
pub(super) struct FlatReader {
    path: PathBuf,
    bytes: Bytes,
    size: [u32; 2],
    strides: Strides,
    is_big_endian: bool,
    meaning: Meaning,
    georeference: Georeference,
    identity: String,
    warnings: WarnOnce,
}

/// The description of a flat file from its header.
pub(super) struct Description {
    pub size: [u32; 2],
    pub strides: Strides,
    pub is_big_endian: bool,
    pub meaning: Meaning,
    pub georeference: Georeference,
    pub identity: String,
}

impl FlatReader {
    /// Opens the samples of `path`, or uses `unpacked` if they were compressed in it.
    ///
    /// # Errors
    /// Fails if the file is too short for the described samples.
    pub(super) fn new(path: &Path, unpacked: Option<Vec<u8>>, described: Description) -> Result<Self, SourceError> {
        let Description { size, strides, is_big_endian, meaning, georeference, identity } = described;
        let (bytes, length) = match unpacked {
            Some(bytes) => {
                let length = bytes.len() as u64;
                (Bytes::Memory(bytes), length)
            }
            None => {
                let file = File::open(path).map_err(cannot_open(path))?;
                let length = file.metadata().map_err(cannot_open(path))?.len();
                (Bytes::File(Mutex::new(file)), length)
            }
        };
        let [width, height] = size;
        let far = |count: u32, stride: u64| u128::from(count.saturating_sub(1)) * u128::from(stride);
        let row_bytes = far(width, strides.sample) + meaning.sample_type.bytes() as u128;
        if u128::from(strides.row) < row_bytes || strides.sample < meaning.sample_type.bytes() as u64 {
            return Err(inconsistent(path, "its rows are longer than the distance between rows"));
        }
        let end = u128::from(strides.offset) + far(height, strides.row) + row_bytes;
        if end > u128::from(length) {
            return Err(inconsistent(
                path,
                format!("it must have {end} bytes for its {width}×{height} samples, but has {length}: it is truncated"),
            ));
        }
        Ok(Self {
            path: path.into(),
            bytes,
            size,
            strides,
            is_big_endian,
            meaning,
            georeference,
            identity,
            warnings: WarnOnce::default(),
        })
    }

    fn read_bytes(&self, offset: u64, count: usize) -> Result<Vec<u8>, SourceError> {
        match &self.bytes {
            Bytes::Memory(bytes) => {
                let range = usize::try_from(offset).ok().and_then(|first| bytes.get(first..first.checked_add(count)?));
                range.map(<[u8]>::to_vec).ok_or_else(|| inconsistent(&self.path, "it is truncated"))
            }
            Bytes::File(file) => {
                let mut bytes = vec![0; count];
                // The position is set again here, so that a position left by a thread that panicked does not matter.
                let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                let read = file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(&mut bytes));
                read.map_err(|source| SourceError::Open { path: self.path.clone(), source })?;
                Ok(bytes)
            }
        }
    }

    fn append(&self, mut bytes: Vec<u8>, heights_m: &mut Vec<f32>, tally: &mut Tally) {
        let sample_bytes = self.meaning.sample_type.bytes();
        let stride = self.strides.sample as usize;
        if stride > sample_bytes {
            bytes = bytes.chunks(stride).flat_map(|sample| &sample[..sample_bytes]).copied().collect();
        }
        if sample_bytes > 1 && self.is_big_endian != cfg!(target_endian = "big") {
            bytes.chunks_exact_mut(sample_bytes).for_each(<[u8]>::reverse);
        }
        self.meaning.append_heights_m(&bytes, heights_m, tally);
    }
}

impl HeightReader for FlatReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = begin_window(&self.path, window, self.size)?;
        if window.samples() == 0 {
            return Ok(heights_m);
        }
        let mut tally = Tally::default();
        let Strides { offset, row: row_stride, sample } = self.strides;
        let first = offset + u64::from(window.y) * row_stride + u64::from(window.x) * sample;
        let sample_bytes = self.meaning.sample_type.bytes();
        let row_bytes = (u64::from(window.width) - 1) * sample + sample_bytes as u64;
        if row_bytes == row_stride {
            // Contiguous rows are read several at a time.
            let rows_at_once = (BLOCK_BYTES / row_stride).max(1);
            for row in (0..u64::from(window.height)).step_by(rows_at_once as usize) {
                let rows = rows_at_once.min(u64::from(window.height) - row);
                let bytes = self.read_bytes(first + row * row_stride, (rows * row_bytes) as usize)?;
                self.append(bytes, &mut heights_m, &mut tally);
            }
        } else {
            // The samples of hundreds of other bands may be stored between the samples of a row.
            let columns_at_once = (BLOCK_BYTES / sample).max(1);
            for row in 0..u64::from(window.height) {
                for column in (0..u64::from(window.width)).step_by(columns_at_once as usize) {
                    let columns = columns_at_once.min(u64::from(window.width) - column);
                    let bytes = (columns - 1) * sample + sample_bytes as u64;
                    let bytes = self.read_bytes(first + row * row_stride + column * sample, bytes as usize)?;
                    self.append(bytes, &mut heights_m, &mut tally);
                }
            }
        }
        self.warnings.warn(&self.path, &tally);
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        let rows = (BLOCK_BYTES / self.strides.row.max(1)).clamp(1, u64::from(self.size[1]));
        [self.size[0], rows as u32]
    }

    fn declared_unit_m(&self) -> Option<f64> {
        self.meaning.declared_unit_m()
    }

    fn is_coarse(&self) -> bool {
        self.meaning.sample_type.bytes() == 1
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.given()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}
