//! The pictures of a GeoTIFF, read in parts from any source of bytes: the full resolution and its overviews.
//!
//! What the header claims is checked as in [`super::open`], and the samples mean the same. In addition every picture
//! knows where its blocks lie, so that they can be brought before they are decoded.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use tiff_reader::source::SharedSource;
use tiff_reader::{Ifd, OpenOptions, TiffError, TiffFile};

use super::georeference::{self, Georeference};
use super::geotiff::{decode_error, geo_tags, meaning, panic_text};
use super::geotiff_layout::{check_image, is_overview};
use super::samples::{Meaning, Tally};
use super::{SourceError, Window, WorldMapping};

const TAG_GDAL_METADATA: u16 = 42112;

/// GDAL frames the blocks of a COG with their sizes.
const FRAME_BYTES: u64 = 4;

/// One picture.
pub(crate) struct Picture {
    ifd: usize,
    pub width: u32,
    pub height: u32,
    /// Columns and rows of a strip or tile.
    pub block: [u32; 2],
    /// For each strip or tile of the first band, by rows, its first byte and how many; 0 where the file leaves it out.
    blocks: Vec<(u64, u64)>,
    pub is_sparse: bool,
}

/// An open GeoTIFF.
pub(crate) struct Pictures {
    name: PathBuf,
    file: TiffFile,
    pictures: Vec<Picture>,
    meaning: Meaning,
    georeference: Georeference,
    told: AtomicBool,
}

impl Pictures {
    /// Opens the TIFF in `source`; `name` stands in messages. `decoded_bytes` of decoded blocks are kept.
    ///
    /// # Errors
    /// As [`super::open`], without those that need the heights.
    pub fn open(source: SharedSource, name: &Path, decoded_bytes: usize) -> Result<Self, SourceError> {
        guarded(name, || Self::open_unguarded(source, name, decoded_bytes))
    }

    fn open_unguarded(source: SharedSource, name: &Path, decoded_bytes: usize) -> Result<Self, SourceError> {
        let file_bytes = source.len();
        let options = OpenOptions { block_cache_bytes: decoded_bytes, ..OpenOptions::default() };
        let file = TiffFile::from_source_with_options(source, options)
            .map_err(|source| SourceError::Damaged { path: name.into(), source })?;
        let none = || SourceError::Inconsistent { path: name.into(), what: "it holds no picture".into() };
        let full = file.ifds().iter().position(|ifd| !is_overview(ifd)).ok_or_else(none)?;
        let ifd = file.ifds().get(full).ok_or_else(none)?;
        let layout = check_image(ifd, file_bytes, name)?;
        let tags = geo_tags(&layout);
        let meaning = meaning(&layout, &tags.geokeys, name);
        let located = |source| SourceError::Georeference { path: name.into(), source };
        let mut georeference = georeference::from_tags(tags, &name.display().to_string()).map_err(located)?;
        WorldMapping::new(&georeference, layout.width, layout.height).map_err(located)?;
        if georeference::vertical_metres_per_unit(&georeference.geokeys).is_some() {
            georeference.geokeys.declare_vertical_metres();
        }

        let mut pictures = vec![picture(ifd, full, layout.width, layout.height, layout.block)];
        for (index, ifd) in file.ifds().iter().enumerate().filter(|(_, ifd)| is_overview(ifd)) {
            // An overview that cannot be read is none; the full resolution stands in.
            match check_image(ifd, file_bytes, name) {
                Ok(found) if found.sample_type == meaning.sample_type && found.width < layout.width => {
                    pictures.push(picture(ifd, index, found.width, found.height, found.block));
                }
                Ok(_) => {}
                Err(error) => tracing::debug!("an overview is passed over: {error}"),
            }
        }
        pictures[1..].sort_by_key(|picture| std::cmp::Reverse(picture.width));
        drop(layout);
        let name = name.to_owned();
        Ok(Self { name, file, pictures, meaning, georeference, told: AtomicBool::new(false) })
    }

    /// The full resolution, then the overviews, the largest first.
    pub fn pictures(&self) -> &[Picture] {
        &self.pictures
    }

    /// Where the full resolution lies.
    pub fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    /// Lowest and highest height in metres by the file's own word, which need not be exact.
    pub fn declared_range_m(&self) -> Option<[f32; 2]> {
        let xml = self.file.ifd(self.pictures[0].ifd).ok()?.tag(TAG_GDAL_METADATA)?.value.as_str()?.to_owned();
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

    /// Where the bytes of a window of a picture lie, with the frames that GDAL puts around blocks.
    pub fn ranges(&self, picture: usize, window: Window) -> Vec<Range<u64>> {
        let picture = &self.pictures[picture];
        let found = picture.blocks_in(window).filter(|&(_, (offset, count))| offset != 0 && count != 0);
        let framed = found.map(|(_, (offset, count))| {
            offset.saturating_sub(FRAME_BYTES)..offset.saturating_add(count).saturating_add(FRAME_BYTES)
        });
        framed.collect()
    }

    /// Where the bytes of the block lie that holds a sample, without a frame; none if the file leaves it out.
    pub fn stored(&self, picture: usize, x: u32, y: u32) -> Option<Range<u64>> {
        let (_, (offset, count)) = self.pictures[picture].blocks_in(Window { x, y, width: 1, height: 1 }).next()?;
        (offset != 0 && count != 0).then(|| offset..offset.saturating_add(count))
    }

    /// The heights in metres of a window inside a picture, row-major, NaN where there is no data.
    ///
    /// # Errors
    /// If a block cannot be decoded; [`SourceError::Damaged`] with [`TiffError::Io`] if it cannot be had.
    pub fn read(&self, picture: usize, window: Window) -> Result<Vec<f32>, SourceError> {
        guarded(&self.name, || self.read_unguarded(&self.pictures[picture], window))
    }

    fn read_unguarded(&self, picture: &Picture, window: Window) -> Result<Vec<f32>, SourceError> {
        let Window { x, y, width, height } = window;
        let ifd = self.file.ifd(picture.ifd).map_err(|source| decode_error(source, &self.name))?;
        let bytes = self
            .file
            .read_band_window_bytes_from_ifd(ifd, 0, y as usize, x as usize, height as usize, width as usize)
            .map_err(|source| decode_error(source, &self.name))?;
        if bytes.len() != window.samples() * self.meaning.sample_type.bytes() {
            let what = "a strip or tile decodes to the wrong size".to_owned();
            return Err(SourceError::Inconsistent { path: self.name.clone(), what });
        }
        let mut heights_m = Vec::with_capacity(window.samples());
        let mut tally = Tally::default();
        self.meaning.append_heights_m(&bytes, &mut heights_m, &mut tally);
        if tally.absurd + tally.implied_voids > 0 && !self.told.swap(true, Ordering::Relaxed) {
            let name = self.name.display();
            tracing::warn!("{name}: samples beyond ±1000 km, and undeclared -32768, are taken as no-data");
        }
        // A sparse file leaves blocks out; they hold the no-data value, or zeros where it names none, as in GDAL.
        if picture.is_sparse && self.meaning.no_data.is_some() {
            for (block, _) in picture.blocks_in(window).filter(|&(_, (offset, count))| offset == 0 || count == 0) {
                for row in block.y..block.y + block.height {
                    let start = (row - y) as usize * width as usize + (block.x - x) as usize;
                    heights_m[start..start + block.width as usize].fill(f32::NAN);
                }
            }
        }
        Ok(heights_m)
    }
}

/// Whether the bytes could not be had, rather than not be decoded.
pub(crate) fn is_unread(error: &SourceError) -> bool {
    matches!(error, SourceError::Damaged { source: TiffError::Io(..), .. })
}

fn picture(ifd: &Ifd, index: usize, width: u32, height: u32, block: [usize; 2]) -> Picture {
    let tables = match (ifd.tile_offsets(), ifd.tile_byte_counts()) {
        (Some(offsets), Some(counts)) => (offsets, counts),
        _ => (ifd.strip_offsets().unwrap_or_default(), ifd.strip_byte_counts().unwrap_or_default()),
    };
    // The sizes of blocks are 32-bit numbers in the file.
    let block = block.map(|size| size as u32);
    let count = width.div_ceil(block[0]) as usize * height.div_ceil(block[1]) as usize;
    let blocks: Vec<(u64, u64)> = tables.0.into_iter().zip(tables.1).take(count).collect();
    let is_sparse = blocks.iter().any(|&(offset, count)| offset == 0 || count == 0);
    Picture { ifd: index, width, height, block, blocks, is_sparse }
}

impl Picture {
    /// The blocks that a window touches: the part of the window that lies in each, and where its bytes are.
    fn blocks_in(&self, window: Window) -> impl Iterator<Item = (Window, (u64, u64))> + '_ {
        let [columns, rows] = self.block;
        let across = self.width.div_ceil(columns);
        let (right, bottom) = (window.x + window.width, window.y + window.height);
        let range = |first: u32, end: u32, size: u32| first / size..end.div_ceil(size);
        range(window.y, bottom, rows).flat_map(move |block_y| {
            range(window.x, right, columns).map(move |block_x| {
                let span = |block: u32, size: u32, first: u32, end: u32| {
                    let start = (block * size).max(first);
                    (start, (block.saturating_add(1).saturating_mul(size)).min(end) - start)
                };
                let (x, width) = span(block_x, columns, window.x, right);
                let (y, height) = span(block_y, rows, window.y, bottom);
                let place = self.blocks.get(block_y as usize * across as usize + block_x as usize);
                (Window { x, y, width, height }, place.copied().unwrap_or_default())
            })
        })
    }
}

/// The decoders index into what the file claims. Should one of them panic on damaged bytes, that is one more kind of
/// damage. Nothing but the decoder's cache outlives the call, and its entries are whole or not there.
fn guarded<T>(name: &Path, work: impl FnOnce() -> Result<T, SourceError>) -> Result<T, SourceError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let what = format!("its decoder gave up ({})", panic_text(panic.as_ref()));
        Err(SourceError::Inconsistent { path: name.into(), what })
    })
}
