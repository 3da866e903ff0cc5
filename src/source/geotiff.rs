//! Reads GeoTIFF and cloud-optimised GeoTIFF by windows as heights in metres (OGC 19-008r4; TIFF 6.0; BigTIFF).

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tiff_reader::cache::BlockCache;
use tiff_reader::{ByteOrder, Ifd, OpenOptions, TagValue, TiffError, TiffFile};

use super::flat::{Description, FlatReader};
use super::georeference::{self, GeoTags, Georeference};
use super::geotiff_layout::{self as layout, Layout};
use super::masked::{Mask, Masked};
use super::memory;
use super::place::{self, cannot_open, check_window, inconsistent};
use super::reader::{HeightReader, Window};
use super::samples::{BandMetadata, Meaning, SampleType, Tally, WarnOnce, parse_no_data};
use super::tiff_blocks::{self as tiff_blocks, Blocks};
use super::tiff_sidecars::TiffSidecars;
use super::values::{Holds, Values};
use super::{GeoKeys, SourceError, WorldMapping, esri_citation};
use crate::file::message::{printable, quoted, shown};

const TAG_PIXEL_SCALE: u16 = 33550;
const TAG_TIE_POINTS: u16 = 33922;
const TAG_TRANSFORMATION: u16 = 34264;
const TAG_GEO_DIRECTORY: u16 = 34735;
const TAG_GEO_DOUBLES: u16 = 34736;
const TAG_GEO_ASCII: u16 = 34737;
const TAG_GDAL_METADATA: u16 = 42112;
const TAG_GDAL_NODATA: u16 = 42113;

/// Largest number of characters of a decoder's message; longer ones are shortened.
const MAX_DECODER_CHARS: usize = 90;

/// Largest number of characters of a longer message, which is cut in the middle.
const MAX_FOREIGN_CHARS: usize = 120;

/// Size of the cache of decoded strips and tiles, for windows that do not begin and end at block borders.
const CACHE_BYTES: usize = 32 << 20;

/// A TIFF whose header has been checked.
pub(super) struct GeoTiffReader {
    path: PathBuf,
    file: Arc<TiffFile>,
    cache: Arc<BlockCache>,
    blocks: Arc<Blocks>,
    /// Size of a decoded block with all bands that are stored in it.
    block_bytes: u64,
    meaning: Meaning,
    georeference: Georeference,
    identity: String,
    warnings: WarnOnce,
}

impl GeoTiffReader {
    /// Opens a file that begins as a TIFF does.
    ///
    /// # Errors
    /// The same as [`super::open_reader`].
    pub(super) fn open(path: &Path) -> Result<Box<dyn HeightReader>, SourceError> {
        Ok(Self::open_as(path, Holds::Heights)?.reader)
    }

    /// Opens a file that begins as a TIFF does and holds the given kind of values.
    ///
    /// # Errors
    /// The same as [`Self::open`].
    pub(super) fn open_as(path: &Path, holds: Holds) -> Result<Values, SourceError> {
        guarded(path, || Self::open_unguarded(path, holds))
    }

    fn open_unguarded(path: &Path, holds: Holds) -> Result<Values, SourceError> {
        let damaged = damaged(path);
        let file_bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
        let options = OpenOptions {
            block_cache_bytes: CACHE_BYTES,
            // Sizes are checked before anything is decoded.
            decode_output_bytes: usize::MAX / 2,
            ..OpenOptions::default()
        };
        let mut file = TiffFile::open_with_options(path, options).map_err(damaged)?;
        let Layout { width, height, blocks, block_bytes, strides } = layout::check(&file, file_bytes, path, holds)?;
        // With a smaller cache, a strip of the whole picture would be decoded again for each window.
        let cache_bytes = CACHE_BYTES.max(block_bytes as usize);
        if strides.is_none() && cache_bytes > CACHE_BYTES {
            let options = OpenOptions { block_cache_bytes: cache_bytes, ..options };
            file = TiffFile::open_with_options(path, options).map_err(damaged)?;
        }
        let (file, blocks) = (Arc::new(file), Arc::new(blocks));
        let ifd = file.ifd(blocks.ifd).map_err(damaged)?;

        let located = |source| SourceError::Georeference { path: path.into(), source };
        let sidecars = TiffSidecars::of(path);
        let mut tags = geo_tags(ifd);
        let mut meaning = meaning(ifd, blocks.samples.decoded, &tags.geokeys, path);
        sidecars.overrule(&mut meaning);
        if holds == Holds::Heights {
            sidecars.warn_of_unit(path);
        } else {
            meaning = Meaning::metres(meaning.sample_type, meaning.no_data);
        }
        let name = path.display().to_string();
        let place = sidecars.place(&mut tags);
        let mut georeference = match place {
            Some(crs_from_grid) => georeference::from_transform(crs_from_grid, tags.geokeys, &name).map_err(located)?,
            None if holds == Holds::Shades => georeference::assumed(),
            None => georeference::assumed_with_warning(&tags, &name),
        };
        WorldMapping::new(&georeference, width, height).map_err(located)?;
        if georeference::vertical_metres_per_unit(&georeference.geokeys).is_some() {
            georeference.geokeys.declare_vertical_metres();
        }
        let files: Vec<&Path> = std::iter::once(path).chain(sidecars.files.iter().map(PathBuf::as_path)).collect();
        let identity = place::identity(&files, "");
        let cache = tiff_blocks::cache(cache_bytes);
        let masks = Mask::all(&file, &cache, &blocks, file_bytes, path)?;
        let full = blocks.samples.decoded.largest(blocks.samples.bits);
        // A strip may hold the whole picture; if it is not compressed, a window needs only its own samples.
        let heights: Box<dyn HeightReader> = if let Some(strides) = strides {
            let (size, is_big_endian) = ([width, height], file.byte_order() == ByteOrder::BigEndian);
            let described = Description { size, strides, is_big_endian, meaning, georeference, identity };
            Box::new(FlatReader::new(path, None, described)?)
        } else {
            Box::new(Self {
                path: path.into(),
                file,
                cache,
                blocks,
                block_bytes,
                meaning,
                georeference,
                identity,
                warnings: WarnOnce::default(),
            })
        };
        Ok(Values { reader: Masked::over(heights, masks, path), full, is_located: place.is_some() })
    }

    fn read_unguarded(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        if self.is_serial() {
            // The decoder would abort the program if there is not enough memory for a block.
            memory::room::<u8>(&self.path, self.size(), self.block_bytes)?;
        }
        let mut heights_m = memory::window_room(&self.path, window)?;
        let bytes =
            self.blocks.read(&self.file, &self.cache, 0, window).map_err(|source| decode_error(source, &self.path))?;
        if bytes.len() != window.samples() * self.meaning.sample_type.bytes() {
            return Err(inconsistent(&self.path, "a strip or tile decodes to the wrong size"));
        }
        let mut tally = Tally::default();
        self.meaning.append_heights_m(&bytes, &mut heights_m, &mut tally);
        self.warnings.warn(&self.path, &tally);
        // A sparse file leaves blocks out; they hold the no-data value, or zeros if it declares none, as in GDAL.
        if self.meaning.no_data.is_some() {
            let absent = self.blocks.parts(window).filter(|part| self.blocks.place(part.block).is_none());
            for part in absent {
                part.window.fill(window, &mut heights_m, f32::NAN);
            }
        }
        Ok(heights_m)
    }
}

impl HeightReader for GeoTiffReader {
    fn size(&self) -> [u32; 2] {
        self.blocks.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        check_window(&self.path, window, self.size())?;
        if window.samples() == 0 {
            return Ok(Vec::new());
        }
        if let Some(height_m) = self.known_m(window) {
            let mut heights_m = memory::window_room(&self.path, window)?;
            heights_m.resize(window.samples(), height_m);
            return Ok(heights_m);
        }
        guarded(&self.path, || self.read_unguarded(window))
    }

    fn known_m(&self, window: Window) -> Option<f32> {
        // Blocks that are left out hold the no-data value, or zeros if the file declares none, as in GDAL.
        self.blocks.is_absent(window).then(|| match self.meaning.no_data {
            Some(_) => f32::NAN,
            None => self.meaning.height_m(0.0, &mut Tally::default()),
        })
    }

    fn is_serial(&self) -> bool {
        self.block_bytes > CACHE_BYTES as u64
    }

    fn block(&self) -> [u32; 2] {
        let ([columns, rows], [width, height]) = (self.blocks.block, self.blocks.size);
        [columns.min(width), rows.min(height)]
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

/// Runs a decoder and converts a panic to an error. Decoders index into what the file claims, so a damaged file may
/// make them panic, which must not end the program. Only the decoder's cache outlives the call, and its entries are
/// complete or absent, so unwinding is safe.
pub(super) fn guarded<T>(path: &Path, work: impl FnOnce() -> Result<T, SourceError>) -> Result<T, SourceError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        Err(inconsistent(path, format!("its decoder failed ({})", shown(panic_text(panic.as_ref())))))
    })
}

pub(super) fn geo_tags(ifd: &Ifd) -> GeoTags {
    let value = |tag| ifd.tag(tag).map(|tag| &tag.value);
    let numbers = |tag| value(tag).and_then(TagValue::as_f64_vec).unwrap_or_default();
    let directory = value(TAG_GEO_DIRECTORY).and_then(TagValue::as_u16_slice).unwrap_or_default();
    let ascii = value(TAG_GEO_ASCII).and_then(TagValue::as_str).unwrap_or_default();
    GeoTags {
        pixel_scale: numbers(TAG_PIXEL_SCALE),
        tie_points: numbers(TAG_TIE_POINTS),
        transformation: numbers(TAG_TRANSFORMATION),
        geokeys: esri_citation::understood(GeoKeys::parse(directory, &numbers(TAG_GEO_DOUBLES), ascii)),
    }
}

pub(super) fn meaning(ifd: &Ifd, sample_type: SampleType, geokeys: &GeoKeys, path: &Path) -> Meaning {
    let text = |tag| ifd.tag(tag).and_then(|tag| tag.value.as_str());
    let no_data = text(TAG_GDAL_NODATA).and_then(|text| {
        let no_data = parse_no_data(text);
        if no_data.is_none() {
            tracing::warn!("{}: its no-data value {} is not a number and is ignored", path.display(), quoted(text));
        }
        no_data
    });
    let band = BandMetadata::parse(text(TAG_GDAL_METADATA).unwrap_or_default());
    let by_keys = || {
        georeference::warn_of_vertical_unit(geokeys, &path.display().to_string());
        georeference::vertical_unit_m(geokeys)
    };
    let unit_m = band.metres_per_unit().or_else(by_keys);
    if unit_m.is_none() {
        band.warn_of_unit(path);
    }
    Meaning {
        sample_type,
        no_data,
        scale: band.scale.unwrap_or(1.0),
        offset: band.offset.unwrap_or(0.0),
        metres_per_unit: unit_m.unwrap_or(1.0),
        has_unit: unit_m.is_some(),
    }
}

/// Returns a function that converts an error of the TIFF reader.
pub(super) fn damaged(path: &Path) -> impl Fn(TiffError) -> SourceError + Copy + '_ {
    |source| SourceError::Damaged { path: path.into(), source: plain(source) }
}

/// Names of tags in messages.
const TAG_NAMES: [(u16, &str); 4] =
    [(273, "StripOffsets"), (279, "StripByteCounts"), (324, "TileOffsets"), (325, "TileByteCounts")];

/// Replaces messages that only a programmer of the decoder understands by a plain cause.
fn plain(error: TiffError) -> TiffError {
    let is_of_program = |words: &str| words.contains("usize") || words.contains("budget");
    let words = match &error {
        // An unsupported feature is not damage. An error of the file system may name any file.
        TiffError::DecompressionFailed { reason, .. } if reason.contains("nsupported") => return error,
        TiffError::Io(..) => return error,
        TiffError::DecompressionFailed { index, reason } => {
            // Most reasons begin with the name of the codec.
            let codec = reason.split_once(": ").map_or("", |(codec, _)| codec);
            let is_name = !codec.is_empty() && codec.chars().all(char::is_alphanumeric);
            let codec = if is_name { codec } else { "compressed" };
            format!("the {codec} data of strip or tile {index} cannot be decoded")
        }
        TiffError::InvalidTagValue { tag, reason } if is_of_program(reason) => {
            let name = TAG_NAMES.iter().find(|(known, _)| known == tag);
            let name = name.map_or(String::new(), |(_, name)| format!(" ({name})"));
            format!("tag {tag}{name} claims more values than can be read")
        }
        other if is_of_program(&other.to_string()) => "it claims more data than can be read".to_owned(),
        _ => return error,
    };
    tracing::debug!("{error}");
    TiffError::Other(words)
}

pub(super) fn decode_error(source: TiffError, path: &Path) -> SourceError {
    match plain(source) {
        TiffError::UnsupportedCompression(code) => {
            SourceError::Unsupported { path: path.into(), what: format!("compression {code}") }
        }
        TiffError::UnsupportedPredictor(code) => {
            SourceError::Unsupported { path: path.into(), what: format!("predictor {code} for this sample type") }
        }
        // `cog::is_unread` later distinguishes read errors by this variant.
        source @ TiffError::Io(..) => SourceError::Damaged { path: path.into(), source },
        source => {
            let words = source.to_string();
            match words.chars().count() > MAX_DECODER_CHARS {
                // Long messages of the decoders are not sentences that fit in one line.
                true => inconsistent(path, printable(&words, MAX_FOREIGN_CHARS)),
                false => SourceError::Damaged { path: path.into(), source },
            }
        }
    }
}

pub(super) fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_in_plain_words() {
        let undecoded = |reason: &str| TiffError::DecompressionFailed { index: 3, reason: reason.to_owned() };
        let tag = |tag, reason: &str| TiffError::InvalidTagValue { tag, reason: reason.to_owned() };
        for (error, expected) in [
            (
                undecoded(
                    "ZSTD: Failed to parse block header: DecodeSequenceError(ExtraBits { bits_remaining: 1656 })",
                ),
                "the ZSTD data of strip or tile 3 cannot be decoded",
            ),
            (
                undecoded("decoded block is too small: expected at least 9 bytes, found 8"),
                "the compressed data of strip or tile 3 cannot be decoded",
            ),
            (
                tag(273, "value byte length overflows usize"),
                "tag 273 (StripOffsets) claims more values than can be read",
            ),
            (
                tag(270, "value byte length 4278302410 exceeds parse budget 134217728"),
                "tag 270 claims more values than can be read",
            ),
            (
                TiffError::InvalidImageLayout("strip count overflows usize".into()),
                "it claims more data than can be read",
            ),
            // Plain already.
            (tag(330, "expected 2 values, found 1"), "invalid TIFF tag 330: expected 2 values, found 1"),
        ] {
            assert_eq!(plain(error).to_string(), expected);
        }
    }
}
