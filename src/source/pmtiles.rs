//! Reads a PMTiles archive of terrain-RGB tiles ("PMTiles Version 3 Specification"): PNG or lossless WebP. Only the
//! deepest zoom level is read.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use futures_util::StreamExt;
use pmtiles::{
    AsyncBackend, AsyncPmTilesReader, BackendResponse, Compression, PmtError, PmtResult, TileCoord, TileType,
};

use serde::de::IgnoredAny;

use super::picture::{self, Picture};
use super::place::{cannot_open, foreign_message, inconsistent, unclear};
use super::sidecar::{OpenOptions, RasterInfo};
use super::tile_json::TileJson;
use super::tile_set::{TileLevel, TileSetReader, TileStoreReader};
use super::{SourceError, TileRows};

/// Largest number of tiles of the deepest level.
const MAX_TILES: usize = 1 << 24;
/// Largest number of tiles of all levels that are listed.
const MAX_LISTED: u64 = 1 << 26;
/// Largest number of bytes that are read at once: a tile or a directory.
const MAX_READ_BYTES: usize = 64 << 20;

/// The file, of which any part can be read.
struct Archive(Mutex<File>);

impl AsyncBackend for Archive {
    async fn read(&self, offset: u64, length: usize) -> PmtResult<BackendResponse> {
        if length > MAX_READ_BYTES {
            return Err(PmtError::InvalidEntry);
        }
        let mut bytes = Vec::new();
        // The position is set again here, so that a position left by a thread that panicked does not matter.
        let mut file = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset))?;
        file.by_ref().take(length as u64).read_to_end(&mut bytes)?;
        Ok(BackendResponse::new(Bytes::from(bytes)))
    }
}

type Reader = AsyncPmTilesReader<Archive>;

struct ArchiveTiles {
    path: PathBuf,
    reader: Arc<Reader>,
    zoom: u8,
}

impl TileStoreReader for ArchiveTiles {
    fn picture(&self, tile: [u32; 2]) -> Result<Picture, SourceError> {
        let [x, y] = tile;
        let read = TileCoord::new(self.zoom, x, y).and_then(|tile| pollster::block_on(self.reader.get_tile(tile)));
        let bytes = read.map_err(|error| damaged(&self.path, &error))?;
        let bytes = bytes.ok_or_else(|| inconsistent(&self.path, format!("its tile {x}/{y} is missing")))?;
        picture::decode_bytes(&self.name(tile), &bytes)
    }

    fn name(&self, [x, y]: [u32; 2]) -> PathBuf {
        self.path.join(format!("{}/{x}/{y}", self.zoom))
    }
}

/// Opens the deepest level of an archive as one grid of heights in metres, in Web Mercator.
///
/// # Errors
/// Fails if the archive is damaged, holds other than lossless pictures, compresses whole tiles or lists too many of
/// them; and as [`TileSetReader::open`] does.
pub(super) fn open(path: &Path, options: &OpenOptions) -> Result<TileSetReader, SourceError> {
    let file = File::open(path).map_err(cannot_open(path))?;
    let failed = |error: PmtError| damaged(path, &error);
    let reader = pollster::block_on(AsyncPmTilesReader::try_from_source(Archive(Mutex::new(file)))).map_err(failed)?;
    let header = reader.get_header();
    match header.tile_type {
        TileType::Png | TileType::Webp | TileType::Unknown => {}
        TileType::Mvt | TileType::Mlt => return Err(unclear(path, "holds vector tiles, not heights")),
        TileType::Jpeg | TileType::Avif => {
            return Err(unclear(path, "holds lossy pictures, not heights; terrain-RGB needs PNG or lossless WebP"));
        }
    }
    if !matches!(header.tile_compression, Compression::None | Compression::Unknown) {
        return Err(SourceError::Unsupported { path: path.into(), what: "compression of whole tiles".to_owned() });
    }
    let zoom = header.max_zoom;
    let mut info = RasterInfo::of(path, options)?;
    if let Some(described) = described(path, pollster::block_on(reader.get_metadata()))? {
        info.declare(&described);
    }
    let reader = Arc::new(reader);
    let tiles = pollster::block_on(tiles_of(path, &reader, zoom))?;
    let identity = format!("{} tiles", tiles.len());
    let store = Box::new(ArchiveTiles { path: path.into(), reader, zoom });
    // Section 4.1 of the specification: tiles are numbered from the north.
    let rows = Some(TileRows::Xyz);
    TileSetReader::open(path, &info, TileLevel { zoom: zoom.into(), tiles, store, rows, identity })
}

/// Returns the declarations of the metadata. It is optional and gives only the encoding, so that damage is a warning.
fn described(path: &Path, metadata: PmtResult<String>) -> Result<Option<TileJson>, SourceError> {
    let cause = match metadata {
        // The archive has none.
        Err(PmtError::InvalidMetadata) => return Ok(None),
        Err(error) => foreign_message(&error),
        Ok(text) => match serde_json::from_str::<IgnoredAny>(&text) {
            Err(error) => foreign_message(&error),
            Ok(_) => return TileJson::parse(&text).map_err(|why| unclear(path, why)),
        },
    };
    let name = path.display();
    tracing::warn!("{name}: its metadata cannot be read, so an encoding that it declares is not used: {cause}");
    Ok(None)
}

/// Lists the tiles of a level.
async fn tiles_of(path: &Path, reader: &Arc<Reader>, zoom: u8) -> Result<Vec<[u32; 2]>, SourceError> {
    let mut entries = Arc::clone(reader).entries();
    let (mut tiles, mut listed) = (Vec::new(), 0);
    // The header counts the tiles, so that a damaged directory does not list millions of them.
    let counted = reader.get_header().n_addressed_tiles().map_or(MAX_LISTED, u64::from);
    while let Some(entry) = entries.next().await {
        let entry = entry.map_err(|error| damaged(path, &error))?;
        for tile in entry.iter_coords() {
            listed += 1;
            if listed > counted {
                return Err(inconsistent(path, format!("it lists more tiles than the {counted} of its header")));
            }
            let tile = TileCoord::from(tile);
            if tile.z() == zoom {
                tiles.push([tile.x(), tile.y()]);
            }
            let too_many = match tiles.len() > MAX_TILES {
                true => Some(format!("more than {MAX_TILES} tiles at zoom level {zoom}")),
                false => (listed > MAX_LISTED).then(|| format!("more than {MAX_LISTED} tiles in all levels")),
            };
            if let Some(too_many) = too_many {
                return Err(unclear(path, format!("has {too_many}; cut a part out of it (pmtiles extract --bbox)")));
            }
        }
    }
    Ok(tiles)
}

fn damaged(path: &Path, error: &PmtError) -> SourceError {
    inconsistent(path, foreign_message(error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::common::log::with_warnings;

    #[test]
    fn metadata_that_cannot_be_read_is_reported() {
        let read = |metadata| with_warnings(|| described(Path::new("a.pmtiles"), metadata).unwrap());
        let gsi = "{\"encoding\": \"gsi\"";
        for broken in [Err(PmtError::InvalidHeader), Ok(gsi.to_owned())] {
            let (found, warnings) = read(broken);
            assert!(found.is_none() && warnings.contains("a.pmtiles: its metadata cannot be read"), "{warnings}");
        }
        let (found, warnings) = read(Ok(format!("{gsi}}}")));
        assert!(found.is_some_and(|found| found.encoding.is_some()) && warnings.is_empty(), "{warnings}");
        assert_eq!(read(Err(PmtError::InvalidMetadata)), (None, String::new()));
    }
}
