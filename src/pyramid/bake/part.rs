//! The result of a chunk: the encoded tiles with their statistics, and the small grids that the next round reads.
//!
//! A part is a sequence of bytes, in memory or in a file of the work folder; only its [`Contents`] always stay in
//! memory.
//!
//! ```text
//!  8 bytes  "HACHPART"
//!  u32      CRC-32 of all bytes that follow
//!  u64      the bake that it belongs to
//!  u32 …    round, chunk x, y
//!  u32      bytes of the contents
//!  contents f32 f32 u64 range of level 0, no-data samples;
//!           u32 … and by tile: u32 bytes, u32 CRC-32, f32 min, max, error, u8 no-data;
//!           u32 … and the deferred samples: u32 level, x, y, f32; u32 … and the patches above the coarsest level
//!  grids    f32: the top level as averaged, and as stored; the vertices;
//!           by patch of the top's pages min, max, error, no-data
//!  pages    of each tile: see `record`
//!  tiles
//! ```

use std::path::{Path, PathBuf};

use super::deferred::Deferred;
use super::plan::Chunk;
use crate::file::atomic::{self, Readers};
use crate::file::input::read_bytes;
use crate::file::random_access::RandomAccess;
use crate::file::unnamed::head;
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::bytes::{Cursor, put_f32s};
use crate::pyramid::format::record::{self, PAGE_BYTES};
use crate::pyramid::surface::statistics::{PatchStatistics, TileStatistics};

const MAGIC: &[u8; 8] = b"HACHPART";
const HEAD_BYTES: usize = 8 + 4 + 8 + 12 + 4;
/// The offset from which the checksum covers the bytes.
const SUMMED_AT: usize = 12;

/// The identity of a part: its bake, round and chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PartName {
    /// The identity of the bake: a hash of its heights, options and version.
    pub bake: u64,
    /// Number of the round, from 0.
    pub round: u32,
    /// The chunk of that round.
    pub chunk: Chunk,
}

/// A part's entry of one of its tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileEntry {
    /// Length of its encoded bytes.
    pub bytes: u32,
    /// CRC-32 of its encoded bytes.
    pub checksum: u32,
    /// Its statistics; the errors at its corners are not known yet.
    pub statistics: TileStatistics,
}

/// The contents of a part that stay in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Contents {
    /// In the first round, lowest and highest height of level 0 as stored, in metres; NaN if there is none.
    pub range_m: [f32; 2],
    /// In the first round, the number of no-data samples of level 0.
    pub void_samples: u64,
    /// The tiles by level, from the finest that the round makes, row-major.
    pub tiles: Vec<TileEntry>,
    /// The samples whose errors depend on coarser levels.
    pub deferred: Vec<Deferred>,
    /// In the last round, the patches of each stride above the coarsest level's.
    pub coarse_patches: Vec<Vec<PatchStatistics>>,
}

/// The grids of a part for the next round; all are empty in the last round.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Grids {
    /// The top level as averaged, in metres, NaN for no-data.
    pub raw_m: Vec<f32>,
    /// The top level as stored, in metres, NaN for no-data; empty where that is the same.
    pub stored_m: Vec<f32>,
    /// Heights of the vertices of the next round in metres, NaN where there is nothing to draw.
    pub vertices_m: Vec<f32>,
    /// The patches in the pages of the top level's tiles.
    pub patches: Vec<PatchStatistics>,
}

/// A part: its contents, and the location of its bytes.
pub(super) struct Part {
    pub contents: Contents,
    bytes: Bytes,
    grids_at: u64,
    pages_at: u64,
    /// The offset of each tile's bytes from the start of the part.
    tiles_at: Vec<u64>,
}

enum Bytes {
    Memory(Vec<u8>),
    File(PathBuf),
}

fn put_patch(bytes: &mut Vec<u8>, patch: &PatchStatistics) {
    put_f32s(bytes, &[patch.min_m, patch.max_m, patch.mesh_error_m]);
    bytes.push(patch.voids.code());
}

fn take_patch(bytes: &mut Cursor<'_>) -> Option<PatchStatistics> {
    let (min_m, max_m, mesh_error_m) = (bytes.f32()?, bytes.f32()?, bytes.f32()?);
    Some(PatchStatistics { min_m, max_m, mesh_error_m, voids: bytes.voids()? })
}

/// Encodes a part for memory or a file.
pub(super) fn to_bytes(
    name: PartName,
    contents: &Contents,
    grids: &Grids,
    pages: &[Vec<u8>],
    tiles: &[Vec<u8>],
) -> Vec<u8> {
    let mut about = Vec::new();
    put_f32s(&mut about, &contents.range_m);
    about.extend(contents.void_samples.to_le_bytes());
    let count = |bytes: &mut Vec<u8>, count: usize| bytes.extend((count as u32).to_le_bytes());
    count(&mut about, contents.tiles.len());
    for TileEntry { bytes, checksum, statistics } in &contents.tiles {
        about.extend(bytes.to_le_bytes());
        about.extend(checksum.to_le_bytes());
        put_f32s(&mut about, &[statistics.min_m, statistics.max_m, statistics.error_m]);
        about.push(statistics.voids.code());
    }
    count(&mut about, contents.deferred.len());
    for Deferred { level, x, y, height_m } in &contents.deferred {
        about.extend([*level, *x, *y].iter().flat_map(|number| number.to_le_bytes()));
        put_f32s(&mut about, &[*height_m]);
    }
    count(&mut about, contents.coarse_patches.len());
    for patches in &contents.coarse_patches {
        count(&mut about, patches.len());
        patches.iter().for_each(|patch| put_patch(&mut about, patch));
    }

    let mut bytes = MAGIC.to_vec();
    bytes.extend([0; 4]);
    bytes.extend(name.bake.to_le_bytes());
    bytes.extend([name.round, name.chunk.x, name.chunk.y].iter().flat_map(|number| number.to_le_bytes()));
    count(&mut bytes, about.len());
    bytes.extend(about);
    for grid in [&grids.raw_m, &grids.stored_m, &grids.vertices_m] {
        count(&mut bytes, grid.len());
        put_f32s(&mut bytes, grid);
    }
    count(&mut bytes, grids.patches.len());
    grids.patches.iter().for_each(|patch| put_patch(&mut bytes, patch));
    pages.iter().chain(tiles).for_each(|block| bytes.extend(block));
    let sum = crc32fast::hash(&bytes[SUMMED_AT..]);
    bytes[8..SUMMED_AT].copy_from_slice(&sum.to_le_bytes());
    bytes
}

impl Part {
    /// Opens a part that stays in memory. Returns `None` if the bytes are damaged.
    pub(super) fn in_memory(bytes: Vec<u8>) -> Option<Self> {
        let mut part = Self::parse(&bytes)?;
        part.bytes = Bytes::Memory(bytes);
        Some(part)
    }

    /// Writes a part to a file, atomically.
    pub(super) fn write(bytes: &[u8], path: &Path, readers: Readers) -> Result<Self, PyramidError> {
        atomic::write_for(path, bytes, readers).map_err(PyramidError::io(path, "writing"))?;
        Self::parse(bytes).ok_or_else(|| damaged(path)).map(|part| Self { bytes: Bytes::File(path.to_owned()), ..part })
    }

    /// Returns whether the file at `path` is a part, whole or damaged.
    pub(super) fn is_part(path: &Path) -> bool {
        head(path, MAGIC.len()) == MAGIC
    }

    /// Opens an existing part and verifies every byte. Returns `None` if the file is missing or damaged, or if it is
    /// another part than `name`.
    pub(super) fn open(path: &Path, name: PartName) -> Option<Self> {
        let bytes = read_bytes(path, u64::MAX).ok()?;
        let mut head = Cursor { bytes: &bytes };
        if head.take(8)? != MAGIC || head.u32()? != crc32fast::hash(bytes.get(SUMMED_AT..)?) {
            return None;
        }
        let (bake, round, x, y) = (head.u64()?, head.u32()?, head.u32()?, head.u32()?);
        if (PartName { bake, round, chunk: Chunk { x, y } }) != name {
            return None;
        }
        Some(Self { bytes: Bytes::File(path.to_owned()), ..Self::parse(&bytes)? })
    }

    fn parse(bytes: &[u8]) -> Option<Self> {
        let mut cursor = Cursor { bytes };
        cursor.take(HEAD_BYTES - 4)?;
        let about_bytes = cursor.u32()? as usize;
        let mut about = Cursor { bytes: cursor.take(about_bytes)? };
        let mut contents = Contents { range_m: [about.f32()?, about.f32()?], ..Contents::default() };
        contents.void_samples = about.u64()?;
        for _ in 0..about.u32()? {
            let (bytes, checksum) = (about.u32()?, about.u32()?);
            let (min_m, max_m, error_m) = (about.f32()?, about.f32()?, about.f32()?);
            let voids = about.voids()?;
            let statistics = TileStatistics { min_m, max_m, error_m, corner_errors_m: [error_m; 4], voids };
            contents.tiles.push(TileEntry { bytes, checksum, statistics });
        }
        for _ in 0..about.u32()? {
            let (level, x, y) = (about.u32()?, about.u32()?, about.u32()?);
            contents.deferred.push(Deferred { level, x, y, height_m: about.f32()? });
        }
        for _ in 0..about.u32()? {
            let patches = (0..about.u32()?).map(|_| take_patch(&mut about)).collect::<Option<_>>()?;
            contents.coarse_patches.push(patches);
        }
        let grids_at = (bytes.len() - cursor.bytes.len()) as u64;
        take_grids(&mut cursor)?;
        let pages_at = (bytes.len() - cursor.bytes.len()) as u64;
        let mut at = pages_at + (contents.tiles.len() * PAGE_BYTES) as u64;
        let mut tiles_at = Vec::with_capacity(contents.tiles.len());
        for tile in &contents.tiles {
            tiles_at.push(at);
            at += u64::from(tile.bytes);
        }
        (at == bytes.len() as u64).then_some(Self {
            contents,
            bytes: Bytes::Memory(Vec::new()),
            grids_at,
            pages_at,
            tiles_at,
        })
    }

    fn read(&self, offset: u64, count: u64) -> Result<Vec<u8>, PyramidError> {
        match &self.bytes {
            Bytes::Memory(bytes) => Ok(bytes[offset as usize..(offset + count) as usize].to_vec()),
            Bytes::File(path) => {
                let file = RandomAccess::open(path).map_err(PyramidError::io(path, "reading"))?;
                file.read(offset, count as usize).map_err(PyramidError::io(path, "reading"))
            }
        }
    }

    /// Returns the file name, for messages.
    fn path(&self) -> &Path {
        match &self.bytes {
            Bytes::Memory(_) => Path::new("(memory)"),
            Bytes::File(path) => path,
        }
    }

    /// Reads the grids, which the next round needs.
    pub(super) fn grids(&self) -> Result<Grids, PyramidError> {
        let bytes = self.read(self.grids_at, self.pages_at - self.grids_at)?;
        take_grids(&mut Cursor { bytes: &bytes }).ok_or_else(|| damaged(self.path()))
    }

    /// Reads the pages of the tiles `first` … `first + count − 1`.
    pub(super) fn pages(&self, first: usize, count: usize) -> Result<Vec<u8>, PyramidError> {
        self.read(self.pages_at + (first * PAGE_BYTES) as u64, (count * PAGE_BYTES) as u64)
    }

    /// Reads and verifies the encoded bytes of the tiles `first` … `first + count − 1`.
    pub(super) fn tiles(&self, first: usize, count: usize) -> Result<Vec<Vec<u8>>, PyramidError> {
        let entries = &self.contents.tiles[first..first + count];
        let total: u64 = entries.iter().map(|entry| u64::from(entry.bytes)).sum();
        let bytes = self.read(self.tiles_at[first], total)?;
        let mut rest = &bytes[..];
        let mut tiles = Vec::with_capacity(count);
        for entry in entries {
            let (tile, after) = rest.split_at(entry.bytes as usize);
            if record::checksum(tile) != entry.checksum {
                return Err(damaged(self.path()));
            }
            tiles.push(tile.to_vec());
            rest = after;
        }
        Ok(tiles)
    }
}

fn damaged(path: &Path) -> PyramidError {
    let cause = "this part of a bake is damaged; bake again with --resume".into();
    PyramidError::Mismatch { path: path.to_owned(), cause }
}

fn take_grids(bytes: &mut Cursor<'_>) -> Option<Grids> {
    let mut grid = || {
        let count = bytes.u32()? as usize;
        bytes.f32s(count)
    };
    let (raw_m, stored_m, vertices_m) = (grid()?, grid()?, grid()?);
    let patches = (0..bytes.u32()?).map(|_| take_patch(bytes)).collect::<Option<_>>()?;
    Some(Grids { raw_m, stored_m, vertices_m, patches })
}
