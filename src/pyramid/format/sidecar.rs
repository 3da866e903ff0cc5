//! The sidecar file `NAME.tif.tiles` of a pyramid, for everything that a COG has no tags for: the georeference as
//! hachure reads it, and the statistics of every tile and patch.
//!
//! ```text
//! header
//!   8 bytes  "HACHTILE"
//!   u32      version
//!   u32      bytes of the header: the records begin there
//!   u64      FNV-1a of the rest of the header
//!     u64 u64   bytes of the .tif; FNV-1a of its first and last 64 KiB: its fingerprint
//!     u32 u32   width, height of level 0: all further sizes and counts follow from them
//!     f64       the error bound of the stored heights in metres; 0 = lossless
//!     f32 f32   lowest and highest height in metres
//!     u64       no-data samples of level 0
//!     6 × f64   crs_from_grid, which JSON would round
//!     u32 …     bytes of the georeference; the georeference as JSON
//!     levels    finest first:         u64 bytes of its tiles in the .tif, f32 largest error of a tile
//!     patches   of all strides above that of the coarsest level, by stride, row-major:
//!                                     f32 min, f32 max, f32 mesh error, u8 no-data
//! records     one per tile, by level (finest first), row-major, all of the same size: see `record`
//! ```
//! All numbers are little-endian. Opening a pyramid reads the header; a record is read together with its tile, from
//! [`Sidecar::record_range`]. Nothing here needs a file: header and records are parsed from bytes of any origin.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::bytes::{Cursor, fnv, put_f32s};
use super::fingerprint::Fingerprint;
use super::record::{RECORD_BYTES, Record, parse_record};
use crate::file::unnamed::head;
use crate::pyramid::surface::levels::{LevelSize, level_sizes};
use crate::pyramid::surface::statistics::{PatchStatistics, patch_counts, patch_levels, tile_index};
use crate::pyramid::tile::{PATCH_QUADS, TileAddress};
use crate::source::georeference::Georeference;

pub(crate) const MAGIC: &[u8; 8] = b"HACHTILE";

/// The format version, raised whenever the bytes, the meaning of the statistics or the levels change; older pyramids
/// are then baked again.
pub(crate) const VERSION: u32 = (2 << 8) | PATCH_QUADS;

/// Number of bytes at the start of a sidecar that contain the length of its header.
pub(crate) const HEAD_BYTES: usize = 8 + 4 + 4 + 8;

/// Upper bound of the samples along a side, to detect damaged files.
const MAX_SIDE: u32 = 1 << 24;

/// Upper bound of the length of a header, to detect damaged files.
const MAX_HEADER_BYTES: u32 = 1 << 24;

/// A summary of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelSummary {
    /// Total length of the level's tiles in the GeoTIFF, in bytes.
    pub bytes: u64,
    /// The largest error of the level's tiles against the heights that were baked, in metres.
    pub largest_error_m: f32,
}

/// The header of a sidecar.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sidecar {
    /// The fingerprint of the .tif that the sidecar belongs to.
    pub fingerprint: Fingerprint,
    /// The sizes of the levels, finest first.
    pub sizes: Vec<LevelSize>,
    /// The largest difference between stored and original heights, in metres; 0 for lossless.
    pub max_error_m: f64,
    /// Lowest height of level 0 in metres, as stored.
    pub min_m: f32,
    /// Highest height of level 0 in metres, as stored.
    pub max_m: f32,
    /// Number of no-data samples of level 0.
    pub void_samples: u64,
    /// The georeference of level 0.
    pub georeference: Georeference,
    /// A summary of each level, finest first.
    pub levels: Vec<LevelSummary>,
    /// The patches of the strides above the coarsest level's; see `TileStore::coarse_patches`.
    pub coarse_patches: Vec<Vec<PatchStatistics>>,
    /// Length of the header in bytes; the records follow it.
    pub header_bytes: u64,
}

/// The reason why bytes are not a valid header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeaderFault {
    /// Another version of hachure wrote the header.
    Stale(&'static str),
    /// The header is damaged.
    Corrupt(&'static str),
}

/// Returns `NAME.tif.tiles` for `NAME.tif`.
pub fn sidecar_path(tif: &Path) -> PathBuf {
    let mut path = tif.as_os_str().to_owned();
    path.push(".tiles");
    path.into()
}

/// Returns whether the file at `path` is a sidecar, whole or damaged, of any version.
pub(crate) fn is_sidecar(path: &Path) -> bool {
    head(path, MAGIC.len()) == MAGIC
}

impl Sidecar {
    pub(crate) fn finest(&self) -> LevelSize {
        self.sizes[0]
    }

    /// Returns the exponents of the strides of the coarse patches: those above the coarsest level's.
    fn coarse_strides(sizes: &[LevelSize]) -> Range<u32> {
        sizes.len() as u32..patch_levels(sizes[0]).max(sizes.len() as u32)
    }

    /// Returns the length of the header that begins with the bytes `first`, which are at least [`HEAD_BYTES`].
    pub(crate) fn header_bytes(first: &[u8]) -> Result<usize, HeaderFault> {
        let mut head = Cursor { bytes: first };
        if head.take(8) != Some(MAGIC) {
            return Err(HeaderFault::Corrupt("it does not start with HACHTILE"));
        }
        match (head.u32(), head.u32()) {
            (Some(VERSION), Some(bytes)) if (HEAD_BYTES as u32..=MAX_HEADER_BYTES).contains(&bytes) => {
                Ok(bytes as usize)
            }
            (Some(VERSION), _) => Err(HeaderFault::Corrupt("the length of its header is invalid")),
            _ => Err(HeaderFault::Stale("it was written by another version of hachure")),
        }
    }

    /// Parses the header at the start of `bytes`.
    pub(crate) fn parse_header(bytes: &[u8]) -> Result<Self, HeaderFault> {
        let header_bytes = Self::header_bytes(bytes)?;
        let header = bytes.get(..header_bytes).ok_or(HeaderFault::Corrupt("the file is truncated"))?;
        let mut rest = Cursor { bytes: &header[HEAD_BYTES - 8..] };
        if rest.u64() != Some(fnv(rest.bytes)) {
            return Err(HeaderFault::Corrupt("its checksum is wrong"));
        }
        parse(rest, header_bytes as u64).ok_or(HeaderFault::Corrupt("its contents contradict one another"))
    }

    /// Encodes the header. Its length, `header_bytes`, is computed and not read from `self`.
    pub(crate) fn header_to_bytes(&self) -> Result<Vec<u8>, serde_json::Error> {
        let mut body = Vec::new();
        self.fingerprint.put(&mut body);
        body.extend(self.finest().width.to_le_bytes());
        body.extend(self.finest().height.to_le_bytes());
        body.extend(self.max_error_m.to_le_bytes());
        put_f32s(&mut body, &[self.min_m, self.max_m]);
        body.extend(self.void_samples.to_le_bytes());
        for number in self.georeference.crs_from_grid {
            body.extend(number.to_le_bytes());
        }
        let georeference = serde_json::to_vec(&self.georeference)?;
        body.extend((georeference.len() as u32).to_le_bytes());
        body.extend(georeference);
        for level in &self.levels {
            body.extend(level.bytes.to_le_bytes());
            put_f32s(&mut body, &[level.largest_error_m]);
        }
        for patch in self.coarse_patches.iter().flatten() {
            put_f32s(&mut body, &[patch.min_m, patch.max_m, patch.mesh_error_m]);
            body.push(patch.voids.code());
        }
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(((HEAD_BYTES + body.len()) as u32).to_le_bytes());
        bytes.extend(fnv(&body).to_le_bytes());
        bytes.extend(body);
        Ok(bytes)
    }

    /// Returns the number of tiles of all levels.
    pub(crate) fn tiles(&self) -> u64 {
        self.sizes.iter().map(|size| size.tiles()).sum()
    }

    /// Returns the number of a tile, which is also the number of its record, or `None` if the pyramid has no such tile.
    pub(crate) fn tile_number(&self, address: TileAddress) -> Option<u64> {
        let index = tile_index(&self.sizes, address)? as u64;
        Some(self.sizes[..address.level as usize].iter().map(|size| size.tiles()).sum::<u64>() + index)
    }

    /// Returns the byte range of a tile's record in the file.
    pub(crate) fn record_range(&self, address: TileAddress) -> Option<Range<u64>> {
        let start = self.header_bytes + self.tile_number(address)? * RECORD_BYTES as u64;
        Some(start..start + RECORD_BYTES as u64)
    }

    /// Parses the record of a tile from the bytes of [`Sidecar::record_range`]. Returns `None` if they are damaged or
    /// belong to another tile.
    pub(crate) fn parse_record(&self, address: TileAddress, bytes: &[u8]) -> Option<Record> {
        parse_record(self.tile_number(address)?, bytes)
    }

    /// Returns the length of the whole file in bytes.
    pub(crate) fn file_bytes(&self) -> u64 {
        self.header_bytes + self.tiles() * RECORD_BYTES as u64
    }
}

fn parse(mut body: Cursor<'_>, header_bytes: u64) -> Option<Sidecar> {
    let fingerprint = Fingerprint::parse(&mut body)?;
    let finest = LevelSize { width: body.u32()?, height: body.u32()? };
    if !(2..=MAX_SIDE).contains(&finest.width) || !(2..=MAX_SIDE).contains(&finest.height) {
        return None;
    }
    let max_error_m = body.f64()?;
    let (min_m, max_m) = (body.f32()?, body.f32()?);
    let void_samples = body.u64()?;
    let mut crs_from_grid = [0.0; 6];
    for number in &mut crs_from_grid {
        *number = body.f64()?;
    }
    let georeference_bytes = body.u32()? as usize;
    let georeference: Georeference = serde_json::from_slice(body.take(georeference_bytes)?).ok()?;
    let georeference = Georeference { crs_from_grid, ..georeference };
    let sizes = level_sizes(finest.width, finest.height);
    let levels = sizes
        .iter()
        .map(|_| Some(LevelSummary { bytes: body.u64()?, largest_error_m: body.f32()? }))
        .collect::<Option<_>>()?;
    let mut coarse_patches = Vec::new();
    for j in Sidecar::coarse_strides(&sizes) {
        let (x, y) = patch_counts(finest, j);
        let patch = |_| {
            let (min_m, max_m, mesh_error_m) = (body.f32()?, body.f32()?, body.f32()?);
            Some(PatchStatistics { min_m, max_m, mesh_error_m, voids: body.voids()? })
        };
        coarse_patches.push((0..x * y).map(patch).collect::<Option<_>>()?);
    }
    body.bytes.is_empty().then_some(Sidecar {
        fingerprint,
        sizes,
        max_error_m,
        min_m,
        max_m,
        void_samples,
        georeference,
        levels,
        coarse_patches,
        header_bytes,
    })
}
