//! GeoTIFF and cloud-optimised GeoTIFF → heights in metres.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use tiff_reader::{OpenOptions, TagValue, TiffError, TiffFile};

use super::georeference::{self, GeoTags};
use super::geotiff_layout::{self as layout, Layout};
use super::samples::{BandMetadata, Meaning, Tally, parse_no_data};
use super::{GeoKeys, HeightGrid, Progress, SourceError, WorldMapping};

const TAG_PIXEL_SCALE: u16 = 33550;
const TAG_TIE_POINTS: u16 = 33922;
const TAG_TRANSFORMATION: u16 = 34264;
const TAG_GEO_DIRECTORY: u16 = 34735;
const TAG_GEO_DOUBLES: u16 = 34736;
const TAG_GEO_ASCII: u16 = 34737;
const TAG_GDAL_METADATA: u16 = 42112;
const TAG_GDAL_NODATA: u16 = 42113;

/// So many bytes are decoded between two reports of progress.
const WINDOW_BYTES: usize = 16 << 20;

/// Reads a file that begins as a TIFF does.
///
/// # Errors
/// See [`super::open`].
pub(super) fn read(path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    // The decoders index into what the file claims. Should one of them panic on a damaged file, that is one more kind
    // of damage, not the end of the program. Nothing that outlives the call is changed in it, so unwinding is safe.
    catch_unwind(AssertUnwindSafe(|| read_guarded(path, progress))).unwrap_or_else(|panic| {
        let what = format!("its decoder gave up ({})", panic_text(panic.as_ref()));
        Err(SourceError::Inconsistent { path: path.into(), what })
    })
}

fn read_guarded(path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    let damaged = |source| SourceError::Damaged { path: path.into(), source };
    let file_bytes = std::fs::metadata(path).map_err(|source| SourceError::Open { path: path.into(), source })?.len();
    let options = OpenOptions {
        // Every block is wanted once, so nothing is worth keeping; sizes are checked before anything is decoded.
        block_cache_bytes: 0,
        decode_output_bytes: usize::MAX / 2,
        ..OpenOptions::default()
    };
    let file = TiffFile::open_with_options(path, options).map_err(damaged)?;
    let layout = layout::check(&file, file_bytes, path)?;

    let located = |source| SourceError::Georeference { path: path.into(), source };
    let tags = geo_tags(&layout);
    let meaning = meaning(&layout, &tags.geokeys, path);
    let mut georeference = georeference::from_tags(tags, &path.display().to_string()).map_err(located)?;
    WorldMapping::new(&georeference, layout.width, layout.height).map_err(located)?;
    if georeference::vertical_metres_per_unit(&georeference.geokeys).is_some() {
        georeference.geokeys.declare_vertical_metres();
    }

    let (heights_m, tally) = read_heights(&file, &layout, &meaning, path, progress)?;
    let name = path.display();
    if tally.absurd > 0 {
        tracing::warn!("{name}: {} samples beyond ±1000 km are taken as no-data", tally.absurd);
    }
    if tally.implied_voids > 0 {
        tracing::warn!("{name}: {} samples of -32767 or -32768 are taken as no-data", tally.implied_voids);
    }
    if tally.heights == 0 {
        return Err(SourceError::AllNoData { path: path.into() });
    }
    Ok(HeightGrid { width: layout.width, height: layout.height, heights_m, georeference })
}

pub(super) fn geo_tags(layout: &Layout<'_>) -> GeoTags {
    let value = |tag| layout.ifd.tag(tag).map(|tag| &tag.value);
    let numbers = |tag| value(tag).and_then(TagValue::as_f64_vec).unwrap_or_default();
    let directory = value(TAG_GEO_DIRECTORY).and_then(TagValue::as_u16_slice).unwrap_or_default();
    let ascii = value(TAG_GEO_ASCII).and_then(TagValue::as_str).unwrap_or_default();
    GeoTags {
        pixel_scale: numbers(TAG_PIXEL_SCALE),
        tie_points: numbers(TAG_TIE_POINTS),
        transformation: numbers(TAG_TRANSFORMATION),
        geokeys: GeoKeys::parse(directory, &numbers(TAG_GEO_DOUBLES), ascii),
    }
}

pub(super) fn meaning(layout: &Layout<'_>, geokeys: &GeoKeys, path: &Path) -> Meaning {
    let text = |tag| layout.ifd.tag(tag).and_then(|tag| tag.value.as_str());
    let no_data = text(TAG_GDAL_NODATA).and_then(|text| {
        let no_data = parse_no_data(text);
        if no_data.is_none() {
            tracing::warn!("{}: its no-data mark {text:?} is no number and is passed over", path.display());
        }
        no_data
    });
    let band = BandMetadata::parse(text(TAG_GDAL_METADATA).unwrap_or_default());
    let by_keys = || georeference::vertical_metres_per_unit(geokeys);
    Meaning {
        sample_type: layout.sample_type,
        no_data,
        scale: band.scale.unwrap_or(1.0),
        offset: band.offset.unwrap_or(0.0),
        metres_per_unit: band.metres_per_unit().or_else(by_keys).unwrap_or(1.0),
    }
}

fn read_heights(
    file: &TiffFile,
    layout: &Layout<'_>,
    meaning: &Meaning,
    path: &Path,
    progress: &dyn Progress,
) -> Result<(Vec<f32>, Tally), SourceError> {
    let (width, height) = (layout.width as usize, layout.height as usize);
    let mut heights_m = Vec::new();
    let too_large = |_| SourceError::TooLarge { path: path.into(), width: layout.width, height: layout.height };
    heights_m.try_reserve_exact(width * height).map_err(too_large)?;
    let mut tally = Tally::default();
    // Whole strips or rows of tiles, so that no block is decoded twice.
    let block_rows = layout.block[1].min(height);
    let rows_per_window =
        (WINDOW_BYTES / (width * meaning.sample_type.bytes()) / block_rows).max(1).saturating_mul(block_rows);
    let mut row = 0;
    while row < height {
        progress.report("reading heights", row as f32 / height as f32);
        let rows = rows_per_window.min(height - row);
        let bytes = file
            .read_band_window_bytes_from_ifd(layout.ifd, 0, row, 0, rows, width)
            .map_err(|source| decode_error(source, path))?;
        if bytes.len() != rows * width * meaning.sample_type.bytes() {
            let what = "a strip or tile decodes to the wrong size".to_owned();
            return Err(SourceError::Inconsistent { path: path.into(), what });
        }
        meaning.append_heights_m(&bytes, &mut heights_m, &mut tally);
        row += rows;
    }
    // A sparse file leaves blocks out; they hold the no-data value, or zeros where it names none, as in GDAL.
    if meaning.no_data.is_some() {
        for [columns, rows] in &layout.absent_blocks {
            for row in rows[0]..rows[1] {
                let absent = &mut heights_m[row * width + columns[0]..row * width + columns[1]];
                tally.heights -= absent.iter().filter(|height| !height.is_nan()).count() as u64;
                absent.fill(f32::NAN);
            }
        }
    }
    progress.report("reading heights", 1.0);
    Ok((heights_m, tally))
}

pub(super) fn decode_error(source: TiffError, path: &Path) -> SourceError {
    match source {
        TiffError::UnsupportedCompression(code) => {
            SourceError::Unsupported { path: path.into(), what: format!("compression {code}") }
        }
        TiffError::UnsupportedPredictor(code) => {
            SourceError::Unsupported { path: path.into(), what: format!("predictor {code} for this sample type") }
        }
        source => SourceError::Damaged { path: path.into(), source },
    }
}

pub(super) fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a word")
}
