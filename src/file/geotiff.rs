//! Writes pictures as GeoTIFF: 8 bits per channel, sRGB without alpha, in strips of rows from top to bottom, so that a
//! picture of any size needs the memory of one strip. Files of more than 4 GiB are BigTIFF.

use std::path::{Path, PathBuf};

use geotiff_writer::{Compression, PhotometricInterpretation, Predictor};
use tiff_reader::{Tag, TagValue, TiffFile};
use tiff_writer::{ImageBuilder, ImageHandle, TiffWriter, WriteOptions};

use super::atomic::SharedFile;
use super::imprint::{KEY, escaped, unescaped};
use super::{FileError, sample_count};

const SOFTWARE: u16 = 305;
const X_RESOLUTION: u16 = 282;
const Y_RESOLUTION: u16 = 283;
const RESOLUTION_UNIT: u16 = 296;
const INCH: u16 = 2;
const GDAL_METADATA: u16 = 42112;

/// Largest uncompressed size of a strip in bytes, unless a single row is larger.
const STRIP_BYTES: usize = 1 << 20;
/// Channels per pixel.
const CHANNELS: usize = 3;

/// A picture that is being written. Without [`GeoTiffWriter::finish`] no file appears under its name.
pub(crate) struct GeoTiffWriter {
    path: PathBuf,
    file: SharedFile,
    writer: TiffWriter<SharedFile>,
    image: ImageHandle,
    /// Rows that do not fill a strip yet.
    rows: Vec<u8>,
    row_bytes: usize,
    strip_rows: usize,
    strips: usize,
    rows_left: usize,
}

impl GeoTiffWriter {
    /// Starts a picture of `width` × `height` pixels with the tags of its georeference, a resolution in dots per inch,
    /// and the text that says how it was drawn.
    ///
    /// # Errors
    /// Fails if the picture is empty, the folder does not exist or is not writable, or the tags are invalid.
    pub(crate) fn create(
        path: &Path,
        width: u32,
        height: u32,
        tags: Vec<Tag>,
        dpi: Option<f64>,
        imprint: Option<&str>,
    ) -> Result<Self, FileError> {
        sample_count(path, width, height)?;
        let file = SharedFile::create(path).map_err(|error| FileError::write(path, error))?;
        let failed = |error| FileError::write(path, error);
        let row_bytes = width as usize * CHANNELS;
        let strip_rows = (STRIP_BYTES / row_bytes).clamp(1, height as usize);
        let software = format!("hachure {}", env!("CARGO_PKG_VERSION"));
        let mut image = ImageBuilder::new(width, height)
            .sample_type::<u8>()
            .samples_per_pixel(CHANNELS as u16)
            .photometric(PhotometricInterpretation::Rgb)
            .compression(Compression::Deflate)
            .predictor(Predictor::Horizontal)
            .strips(strip_rows as u32)
            .tag(Tag::new(SOFTWARE, TagValue::Ascii(software)));
        if let Some(dpi) = dpi {
            // A thousandth of a dot is precise enough.
            let dots = || TagValue::Rational(vec![[(dpi * 1000.0).round() as u32, 1000]]);
            image = image.tag(Tag::new(X_RESOLUTION, dots())).tag(Tag::new(Y_RESOLUTION, dots()));
            image = image.tag(Tag::new(RESOLUTION_UNIT, TagValue::Short(vec![INCH])));
        }
        if let Some(imprint) = imprint {
            let item = format!("<Item name=\"{KEY}\">{}</Item>", escaped(imprint));
            let metadata = format!("<GDALMetadata>\n  {item}\n</GDALMetadata>\n");
            image = image.tag(Tag::new(GDAL_METADATA, TagValue::Ascii(metadata)));
        }
        image = tags.into_iter().fold(image, ImageBuilder::tag);
        let mut writer = TiffWriter::new(file.clone(), WriteOptions::auto()).map_err(failed)?;
        let image = writer.add_image(image).map_err(failed)?;
        let (path, rows_left) = (path.to_owned(), height as usize);
        Ok(Self { path, file, writer, image, rows: Vec::new(), row_bytes, strip_rows, strips: 0, rows_left })
    }

    /// Appends complete RGBA rows below those already written. Alpha is dropped.
    ///
    /// # Errors
    /// Fails if the bytes are not complete rows, if there are more rows than the picture has, or if the disk is full.
    pub(crate) fn write_rows(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        let row_bytes = self.row_bytes / CHANNELS * 4;
        let count = rgba.len() / row_bytes;
        if count * row_bytes != rgba.len() || count > self.rows_left {
            let cause = format!("{} bytes are not 0 to {} rows of {row_bytes} bytes", rgba.len(), self.rows_left);
            return Err(FileError::write(&self.path, cause));
        }
        self.rows_left -= count;
        self.rows.extend(rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]));
        let strip_bytes = self.strip_rows * self.row_bytes;
        let whole = self.rows.len() / strip_bytes * strip_bytes;
        let rest = self.rows.split_off(whole);
        let strips = std::mem::replace(&mut self.rows, rest);
        strips.chunks_exact(strip_bytes).try_for_each(|strip| self.write_strip(strip))
    }

    /// Finishes the picture and gives it its final name.
    ///
    /// # Errors
    /// Fails if rows are missing or the disk is full.
    pub(crate) fn finish(mut self) -> Result<(), FileError> {
        if self.rows_left > 0 {
            return Err(FileError::write(&self.path, format!("{} rows are missing", self.rows_left)));
        }
        let rest = std::mem::take(&mut self.rows);
        if !rest.is_empty() {
            self.write_strip(&rest)?;
        }
        let Self { path, file, writer, .. } = self;
        drop(writer.finish().map_err(|error| FileError::write(&path, error))?);
        file.commit().map_err(|error| FileError::write(&path, error))
    }

    fn write_strip(&mut self, strip: &[u8]) -> Result<(), FileError> {
        let written = self.writer.write_block(&self.image, self.strips, strip);
        written.map_err(|error| FileError::write(&self.path, error))?;
        self.strips += 1;
        Ok(())
    }
}

/// Reads the imprint of a GeoTIFF that hachure drew; `None` if it has none, or is not a picture that hachure drew.
/// Defects of other TIFFs are reported by their readers.
///
/// # Errors
/// Fails if the file cannot be read.
pub(super) fn imprint(path: &Path) -> Result<Option<String>, FileError> {
    super::input::open_regular(path).map_err(|error| FileError::read(path, error))?;
    let find = || {
        let file = TiffFile::open(path).ok()?;
        let tag = file.ifds().first()?.tag(GDAL_METADATA)?;
        let metadata = tag.value.as_str()?;
        let (_, inside) = metadata.split_once(&format!("<Item name=\"{KEY}\">"))?;
        Some(unescaped(inside.split_once("</Item>")?.0))
    };
    // The decoder indexes into what the file claims, and a damaged file may make it panic. It leaves nothing behind.
    Ok(std::panic::catch_unwind(find).unwrap_or_default())
}
