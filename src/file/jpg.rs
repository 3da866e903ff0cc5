//! JPEG: 8 bits per channel, sRGB, without alpha, at a fixed high quality and with the full resolution of colour, so
//! that thin coloured lines stay clean. The encoder pulls rows from the bands of the caller, so that a picture of any
//! size needs the memory of a few bands.

use std::cell::RefCell;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use jpeg_encoder::{Density, Encoder, ImageBuffer, JpegColorType, SamplingFactor, rgb_to_ycbcr};

use super::atomic::SharedFile;
use super::imprint::{KEY, Notes};
use super::input::open_regular;
use super::{FileError, sample_count};

/// Quality of 1 to 100: lines have no visible ringing.
const QUALITY: u8 = 94;
/// Longest side that the format can state.
const LONGEST_PX: u32 = 65_535;
/// Number of the application segments that hold the imprint, with an identifier as the standard requires.
const SEGMENT: u8 = 9;
/// Largest part of an imprint in a segment, whose length has 16 bits.
const PART_BYTES: usize = 60_000;
/// Bytes per pixel of the caller's rows.
const RGBA: usize = 4;
/// Rows that may wait for the encoder.
const WAITING_ROWS: usize = 64;

/// A JPEG that is being written. Without [`JpgWriter::finish_after`] no file appears under its name.
pub(crate) struct JpgWriter {
    path: PathBuf,
    file: Option<SharedFile>,
    rows: Option<SyncSender<Vec<u8>>>,
    encoder: Option<JoinHandle<Result<(), String>>>,
    row_bytes: usize,
    rows_left: usize,
}

impl JpgWriter {
    /// Starts a picture of `width` × `height` pixels, with an imprint and a resolution.
    ///
    /// # Errors
    /// Fails if the picture is empty or has a side of more than 65,535 pixels, if the imprint is too long, or if the
    /// folder does not exist or is not writable.
    pub(crate) fn create(path: &Path, width: u32, height: u32, notes: &Notes<'_>) -> Result<Self, FileError> {
        let failed = |error: &dyn std::fmt::Display| FileError::write(path, error);
        sample_count(path, width, height)?;
        if width.max(height) > LONGEST_PX {
            let cause = format!("a JPEG has at most {LONGEST_PX} pixels a side, and the picture has {width}x{height}");
            return Err(FileError::write(path, format!("{cause}; write a .png")));
        }
        let file = SharedFile::create(path).map_err(|error| failed(&error))?;
        let mut encoder = Encoder::new(file.clone(), QUALITY);
        encoder.set_sampling_factor(SamplingFactor::F_1_1);
        if let Some(dpi) = notes.dpi {
            let dots = dpi.round().clamp(1.0, f64::from(u16::MAX)) as u16;
            encoder.set_density(Density::Inch { x: dots, y: dots });
        }
        for segment in segments(notes.imprint.unwrap_or_default()) {
            encoder.add_app_segment(SEGMENT, &segment).map_err(|error| failed(&error))?;
        }
        let (sender, receiver) = sync_channel(WAITING_ROWS);
        // Both sides are at most 65,535.
        let size = [width as u16, height as u16];
        let rows = Rows { size, receiver, last: RefCell::new(Row { number: None, rgba: Vec::new() }) };
        let encode = move || encoder.encode_image(rows).map_err(|error| error.to_string());
        let thread = std::thread::Builder::new().name("jpeg".to_owned()).spawn(encode);
        Ok(Self {
            path: path.to_owned(),
            file: Some(file),
            rows: Some(sender),
            encoder: Some(thread.map_err(|error| failed(&error))?),
            row_bytes: width as usize * RGBA,
            rows_left: height as usize,
        })
    }

    /// Appends complete RGBA rows below those already written; alpha is ignored.
    ///
    /// # Errors
    /// Fails if the bytes are not complete rows, if there are more rows than the picture has, or if the disk is full.
    pub(crate) fn write_rows(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        let count = rgba.len() / self.row_bytes;
        if count * self.row_bytes != rgba.len() || count > self.rows_left {
            return Err(FileError::write(&self.path, "a band of rows does not match the picture"));
        }
        for row in rgba.chunks_exact(self.row_bytes) {
            if self.rows.as_ref().is_none_or(|rows| rows.send(row.to_owned()).is_err()) {
                // The encoder has stopped early and returns the cause.
                return Err(self.stop().err().unwrap_or_else(|| FileError::write(&self.path, "already stopped")));
            }
        }
        self.rows_left -= count;
        Ok(())
    }

    /// Finishes the picture and gives it its final name after `before`, which renames the files that belong to it.
    ///
    /// # Errors
    /// Fails if rows are missing or the disk is full, and with the errors of `before`.
    pub(crate) fn finish_after(mut self, before: impl FnOnce() -> Result<(), FileError>) -> Result<(), FileError> {
        if self.rows_left > 0 {
            return Err(FileError::write(&self.path, format!("{} rows are missing", self.rows_left)));
        }
        self.stop()?;
        before()?;
        match self.file.take() {
            Some(file) => file.commit().map_err(|error| FileError::write(&self.path, error)),
            None => Err(FileError::write(&self.path, "already written")),
        }
    }

    /// Waits for the encoder and returns its result.
    fn stop(&mut self) -> Result<(), FileError> {
        self.rows = None;
        let result = match self.encoder.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err("the encoder panicked".to_owned()),
            None => Err("the encoder has stopped".to_owned()),
        };
        result.map_err(|cause| FileError::write(&self.path, cause))
    }
}

impl Drop for JpgWriter {
    /// Waits until the temporary file is removed.
    fn drop(&mut self) {
        let _ = self.stop();
    }
}

/// The rows of a picture as they arrive. The encoder requests rows in order, and the last one again where blocks
/// extend below the picture.
struct Rows {
    size: [u16; 2],
    receiver: Receiver<Vec<u8>>,
    last: RefCell<Row>,
}

struct Row {
    number: Option<u16>,
    rgba: Vec<u8>,
}

impl ImageBuffer for Rows {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.size[0]
    }

    fn height(&self) -> u16 {
        self.size[1]
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        let mut last = self.last.borrow_mut();
        while last.number.is_none_or(|number| number < y) {
            // Without further rows the picture was abandoned, and its file is removed.
            let rgba = self.receiver.recv().unwrap_or_else(|_| vec![0; usize::from(self.size[0]) * RGBA]);
            *last = Row { number: Some(last.number.map_or(0, |number| number + 1)), rgba };
        }
        for pixel in last.rgba.chunks_exact(RGBA) {
            let (luma, blue, red) = rgb_to_ycbcr(pixel[0], pixel[1], pixel[2]);
            for (buffer, value) in buffers.iter_mut().zip([luma, blue, red]) {
                buffer.push(value);
            }
        }
    }
}

/// Returns an imprint as segments: the key, a zero, the part's number from 1, the number of parts, and the part.
fn segments(imprint: &str) -> Vec<Vec<u8>> {
    let parts: Vec<&[u8]> = imprint.as_bytes().chunks(PART_BYTES).collect();
    let count = parts.len();
    let segment = |(number, part): (usize, &&[u8])| {
        let mut bytes = Vec::from(KEY.as_bytes());
        bytes.push(0);
        // 16 bits each, high byte first, as everything in a JPEG.
        bytes.extend([number + 1, count].into_iter().flat_map(|number| (number as u16).to_be_bytes()));
        bytes.extend_from_slice(part);
        bytes
    };
    parts.iter().enumerate().map(segment).collect()
}

/// Reads the imprint from the segments before the pixels. `largest_bytes` bounds its length.
pub(super) fn imprint(path: &Path, largest_bytes: usize) -> Result<Option<String>, FileError> {
    let failed = |error: std::io::Error| FileError::read(path, error);
    let mut file = std::io::BufReader::new(open_regular(path).map_err(failed)?);
    let mut found = Vec::new();
    let mut head = [0; 2];
    file.read_exact(&mut head).map_err(failed)?;
    let prefix = [KEY.as_bytes(), &[0]].concat();
    loop {
        file.read_exact(&mut head).map_err(failed)?;
        // The pixels begin, or this is not a segment.
        if head[0] != 0xff || matches!(head[1], 0xda | 0xd9) {
            break;
        }
        let mut length = [0; 2];
        file.read_exact(&mut length).map_err(failed)?;
        let length = usize::from(u16::from_be_bytes(length)).saturating_sub(2);
        let mut bytes = vec![0; length];
        file.read_exact(&mut bytes).map_err(failed)?;
        if head[1] == 0xe0 + SEGMENT
            && let Some(part) = bytes.strip_prefix(prefix.as_slice()).and_then(|rest| rest.get(4..))
        {
            found.extend_from_slice(part);
            if found.len() > largest_bytes {
                return Err(FileError::read(path, "its imprint is too long"));
            }
        }
    }
    match found.is_empty() {
        true => Ok(None),
        false => String::from_utf8(found).map(Some).map_err(|_| FileError::read(path, "its imprint is not UTF-8")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    const SIZE: [u32; 2] = [61, 43];

    fn pixel(x: u32, y: u32) -> [u8; 4] {
        [(x * 4) as u8, (y * 5) as u8, (x * 2 + y * 2) as u8, 255]
    }

    #[test]
    fn bands_of_any_height_make_a_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let long = "ü = 1\n".repeat(20_000);
        let notes = Notes { imprint: Some(&long), dpi: Some(254.0), ..Notes::default() };
        let mut writer = JpgWriter::create(&path, SIZE[0], SIZE[1], &notes).unwrap();
        for rows in [0..1, 1..30, 30..30, 30..SIZE[1]] {
            let band = rows.flat_map(|y| (0..SIZE[0]).flat_map(move |x| pixel(x, y)));
            writer.write_rows(&band.collect::<Vec<u8>>()).unwrap();
        }
        assert!(!path.exists());
        writer.finish_after(|| Ok(())).unwrap();
        assert_eq!(imprint(&path, 1 << 20).unwrap().as_deref(), Some(long.as_str()));
        assert!(imprint(&path, 1000).is_err());
        let mut decoder = jpeg_decoder::Decoder::new(std::fs::File::open(&path).unwrap());
        let shown = decoder.decode().unwrap();
        let far = |moved: u32| {
            let off = |i: usize| {
                let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
                (0..3).map(|k| shown[3 * i + k].abs_diff(pixel(x, y + moved)[k])).max().unwrap()
            };
            (0..shown.len() / 3).map(off).max().unwrap()
        };
        assert!(far(0) < 12, "{}", far(0));
        assert!(far(4) > 12, "planted error, rows moved");
        // Without its last rows there is no file, and nothing is left.
        let mut short = JpgWriter::create(&folder.path().join("b.jpg"), 8, 20, &Notes::default()).unwrap();
        short.write_rows(&[0; 8 * 4]).unwrap();
        assert!(short.finish_after(|| Ok(())).unwrap_err().to_string().contains("19 rows are missing"));
        assert!(JpgWriter::create(&folder.path().join("c.jpg"), 70_000, 1, &Notes::default()).is_err());
        let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["a.jpg"]);
    }
}
