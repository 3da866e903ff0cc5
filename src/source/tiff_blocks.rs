//! Decodes the strips and tiles of a picture in a TIFF to the samples of one band, by windows.
//!
//! `tiff-reader` parses the file and decodes LERC, JPEG and WebP. All other codecs are assembled here from its filters,
//! because libtiff, and therefore GDAL, reads files that it rejects: a last strip that is padded to RowsPerStrip, tiles
//! with their offsets in the tags of strips, LZMA, and samples of 16, 24 or odd numbers of bits.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use tiff_reader::cache::{BlockCache, BlockKey, BlockKind};
use tiff_reader::{ByteOrder, Ifd, TagValue, TiffError, TiffFile};

use super::SourceError;
use super::reader::Window;
use super::tiff_samples::Samples;

const TAG_STRIP_OFFSETS: u16 = 273;
const TAG_STRIP_BYTE_COUNTS: u16 = 279;
const TAG_TILE_OFFSETS: u16 = 324;
const TAG_TILE_BYTE_COUNTS: u16 = 325;

pub(super) const CODEC_NONE: u16 = 1;
const CODEC_JPEG: u16 = 7;
const CODEC_LZMA: u16 = 34_925;
const CODEC_LERC: u16 = 34_887;
const CODEC_WEBP: u16 = 50_001;

/// Largest number of decoded blocks in the cache.
const CACHE_SLOTS: usize = 257;

/// Memory limit for LZMA in KiB. Its dictionaries have at most 64 MiB with every preset; a stream that requests more is
/// hostile.
const LZMA_MEMORY_KIB: u32 = 80 * 1024;

/// The positions of a picture's blocks in the file, and their encoding.
pub(super) struct Blocks {
    /// Index of the picture in the file.
    pub ifd: usize,
    /// Samples per row, and rows.
    pub size: [u32; 2],
    /// Columns and rows of a strip or tile.
    pub block: [u32; 2],
    pub samples: Samples,
    codec: u16,
    is_tiled: bool,
    is_reversed: bool,
    /// Key of the picture's blocks in the cache.
    key: u64,
    /// First byte and number of bytes of each block, by rows; band after band if bands are stored separately. 0 if the
    /// file leaves the block out.
    places: Vec<(u64, u64)>,
}

/// Creates the cache for the decoded blocks of a file.
pub(super) fn cache(bytes: usize) -> Arc<BlockCache> {
    Arc::new(BlockCache::new(bytes, CACHE_SLOTS))
}

/// The part of a window inside one block, and the index of that block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub block: usize,
    /// The part in samples of the picture.
    pub window: Window,
}

impl Blocks {
    /// Reads the block tables of the picture `ifd`, number `index` of a file of `file_bytes` bytes. Allocates nothing
    /// but the tables that the file contains.
    ///
    /// # Errors
    /// Fails if tables are missing, or shorter than the picture requires.
    pub(super) fn of(
        ifd: &Ifd,
        index: usize,
        samples: Samples,
        file_bytes: u64,
        path: &Path,
    ) -> Result<Self, SourceError> {
        let inconsistent = |what: &str| SourceError::Inconsistent { path: path.into(), what: what.to_owned() };
        let size = [ifd.width(), ifd.height()];
        let tile = ifd.tile_width().zip(ifd.tile_height());
        let block = tile.map_or([size[0], ifd.rows_per_strip().min(size[1])], |(width, height)| [width, height]);
        if block.contains(&0) {
            return Err(inconsistent("its strips or tiles have zero size"));
        }
        // The offsets of tiles may be in the tags of strips, and vice versa.
        let (tiles, strips) = ([TAG_TILE_OFFSETS, TAG_TILE_BYTE_COUNTS], [TAG_STRIP_OFFSETS, TAG_STRIP_BYTE_COUNTS]);
        let order = if tile.is_some() { [tiles, strips] } else { [strips, tiles] };
        let [offsets, counts] = order.into_iter().find(|tags| ifd.tag(tags[0]).is_some()).unwrap_or(order[0]);
        let offsets = numbers(ifd, offsets).ok_or_else(|| inconsistent("it has no offsets of strips or tiles"))?;

        let per_band = u64::from(size[0].div_ceil(block[0])) * u64::from(size[1].div_ceil(block[1]));
        let needed = per_band.saturating_mul(if samples.is_planar { samples.per_pixel as u64 } else { 1 });
        if (offsets.len() as u64) < needed {
            return Err(inconsistent("it lists fewer strips or tiles than its size needs"));
        }
        let places: Vec<(u64, u64)> = match numbers(ifd, counts) {
            Some(counts) if (counts.len() as u64) < needed => {
                return Err(inconsistent("it lists fewer strips or tiles than its size needs"));
            }
            Some(counts) => offsets.into_iter().zip(counts).take(needed as usize).collect(),
            // Without byte counts, a block is assumed to end at the end of the file at most.
            None => offsets.into_iter().map(|at| (at, file_bytes.saturating_sub(at))).take(needed as usize).collect(),
        };
        let codec = ifd.compression();
        Ok(Self {
            ifd: index,
            size,
            block,
            samples,
            codec,
            is_tiled: tile.is_some(),
            is_reversed: ifd.fill_order() == 2,
            key: ifd.offset(),
            places,
        })
    }

    /// Returns the unpacked bytes of a block with all bands that are stored in it; saturating.
    pub(super) fn block_bytes(&self) -> u64 {
        (self.row_bytes() as u64).saturating_mul(self.block[1].into())
    }

    /// Returns the unpacked bytes of a row of a block.
    pub(super) fn row_bytes(&self) -> usize {
        let bits = u128::from(self.block[0]) * self.samples.interleaved() as u128 * u128::from(self.samples.bits);
        usize::try_from(bits.div_ceil(8)).unwrap_or(usize::MAX)
    }

    pub(super) fn is_tiled(&self) -> bool {
        self.is_tiled
    }

    /// Returns the number of blocks of the first band that the file contains.
    pub(super) fn stored(&self) -> u64 {
        self.places.iter().take(self.per_band()).filter(|&&place| !is_absent(place)).count() as u64
    }

    /// Returns whether the file leaves out all blocks of the first band that a window touches.
    pub(super) fn is_absent(&self, window: Window) -> bool {
        let is_inside =
            |at: u32, count: u32, size: u32| count > 0 && at.checked_add(count).is_some_and(|it| it <= size);
        is_inside(window.x, window.width, self.size[0])
            && is_inside(window.y, window.height, self.size[1])
            && self.parts(window).all(|part| self.place(part.block).is_none())
    }

    /// Returns whether the file leaves out any block of the first band.
    pub(super) fn is_sparse(&self) -> bool {
        self.places.iter().take(self.per_band()).any(|&place| is_absent(place))
    }

    fn per_band(&self) -> usize {
        self.size[0].div_ceil(self.block[0]) as usize * self.size[1].div_ceil(self.block[1]) as usize
    }

    /// Returns the first byte and the number of bytes of a block of the first band; `None` if the file leaves it out.
    pub(super) fn place(&self, block: usize) -> Option<(u64, u64)> {
        self.places.get(block).copied().filter(|&place| !is_absent(place))
    }

    /// Returns the first bytes of the first band's blocks, by rows.
    pub(super) fn offsets(&self) -> impl Iterator<Item = u64> + '_ {
        self.places.iter().take(self.per_band()).map(|place| place.0)
    }

    /// Returns the blocks of the first band that a window touches.
    pub(super) fn parts(&self, window: Window) -> impl Iterator<Item = Part> + '_ {
        let [columns, rows] = self.block;
        let across = self.size[0].div_ceil(columns);
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
                let block = block_y as usize * across as usize + block_x as usize;
                Part { block, window: Window { x, y, width, height } }
            })
        })
    }

    /// Returns the samples of a band in a window inside the picture, row-major, in the machine's byte order and with
    /// the type `samples.decoded`. Blocks that the file leaves out are zeros.
    ///
    /// # Errors
    /// Fails if a block cannot be read or decoded.
    pub(super) fn read(
        &self,
        file: &TiffFile,
        cache: &BlockCache,
        band: usize,
        window: Window,
    ) -> Result<Vec<u8>, TiffError> {
        let sample_bytes = self.samples.decoded.bytes();
        if matches!(self.codec, CODEC_JPEG | CODEC_LERC | CODEC_WEBP) {
            let [x, y, width, height] = [window.x, window.y, window.width, window.height].map(|it| it as usize);
            let mut bytes = file.read_band_window_bytes_from_ifd(file.ifd(self.ifd)?, band, y, x, height, width)?;
            // libtiff swaps the bytes of LERC data as it does those of every codec, although LERC has its own byte
            // order.
            if self.codec == CODEC_LERC && file.byte_order() == ByteOrder::BigEndian && sample_bytes > 1 {
                bytes.chunks_exact_mut(sample_bytes).for_each(<[u8]>::reverse);
            }
            return Ok(bytes);
        }
        let mut out = Vec::new();
        let length = window.samples().saturating_mul(sample_bytes);
        out.try_reserve_exact(length).map_err(|error| TiffError::DecodeOutputAllocationFailed {
            requested: length,
            reason: error.to_string(),
        })?;
        out.resize(length, 0);
        let out = Mutex::new(out);
        let parts: Vec<Part> = self.parts(window).collect();
        let (plane, first) = if self.samples.is_planar { (band * self.per_band(), 0) } else { (0, band) };
        parts.into_par_iter().try_for_each(|part| {
            let decoded = self.decoded(file, cache, plane + part.block)?;
            let stride = self.samples.interleaved() * sample_bytes;
            let (block_row, block_x) = (part.window.y % self.block[1], part.window.x % self.block[0]);
            // The lock guards bytes of which every part writes its own.
            let mut out = out.lock().unwrap_or_else(PoisonError::into_inner);
            for row in 0..part.window.height {
                let from = ((block_row + row) as usize * self.block[0] as usize + block_x as usize) * stride;
                let at = (part.window.y + row - window.y) as usize * window.width as usize;
                let at = (at + (part.window.x - window.x) as usize) * sample_bytes;
                let to = &mut out[at..at + part.window.width as usize * sample_bytes];
                let from = &decoded[from + first * sample_bytes..];
                if stride == sample_bytes {
                    to.copy_from_slice(&from[..to.len()]);
                } else {
                    for (to, from) in to.chunks_exact_mut(sample_bytes).zip(from.chunks(stride)) {
                        to.copy_from_slice(&from[..sample_bytes]);
                    }
                }
            }
            Ok::<(), TiffError>(())
        })?;
        Ok(out.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    fn decoded(&self, file: &TiffFile, cache: &BlockCache, block: usize) -> Result<Arc<Vec<u8>>, TiffError> {
        let kind = if self.is_tiled { BlockKind::Tile } else { BlockKind::Strip };
        let key = BlockKey { ifd_offset: self.key, kind, block_index: block };
        if let Some(decoded) = cache.get(&key) {
            return Ok(decoded);
        }
        // The last strip has fewer rows than the others; a tile always has all of them.
        let first_row = (block % self.per_band()) as u32 / self.size[0].div_ceil(self.block[0]) * self.block[1];
        let rows = if self.is_tiled { self.block[1] } else { self.block[1].min(self.size[1] - first_row) };
        let row_bytes = self.row_bytes();
        let needed = rows as usize * row_bytes;
        let place = self.places[block];
        if is_absent(place) {
            let samples = rows as usize * self.block[0] as usize * self.samples.interleaved();
            return Ok(cache.insert(key, vec![0; samples * self.samples.decoded.bytes()]));
        }
        let mut packed = self.unpacked(file, block, place, needed)?;
        if packed.len() < needed {
            let cause = format!("strip or tile {block} has {} bytes, but its samples need {needed}", packed.len());
            return Err(TiffError::Other(cause));
        }
        packed.truncate(needed);
        let samples = self.samples.unpack(packed, row_bytes, self.block[0] as usize, file.byte_order())?;
        Ok(cache.insert(key, samples))
    }

    /// Returns the decompressed bytes of a block: `needed` bytes, or more if the writer padded them.
    fn unpacked(
        &self,
        file: &TiffFile,
        block: usize,
        (offset, count): (u64, u64),
        needed: usize,
    ) -> Result<Vec<u8>, TiffError> {
        let whole = self.block[1] as usize * self.row_bytes();
        // Compression may enlarge samples a little. A much longer block is damaged.
        let most = if self.codec == CODEC_NONE { needed } else { whole.saturating_mul(4).saturating_add(1 << 16) };
        let available = file.source().len().saturating_sub(offset);
        if count > most as u64 && (self.codec != CODEC_NONE || count > available) {
            let cause = format!("strip or tile {block} has {count} bytes, more than its samples can need");
            return Err(TiffError::Other(cause));
        }
        let mut stored = file.source().read_exact_at(offset, count.min(most as u64) as usize)?;
        if self.is_reversed {
            stored.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
        }
        // Decoded bytes beyond the samples (padding of the last strip) are ignored, as in libtiff.
        let limit = whole.saturating_mul(2).saturating_add(1 << 16);
        match self.codec {
            CODEC_NONE => Ok(stored),
            CODEC_LZMA => lzma(&stored, limit)
                .map_err(|error| TiffError::DecompressionFailed { index: block, reason: format!("LZMA: {error}") }),
            codec => tiff_reader::filters::decompress(codec, &stored, block, None, limit),
        }
    }
}

/// Decodes an `.xz` stream to at most `limit` bytes.
fn lzma(stored: &[u8], limit: usize) -> std::io::Result<Vec<u8>> {
    use std::io::Read;
    let mut decoded = Vec::new();
    let reader = lzma_rust2::XzReader::new_mem_limit(stored, false, LZMA_MEMORY_KIB);
    reader.take(limit as u64 + 1).read_to_end(&mut decoded)?;
    if decoded.len() > limit {
        return Err(std::io::Error::other("it decodes to more bytes than its samples need"));
    }
    Ok(decoded)
}

fn is_absent((offset, count): (u64, u64)) -> bool {
    offset == 0 || count == 0
}

/// Returns the integers of a tag, in any type that some writer uses for them.
fn numbers(ifd: &Ifd, code: u16) -> Option<Vec<u64>> {
    match &ifd.tag(code)?.value {
        TagValue::SLong8(values) => values.iter().map(|&value| u64::try_from(value).ok()).collect(),
        TagValue::SLong(values) => values.iter().map(|&value| u64::try_from(value).ok()).collect(),
        value => value.as_u64_vec(),
    }
}
