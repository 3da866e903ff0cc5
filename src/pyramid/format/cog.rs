//! The cloud-optimised GeoTIFF: a file whose directories precede its data, so that a reader over HTTP knows the layout
//! of the whole file after one request.
//!
//! ```text
//! header │ GDAL's structural note │ directory of level 0 … coarsest │ tiles of the coarsest level … level 0
//! ```
//!
//! `geotiff-writer` makes COGs too, but only with its own overviews (blocks of 2^l samples, whose registration differs
//! from GDAL's for odd sizes). So the directories are written here, from the tags of `tiff-writer`, with our own
//! levels. The sizes of the directories depend only on the number of tiles: space is reserved for them, the tiles are
//! written as they are compressed, and the directories are filled in when all offsets are known.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use geotiff_writer::PhotometricInterpretation;
use tiff_reader::{ByteOrder, Tag, TagValue};
use tiff_writer::{ImageBuilder, encoder};

use super::encode::Codec;
use super::geotags;
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::tile::TILE_SAMPLES;
use crate::source::georeference::Georeference;

const TILE_OFFSETS: u16 = 324;
const TILE_BYTE_COUNTS: u16 = 325;
const ENDIAN: ByteOrder = ByteOrder::LittleEndian;

/// The position and length of a tile's bytes in the file.
#[derive(Clone, Copy)]
struct Block {
    offset: u64,
    bytes: u64,
}

/// Returns GDAL's note about the layout of the file; with it, GDAL needs one request less for each tile.
fn structural_note() -> Vec<u8> {
    let note = concat!(
        "LAYOUT=IFDS_BEFORE_DATA\n",
        "BLOCK_ORDER=ROW_MAJOR\n",
        "BLOCK_LEADER=SIZE_AS_UINT4\n",
        "BLOCK_TRAILER=LAST_4_BYTES_REPEATED\n",
        "KNOWN_INCOMPATIBLE_EDITION=NO\n ",
    );
    format!("GDAL_STRUCTURAL_METADATA_SIZE={:06} bytes\n{note}", note.len()).into_bytes()
}

/// An unfinished COG: space for the directories is reserved, tiles are appended, and the directories are written last.
pub(crate) struct CogWriter<'a, W: Write + Seek> {
    sink: &'a mut W,
    path: &'a Path,
    images: Vec<ImageBuilder>,
    blocks: Vec<Vec<Block>>,
    is_bigtiff: bool,
    first_directory: u64,
    offset: u64,
}

impl<'a, W: Write + Seek> CogWriter<'a, W> {
    /// Begins a COG with levels of these sizes (finest first) in `sink`, whose position is its start. `path` is for
    /// messages.
    pub(crate) fn begin(
        sink: &'a mut W,
        path: &'a Path,
        sizes: &[LevelSize],
        georeference: &Georeference,
        codec: Codec,
    ) -> Result<Self, PyramidError> {
        let samples: u64 = sizes.iter().map(|size| u64::from(size.width) * u64::from(size.height)).sum();
        // Even incompressible tiles stay below this limit.
        let is_bigtiff = samples * 5 > u64::from(u32::MAX) - (1 << 28);
        Self::begin_as(sink, path, sizes, georeference, codec, is_bigtiff)
    }

    fn begin_as(
        sink: &'a mut W,
        path: &'a Path,
        sizes: &[LevelSize],
        georeference: &Georeference,
        codec: Codec,
        is_bigtiff: bool,
    ) -> Result<Self, PyramidError> {
        let images: Vec<ImageBuilder> = sizes
            .iter()
            .enumerate()
            .map(|(level, &size)| image(level, size, georeference, codec))
            .collect::<Result<_, _>>()
            .map_err(PyramidError::encode(path))?;
        let note = structural_note();
        let mut offset = encoder::header_len(is_bigtiff) + note.len() as u64;
        offset += offset % 2;
        let first_directory = offset;
        let empty = |size: &LevelSize| vec![Block { offset: 0, bytes: 0 }; size.tiles() as usize];
        let blocks: Vec<Vec<Block>> = sizes.iter().map(empty).collect();
        for (image, blocks) in images.iter().zip(&blocks) {
            let tags = tags(image, blocks, is_bigtiff).map_err(PyramidError::encode(path))?;
            let bytes = encoder::estimate_ifd_size(ENDIAN, is_bigtiff, &tags).map_err(PyramidError::encode(path))?;
            offset += bytes + bytes % 2;
        }
        let disk = || PyramidError::io(path, "writing the GeoTIFF");
        sink.seek(SeekFrom::Start(0)).map_err(disk())?;
        encoder::write_header(sink, ENDIAN, is_bigtiff).map_err(PyramidError::encode(path))?;
        sink.write_all(&note).map_err(disk())?;
        sink.seek(SeekFrom::Start(offset)).map_err(disk())?;
        Ok(Self { sink, path, images, blocks, is_bigtiff, first_directory, offset })
    }

    /// Appends the bytes of a tile: the coarsest level first, each level row by row, as the structural note promises.
    pub(crate) fn put(&mut self, level: usize, tile: usize, bytes: &[u8]) -> Result<(), PyramidError> {
        let block = write_block(self.sink, &mut self.offset, bytes);
        self.blocks[level][tile] = block.map_err(PyramidError::io(self.path, "writing the GeoTIFF"))?;
        Ok(())
    }

    /// Writes the directories into the reserved space, after all tiles have been written.
    pub(crate) fn finish(self) -> Result<(), PyramidError> {
        let Self { sink, path, images, blocks, is_bigtiff, first_directory, .. } = self;
        write_directories(sink, first_directory, &images, &blocks, is_bigtiff).map_err(PyramidError::encode(path))?;
        sink.flush().map_err(PyramidError::io(path, "writing the GeoTIFF"))
    }
}

/// Writes a tile between its size and the repetition of its last four bytes, as the structural note promises.
fn write_block<W: Write>(sink: &mut W, offset: &mut u64, bytes: &[u8]) -> std::io::Result<Block> {
    let size = u32::try_from(bytes.len()).map_err(std::io::Error::other)?;
    sink.write_all(&size.to_le_bytes())?;
    sink.write_all(bytes)?;
    sink.write_all(&bytes[bytes.len().saturating_sub(4)..])?;
    let block = Block { offset: *offset + 4, bytes: u64::from(size) };
    *offset += 8 + u64::from(size);
    Ok(block)
}

fn write_directories<W: Write + Seek>(
    sink: &mut W,
    first_directory: u64,
    images: &[ImageBuilder],
    blocks: &[Vec<Block>],
    is_bigtiff: bool,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    encoder::patch_first_ifd(sink, 0, ENDIAN, is_bigtiff, first_directory)?;
    let mut offset = first_directory;
    let mut link = None;
    for (image, blocks) in images.iter().zip(blocks) {
        if let Some(link) = link {
            encoder::patch_next_ifd(sink, ENDIAN, is_bigtiff, link, offset)?;
        }
        sink.seek(SeekFrom::Start(offset))?;
        let tags = tags(image, blocks, is_bigtiff)?;
        let written =
            encoder::write_ifd(sink, ENDIAN, is_bigtiff, &tags, TILE_OFFSETS, TILE_BYTE_COUNTS, blocks.len())?;
        link = Some(written.next_ifd_pointer_offset);
        let bytes = encoder::estimate_ifd_size(ENDIAN, is_bigtiff, &tags)?;
        offset += bytes + bytes % 2;
    }
    Ok(())
}

fn image(
    level: usize,
    size: LevelSize,
    georeference: &Georeference,
    codec: Codec,
) -> Result<ImageBuilder, Box<dyn std::error::Error + Send + Sync>> {
    let mut image = ImageBuilder::new(size.width, size.height)
        .sample_type::<f32>()
        .photometric(PhotometricInterpretation::MinIsBlack)
        .tiles(TILE_SAMPLES, TILE_SAMPLES);
    image = codec.describe(image);
    if level > 0 {
        image = image.overview();
    }
    for tag in geotags::tags_of_level(level, georeference)? {
        image = image.tag(tag);
    }
    Ok(image)
}

/// Returns the tags of an image, with the offsets and lengths of its tiles.
fn tags(image: &ImageBuilder, blocks: &[Block], is_bigtiff: bool) -> tiff_writer::Result<Vec<Tag>> {
    let values = |values: Vec<u64>| -> tiff_writer::Result<TagValue> {
        if is_bigtiff {
            return Ok(TagValue::Long8(values));
        }
        let narrow = |offset| u32::try_from(offset).map_err(|_| tiff_writer::Error::ClassicOffsetOverflow { offset });
        Ok(TagValue::Long(values.into_iter().map(narrow).collect::<Result<_, _>>()?))
    };
    let mut tags = image.checked_build_tags(is_bigtiff)?;
    for tag in &mut tags {
        if tag.code == TILE_OFFSETS {
            *tag = Tag::new(TILE_OFFSETS, values(blocks.iter().map(|block| block.offset).collect())?);
        } else if tag.code == TILE_BYTE_COUNTS {
            *tag = Tag::new(TILE_BYTE_COUNTS, values(blocks.iter().map(|block| block.bytes).collect())?);
        }
    }
    Ok(tags)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::format::encode::padded_tile;
    use crate::pyramid::surface::levels::level_sizes;
    use crate::source::georeference::Crs;

    #[test]
    fn both_containers_read_back() {
        let sizes = level_sizes(600, 300);
        let level = |size: &LevelSize| (0..size.samples()).map(|i| i as f32 * 0.5).collect();
        let levels_m: Vec<Vec<f32>> = sizes.iter().map(level).collect();
        let georeference = Georeference {
            crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0],
            crs: Crs::Local,
            geokeys: Default::default(),
        };
        for is_bigtiff in [false, true] {
            let mut sink = std::io::Cursor::new(Vec::new());
            let path = Path::new("memory");
            let codec = Codec::Lossless;
            let mut writer = CogWriter::begin_as(&mut sink, path, &sizes, &georeference, codec, is_bigtiff).unwrap();
            for (level, size) in sizes.iter().enumerate().rev() {
                let (field, all) = (&levels_m[level], size.region());
                for tile in 0..size.tiles_x() * size.tiles_y() {
                    let region = size.tile_region(tile % size.tiles_x(), tile / size.tiles_x(), 0);
                    let heights_m = padded_tile(field, all, region);
                    writer.put(level, tile as usize, &codec.encode(&heights_m, tile as usize).unwrap()).unwrap();
                }
            }
            writer.finish().unwrap();
            let file = tiff_reader::TiffFile::from_bytes(sink.into_inner()).unwrap();
            assert_eq!((file.is_bigtiff(), file.ifd_count()), (is_bigtiff, sizes.len()));
            for (level, heights_m) in levels_m.iter().enumerate() {
                assert!(file.read_image::<f32>(level).unwrap().iter().eq(heights_m));
            }
        }
    }
}
