//! Reads the pictures of a GeoTIFF (the full resolution and its overviews) in parts from any source of bytes.
//!
//! The header is checked as in [`super::open`], and the samples mean the same. In addition every picture can report
//! where its blocks are stored, so that they can be fetched before they are decoded.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tiff_reader::cache::BlockCache;
use tiff_reader::source::SharedSource;
use tiff_reader::{OpenOptions, TiffError, TiffFile};

use super::georeference::{self, Georeference};
use super::geotiff::{damaged, decode_error, geo_tags, meaning, panic_text};
use super::geotiff_layout::{check, check_image, is_overview};
use super::masked::Mask;
use super::samples::{Meaning, Tally};
use super::tiff_blocks::{self as tiff_blocks, Blocks};
use super::{Holds, SourceError, Window, WorldMapping};

const TAG_GDAL_METADATA: u16 = 42112;

/// Size in bytes of the frames that GDAL puts around the blocks of a COG.
const FRAME_BYTES: u64 = 4;

/// A picture of the file.
pub(crate) struct Picture {
    pub width: u32,
    pub height: u32,
    /// Columns and rows of a strip or tile.
    pub block: [u32; 2],
    blocks: Arc<Blocks>,
    mask: Option<Mask>,
    /// Whether the file leaves blocks out.
    is_sparse: bool,
}

/// An open GeoTIFF with its overviews.
pub(crate) struct Pictures {
    name: PathBuf,
    file: Arc<TiffFile>,
    cache: Arc<BlockCache>,
    pictures: Vec<Picture>,
    meaning: Meaning,
    georeference: Georeference,
    has_warned: AtomicBool,
}

impl Pictures {
    /// Opens the TIFF in `source`; `name` is used in messages. Up to `decoded_bytes` of decoded blocks are cached.
    ///
    /// # Errors
    /// The same as [`super::open`], without those that depend on the heights.
    pub(crate) fn open(source: SharedSource, name: &Path, decoded_bytes: usize) -> Result<Self, SourceError> {
        guarded(name, || Self::open_unguarded(source, name, decoded_bytes))
    }

    fn open_unguarded(source: SharedSource, name: &Path, decoded_bytes: usize) -> Result<Self, SourceError> {
        let file_bytes = source.len();
        let options = OpenOptions { block_cache_bytes: decoded_bytes, ..OpenOptions::default() };
        let file = TiffFile::from_source_with_options(source, options).map_err(damaged(name))?;
        let file = Arc::new(file);
        let cache = tiff_blocks::cache(decoded_bytes);
        let layout = check(&file, file_bytes, name, Holds::Heights)?;
        let (width, sample_type) = (layout.width, layout.blocks.samples.decoded);
        let ifd = file.ifd(layout.blocks.ifd).map_err(damaged(name))?;
        let tags = geo_tags(ifd);
        let meaning = meaning(ifd, sample_type, &tags.geokeys, name);
        let located = |source| SourceError::Georeference { path: name.into(), source };
        let mut georeference = georeference::from_tags(tags, &name.display().to_string()).map_err(located)?;
        WorldMapping::new(&georeference, layout.width, layout.height).map_err(located)?;
        if georeference::vertical_metres_per_unit(&georeference.geokeys).is_some() {
            georeference.geokeys.declare_vertical_metres();
        }

        let picture = |blocks: Blocks| {
            let blocks = Arc::new(blocks);
            let mask = Mask::internal(&file, &cache, &blocks, file_bytes, name)?;
            let ([width, height], block, is_sparse) = (blocks.size, blocks.block, blocks.is_sparse());
            Ok::<_, SourceError>(Picture { width, height, block, blocks, mask, is_sparse })
        };
        let mut pictures = vec![picture(layout.blocks)?];
        for (index, ifd) in file.ifds().iter().enumerate().filter(|(_, ifd)| is_overview(ifd)) {
            // An overview that cannot be read is ignored; the full resolution replaces it.
            match check_image(ifd, index, file_bytes, name) {
                Ok(found) if found.blocks.samples.decoded == sample_type && found.width < width => {
                    pictures.push(picture(found.blocks)?);
                }
                Ok(_) => {}
                Err(error) => tracing::debug!("an overview is ignored: {error}"),
            }
        }
        pictures[1..].sort_by_key(|picture| std::cmp::Reverse(picture.width));
        // If the full resolution has a mask, an overview needs one too: it may contain values of masked samples.
        if pictures[0].mask.is_some() {
            pictures.retain(|picture| picture.mask.is_some());
        }
        let name = name.to_owned();
        Ok(Self { name, file, cache, pictures, meaning, georeference, has_warned: AtomicBool::new(false) })
    }

    /// Returns the full resolution, then the overviews, the largest first.
    pub(crate) fn pictures(&self) -> &[Picture] {
        &self.pictures
    }

    /// Returns the georeference of the full resolution.
    pub(crate) fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    /// Returns the lowest and highest height in metres that the file's statistics declare; they need not be exact.
    pub(crate) fn declared_range_m(&self) -> Option<[f32; 2]> {
        let xml = self.file.ifd(self.pictures[0].blocks.ifd).ok()?.tag(TAG_GDAL_METADATA)?.value.as_str()?.to_owned();
        let number = |name: &str| {
            let (_, item) = xml.split_once(&format!("\"STATISTICS_{name}\" sample=\"0\""))?;
            item.split_once('>')?.1.split('<').next()?.trim().parse::<f64>().ok()
        };
        let mut tally = Tally::default();
        let mut height_m = |value: f64| {
            let Meaning { scale, offset, metres_per_unit, .. } = self.meaning;
            tally.heights += 1;
            ((value * scale + offset) * metres_per_unit) as f32
        };
        let range = [height_m(number("MINIMUM")?), height_m(number("MAXIMUM")?)];
        (range[0] <= range[1] && range.iter().all(|height| height.is_finite())).then_some(range)
    }

    /// Returns the byte ranges of the blocks of a window, including the frames that GDAL puts around blocks.
    pub(crate) fn ranges(&self, picture: usize, window: Window) -> Vec<Range<u64>> {
        let Picture { blocks, mask, .. } = &self.pictures[picture];
        // A mask that is a band is stored in the blocks of the heights.
        let mask = mask.iter().map(|mask| &mask.blocks).filter(|mask| !Arc::ptr_eq(mask, blocks));
        let places = std::iter::once(blocks)
            .chain(mask)
            .flat_map(|blocks| blocks.parts(window).filter_map(|part| blocks.place(part.block)));
        let framed = places.map(|(offset, count)| {
            offset.saturating_sub(FRAME_BYTES)..offset.saturating_add(count).saturating_add(FRAME_BYTES)
        });
        framed.collect()
    }

    /// Returns the byte range, without a frame, of the block that contains a sample; `None` if the file leaves it out.
    pub(crate) fn stored(&self, picture: usize, x: u32, y: u32) -> Option<Range<u64>> {
        let blocks = &self.pictures[picture].blocks;
        let part = blocks.parts(Window { x, y, width: 1, height: 1 }).next()?;
        blocks.place(part.block).map(|(offset, count)| offset..offset.saturating_add(count))
    }

    /// Returns the heights in metres of a window inside a picture, row-major, NaN where there is no data.
    ///
    /// # Errors
    /// Fails if a block cannot be decoded; returns [`SourceError::Damaged`] with [`TiffError::Io`] if it cannot be
    /// read.
    pub(crate) fn read(&self, picture: usize, window: Window) -> Result<Vec<f32>, SourceError> {
        guarded(&self.name, || self.read_unguarded(&self.pictures[picture], window))
    }

    fn read_unguarded(&self, picture: &Picture, window: Window) -> Result<Vec<f32>, SourceError> {
        let bytes = picture
            .blocks
            .read(&self.file, &self.cache, 0, window)
            .map_err(|source| decode_error(source, &self.name))?;
        if bytes.len() != window.samples() * self.meaning.sample_type.bytes() {
            let what = "a strip or tile decodes to the wrong size".to_owned();
            return Err(SourceError::Inconsistent { path: self.name.clone(), what });
        }
        let mut heights_m = Vec::with_capacity(window.samples());
        let mut tally = Tally::default();
        self.meaning.append_heights_m(&bytes, &mut heights_m, &mut tally);
        if tally.absurd + tally.implied_voids > 0 && !self.has_warned.swap(true, Ordering::Relaxed) {
            let name = self.name.display();
            tracing::warn!("{name}: samples beyond ±1000 km, and undeclared -32768, are treated as no-data");
        }
        // A sparse file leaves blocks out; they hold the no-data value, or zeros if it declares none, as in GDAL.
        if picture.is_sparse && self.meaning.no_data.is_some() {
            let absent = picture.blocks.parts(window).filter(|part| picture.blocks.place(part.block).is_none());
            for part in absent {
                part.window.fill(window, &mut heights_m, f32::NAN);
            }
        }
        if let Some(mask) = &picture.mask {
            mask.apply(window, &mut heights_m)?;
        }
        Ok(heights_m)
    }
}

/// Returns whether the bytes could not be read, in contrast to bytes that could not be decoded.
pub(crate) fn is_unread(error: &SourceError) -> bool {
    matches!(error, SourceError::Damaged { source: TiffError::Io(..), .. })
}

/// Runs a decoder and converts a panic to an error. Decoders index into what the file claims, so damaged bytes may make
/// them panic. Only the decoder's cache outlives the call, and its entries are complete or absent, so that unwinding is
/// safe.
fn guarded<T>(name: &Path, work: impl FnOnce() -> Result<T, SourceError>) -> Result<T, SourceError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let what = format!("its decoder failed ({})", panic_text(panic.as_ref()));
        Err(SourceError::Inconsistent { path: name.into(), what })
    })
}
