//! PNG, 8 bits per channel, sRGB. Pictures are written in bands of rows from top to bottom, so that a picture of any
//! size needs the memory of one band.

use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use super::atomic::SharedFile;
use super::imprint::{self, KEY, Notes};
use super::input::{most_deflated_bytes, open_regular};
use super::{FileError, sample_count};

/// Value of the text chunk `Software`. It marks hachure's drawings, which a folder of height files ignores.
const SOFTWARE: &str = "hachure";

const METRES_PER_INCH: f64 = 0.0254;

/// The channels of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PngPixels {
    /// 3 bytes: red, green, blue.
    Rgb8,
    /// 4 bytes: red, green, blue, alpha (not premultiplied).
    Rgba8,
}

impl PngPixels {
    /// Returns the bytes of one pixel.
    pub fn bytes(self) -> usize {
        match self {
            Self::Rgb8 => 3,
            Self::Rgba8 => 4,
        }
    }
}

/// A PNG that is being written. Without [`PngWriter::finish`] no file appears under its name.
pub struct PngWriter {
    path: PathBuf,
    file: SharedFile,
    stream: png::StreamWriter<'static, SharedFile>,
    row_bytes: usize,
    rows_left: usize,
}

impl PngWriter {
    /// Starts a picture of `width` × `height` RGBA pixels.
    ///
    /// # Errors
    /// Fails if the picture is empty, or if the folder does not exist or is not writable.
    pub fn create(path: &Path, width: u32, height: u32) -> Result<Self, FileError> {
        Self::create_with(path, width, height, PngPixels::Rgba8)
    }

    /// Does the same as [`PngWriter::create`] for the given kind of pixels.
    ///
    /// # Errors
    /// The same as [`PngWriter::create`].
    pub fn create_with(path: &Path, width: u32, height: u32, pixels: PngPixels) -> Result<Self, FileError> {
        Self::create_noted(path, width, height, pixels, &Notes::default())
    }

    /// Does the same as [`PngWriter::create_with`], and also writes `notes` into the header.
    ///
    /// # Errors
    /// The same as [`PngWriter::create`].
    pub fn create_noted(
        path: &Path,
        width: u32,
        height: u32,
        pixels: PngPixels,
        notes: &Notes<'_>,
    ) -> Result<Self, FileError> {
        sample_count(path, width, height)?;
        let file = SharedFile::create(path).map_err(|error| FileError::write(path, error))?;
        let mut encoder = png::Encoder::new(file.clone(), width, height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(match pixels {
            PngPixels::Rgb8 => png::ColorType::Rgb,
            PngPixels::Rgba8 => png::ColorType::Rgba,
        });
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mark = format!("{SOFTWARE} {}", env!("CARGO_PKG_VERSION"));
        encoder.add_text_chunk("Software".to_owned(), mark).map_err(|error| FileError::write(path, error))?;
        if let Some(imprint) = notes.imprint {
            let added = encoder.add_itxt_chunk(KEY.to_owned(), imprint.to_owned());
            added.map_err(|error| FileError::write(path, error))?;
        }
        encoder.set_pixel_dims(notes.dpi.map(|dpi| {
            let dots_per_m = (dpi / METRES_PER_INCH).round() as u32;
            png::PixelDimensions { xppu: dots_per_m, yppu: dots_per_m, unit: png::Unit::Meter }
        }));
        // On drawings, Balanced gives files a half to a third the size of those that Fast gives, and 9 million pixels
        // take 0.1 to 0.7 s. The up filter keeps smooth washes small, and pure lines no larger than any other filter
        // does.
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_filter(png::Filter::Up);
        let stream = encoder
            .write_header()
            .and_then(png::Writer::into_stream_writer)
            .map_err(|error| FileError::write(path, error))?;
        let row_bytes = width as usize * pixels.bytes();
        Ok(Self { path: path.to_owned(), file, stream, row_bytes, rows_left: height as usize })
    }

    /// Appends complete rows below those already written. Their length is a multiple of width × bytes per pixel.
    ///
    /// # Errors
    /// Fails if the bytes are not complete rows, if there are more rows than the picture has, or if the disk is full.
    pub fn write_rows(&mut self, rows: &[u8]) -> Result<(), FileError> {
        let count = rows.len() / self.row_bytes;
        if count * self.row_bytes != rows.len() || count > self.rows_left {
            let cause =
                format!("{} bytes are not 0 to {} rows of {} bytes", rows.len(), self.rows_left, self.row_bytes);
            return Err(FileError::write(&self.path, cause));
        }
        self.stream.write_all(rows).map_err(|error| FileError::write(&self.path, error))?;
        self.rows_left -= count;
        Ok(())
    }

    /// Finishes the picture and gives it its final name.
    ///
    /// # Errors
    /// Fails if rows are missing or the disk is full.
    pub fn finish(self) -> Result<(), FileError> {
        self.finish_after(|| Ok(()))
    }

    /// Finishes the picture as [`PngWriter::finish`] does, but calls `before` just before the rename. This is for files
    /// that must get their final names first: by then only the rename of the picture itself can still fail.
    ///
    /// # Errors
    /// The same as [`PngWriter::finish`], and the errors of `before`.
    pub(crate) fn finish_after(self, before: impl FnOnce() -> Result<(), FileError>) -> Result<(), FileError> {
        let ended = self.end()?;
        before()?;
        ended.commit()
    }

    /// Finishes the picture without giving it its final name, for groups of files that are renamed together.
    ///
    /// # Errors
    /// The same as [`PngWriter::finish`].
    pub(crate) fn end(self) -> Result<EndedPng, FileError> {
        let Self { path, file, stream, rows_left, .. } = self;
        if rows_left > 0 {
            return Err(FileError::write(&path, format!("{rows_left} rows are missing")));
        }
        stream.finish().map_err(|error| FileError::write(&path, error))?;
        Ok(EndedPng { path, file })
    }

    /// Returns the number of rows that are still to be written.
    pub(crate) fn rows_left(&self) -> usize {
        self.rows_left
    }
}

/// A complete PNG without its final name. Dropping it without [`EndedPng::commit`] removes it.
pub(crate) struct EndedPng {
    path: PathBuf,
    file: SharedFile,
}

impl EndedPng {
    /// Gives the picture its final name.
    ///
    /// # Errors
    /// Fails if the disk is full or the folder no longer exists.
    pub(crate) fn commit(self) -> Result<(), FileError> {
        self.file.commit().map_err(|error| FileError::write(&self.path, error))
    }
}

/// Writes a complete RGBA picture: `rgba` holds width × height × 4 bytes, row by row from the top.
///
/// # Errors
/// The same as the methods of [`PngWriter`].
pub fn write_rgba8(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), FileError> {
    let mut writer = PngWriter::create(path, width, height)?;
    writer.write_rows(rgba)?;
    writer.finish()
}

/// A picture in memory.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Width × height × 4 bytes: red, green, blue, alpha, row by row from the top.
    pub rgba: Vec<u8>,
}

impl std::fmt::Debug for Picture {
    /// Prints the size only: a failed comparison must not print a million numbers.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Picture({}x{})", self.width, self.height)
    }
}

/// Returns whether hachure wrote a picture, judged by the text chunks before its pixels; `false` for files other than
/// PNG.
#[must_use]
pub(crate) fn is_drawing(path: &Path) -> bool {
    let Ok(file) = open_regular(path) else { return false };
    let reader = png::Decoder::new(BufReader::new(file)).read_info();
    let texts = reader.as_ref().map(|reader| reader.info().uncompressed_latin1_text.as_slice()).unwrap_or_default();
    texts.iter().any(|text| text.keyword == "Software" && text.text.starts_with(SOFTWARE))
}

/// Reads the imprint from the chunks before the pixels.
pub(super) fn imprint(path: &Path) -> Result<Option<String>, FileError> {
    let file = open_regular(path).map_err(|error| FileError::read(path, error))?;
    let reader = png::Decoder::new(BufReader::new(file)).read_info();
    let reader = reader.map_err(|error| FileError::read(path, error))?;
    let Some(text) = reader.info().utf8_text.iter().find(|text| text.keyword == KEY) else { return Ok(None) };
    let mut text = text.clone();
    text.decompress_text_with_limit(imprint::LARGEST_BYTES as usize)
        .map_err(|_| FileError::read(path, "its imprint is damaged, or larger than 4 MiB without compression"))?;
    text.get_text().map(Some).map_err(|error| FileError::read(path, error))
}

/// Largest picture that is read, in decoded bytes: 8192 × 16384 pixels.
const LARGEST_BYTES: usize = 1 << 29;

/// Returns the size of a PNG's pixels as [`read_rgba8`] returns them, and that of the file, in bytes. Only the header is
/// read.
///
/// # Errors
/// Fails if the file cannot be opened or is not a PNG.
pub(crate) fn decoded_bytes(path: &Path) -> Result<[u64; 2], FileError> {
    let file = open_regular(path).map_err(|error| FileError::read(path, error))?;
    let stored = file.metadata().map_err(|error| FileError::read(path, error))?.len();
    let reader = png::Decoder::new(BufReader::new(file)).read_info();
    let reader = reader.map_err(|error| FileError::read(path, error))?;
    let pixels = u64::from(reader.info().width) * u64::from(reader.info().height);
    Ok([pixels.saturating_mul(4), stored])
}

/// Reads any PNG as RGBA with 8 bits per channel: 16 bits are cut to their upper 8, grey is replicated, palettes are
/// looked up, and pictures without alpha are opaque.
///
/// # Errors
/// Fails if the file cannot be opened or is not a PNG, or if its header claims more pixels than the file can hold or
/// fit in memory.
pub fn read_rgba8(path: &Path) -> Result<Picture, FileError> {
    let file = open_regular(path).map_err(|error| FileError::read(path, error))?;
    let file_bytes = file.metadata().map_err(|error| FileError::read(path, error))?.len();
    let mut decoder = png::Decoder::new(BufReader::new(file));
    decoder.set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(|error| FileError::read(path, error))?;
    let too_large = || FileError::read(path, "the picture is too large");
    let bytes = reader.output_buffer_size().filter(|&bytes| bytes <= LARGEST_BYTES).ok_or_else(too_large)?;
    let packed = (reader.info().raw_bytes() as u64).min(bytes as u64);
    if packed > most_deflated_bytes(file_bytes) {
        return Err(FileError::read(path, format!("its pixels do not fit in {file_bytes} bytes")));
    }
    let mut rgba = Vec::new();
    rgba.try_reserve_exact(bytes)
        .map_err(|_| FileError::read(path, format!("not enough memory: it needs {bytes} bytes")))?;
    rgba.resize(bytes, 0);
    let frame = reader.next_frame(&mut rgba).map_err(|error| FileError::read(path, error))?;
    rgba.truncate(frame.buffer_size());
    if frame.color_type == png::ColorType::GrayscaleAlpha {
        rgba = rgba.chunks_exact(2).flat_map(|pixel| [pixel[0], pixel[0], pixel[0], pixel[1]]).collect();
    }
    Ok(Picture { width: frame.width, height: frame.height, rgba })
}
