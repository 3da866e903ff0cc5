//! What a COG has no room for, in a small file beside it (`NAME.tif.tiles`): the georeference as hachure reads it and
//! the statistics of every tile and patch.
//!
//! ```text
//! 8 bytes  "HACHTILE"
//! u32      version
//! u64      FNV-1a of what follows
//!   u64 u64   bytes of the .tif; FNV-1a of its first and last 64 KiB: the link that shows a stale sidecar
//!   u32 u32   width, height of level 0: they give all further sizes and counts
//!   f64       the error bound of the stored heights in metres; 0 = lossless
//!   f32 f32   lowest and highest height in metres
//!   6 × f64   crs_from_grid, which JSON would round
//!   u32 …     bytes of the georeference; the georeference as JSON
//!   tiles     by level, row-major:  f32 min, f32 max, f32 error, u8 voids
//!   patches   by stride, row-major: f32 min, f32 max, f32 mesh error, u8 voids
//! ```
//! All numbers are little-endian.

use std::fs;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::PyramidError;
use super::levels::{LevelSize, level_sizes};
use super::statistics::{PatchStatistics, Statistics, TileStatistics, Voids, patch_counts, patch_levels};
use crate::source::georeference::Georeference;

const MAGIC: &[u8; 8] = b"HACHTILE";

/// Raised whenever the bytes, the statistics' meaning or the levels change: older bakes are then made again.
pub const VERSION: u32 = (1 << 8) | super::PATCH_QUADS;

const HEAD_BYTES: usize = 8 + 4 + 8;

/// The bytes at each end of the .tif that the link covers: all directories of a COG of ordinary size.
const LINK_BYTES: u64 = 64 * 1024;

/// No pyramid has more samples on a side: a guard for damaged files.
const MAX_SIDE: u32 = 1 << 24;

/// Ties a sidecar to the bytes of its .tif.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    tif_bytes: u64,
    tif_hash: u64,
}

impl Link {
    /// The link to the file at `path` as it is now.
    pub fn to(path: &Path) -> io::Result<Self> {
        let mut file = fs::File::open(path)?;
        let tif_bytes = file.metadata()?.len();
        let mut ends = Vec::new();
        (&mut file).take(LINK_BYTES).read_to_end(&mut ends)?;
        file.seek(SeekFrom::Start(tif_bytes.saturating_sub(LINK_BYTES)))?;
        file.take(LINK_BYTES).read_to_end(&mut ends)?;
        Ok(Self { tif_bytes, tif_hash: fnv(&ends) })
    }
}

/// The contents of a sidecar.
#[derive(Clone, Debug, PartialEq)]
pub struct Sidecar {
    /// The .tif that it belongs to.
    pub link: Link,
    /// Level 0.
    pub finest: LevelSize,
    /// How far stored heights are from the original ones at most, in metres; 0 for lossless.
    pub max_error_m: f64,
    /// Lowest height of level 0 as stored.
    pub min_m: f32,
    /// Highest.
    pub max_m: f32,
    /// Where level 0 lies.
    pub georeference: Georeference,
    /// Of every tile and patch.
    pub statistics: Statistics,
}

/// `NAME.tif.tiles` for `NAME.tif`.
pub fn sidecar_path(tif: &Path) -> PathBuf {
    let mut path = tif.as_os_str().to_owned();
    path.push(".tiles");
    path.into()
}

/// FNV-1a, 64 bits: it finds accidents, not malice.
pub fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

impl Sidecar {
    /// The bytes of the file.
    pub fn to_bytes(&self) -> Result<Vec<u8>, serde_json::Error> {
        let mut body = Vec::new();
        body.extend(self.link.tif_bytes.to_le_bytes());
        body.extend(self.link.tif_hash.to_le_bytes());
        body.extend(self.finest.width.to_le_bytes());
        body.extend(self.finest.height.to_le_bytes());
        body.extend(self.max_error_m.to_le_bytes());
        body.extend(self.min_m.to_le_bytes());
        body.extend(self.max_m.to_le_bytes());
        for number in self.georeference.crs_from_grid {
            body.extend(number.to_le_bytes());
        }
        let georeference = serde_json::to_vec(&self.georeference)?;
        body.extend((georeference.len() as u32).to_le_bytes());
        body.extend(georeference);
        for tile in self.statistics.tiles.iter().flatten() {
            put_node(&mut body, tile.min_m, tile.max_m, tile.error_m, tile.voids);
        }
        for patch in self.statistics.patches.iter().flatten() {
            put_node(&mut body, patch.min_m, patch.max_m, patch.mesh_error_m, patch.voids);
        }
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(fnv(&body).to_le_bytes());
        bytes.extend(body);
        Ok(bytes)
    }

    /// Reads the sidecar of the GeoTIFF at `tif` and checks that it belongs to that file as it is now.
    pub fn read(tif: &Path) -> Result<Self, PyramidError> {
        let path = sidecar_path(tif);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(PyramidError::NoSidecar { path: tif.to_owned() });
            }
            Err(source) => return Err(PyramidError::Io { path, what: "reading the tile statistics", source }),
        };
        let stale = |cause: &str| PyramidError::StaleSidecar { path: path.clone(), cause: cause.into() };
        let corrupt = |cause: &str| PyramidError::CorruptSidecar { path: path.clone(), cause: cause.into() };
        if bytes.len() < HEAD_BYTES || &bytes[..8] != MAGIC {
            return Err(corrupt("it does not begin like one"));
        }
        let mut head = Cursor { bytes: &bytes[8..] };
        let (version, hash) = (head.u32(), head.u64());
        if version != Some(VERSION) {
            return Err(stale("another version of hachure wrote it"));
        }
        if hash != Some(fnv(head.bytes)) {
            return Err(corrupt("its checksum is wrong"));
        }
        let sidecar = parse(head).ok_or_else(|| corrupt("its contents contradict one another"))?;
        let link = Link::to(tif).map_err(PyramidError::io(tif, "opening"))?;
        if link != sidecar.link {
            return Err(stale("the GeoTIFF has changed since"));
        }
        Ok(sidecar)
    }
}

fn parse(mut body: Cursor<'_>) -> Option<Sidecar> {
    let link = Link { tif_bytes: body.u64()?, tif_hash: body.u64()? };
    let finest = LevelSize { width: body.u32()?, height: body.u32()? };
    if !(2..=MAX_SIDE).contains(&finest.width) || !(2..=MAX_SIDE).contains(&finest.height) {
        return None;
    }
    let max_error_m = body.f64()?;
    let (min_m, max_m) = (body.f32()?, body.f32()?);
    let mut crs_from_grid = [0.0; 6];
    for number in &mut crs_from_grid {
        *number = body.f64()?;
    }
    let georeference_bytes = body.u32()? as usize;
    let georeference: Georeference = serde_json::from_slice(body.take(georeference_bytes)?).ok()?;
    let georeference = Georeference { crs_from_grid, ..georeference };
    let mut tiles = Vec::new();
    for size in level_sizes(finest.width, finest.height) {
        let nodes = body.nodes(size.tiles_x(), size.tiles_y())?;
        let tile = |(min_m, max_m, error_m, voids)| TileStatistics {
            min_m,
            max_m,
            error_m,
            corner_errors_m: [error_m; 4],
            voids,
        };
        tiles.push(nodes.into_iter().map(tile).collect());
    }
    let mut patches = Vec::new();
    for j in 0..patch_levels(finest) {
        let (x, y) = patch_counts(finest, j);
        let nodes = body.nodes(x, y)?;
        let patch = |(min_m, max_m, mesh_error_m, voids)| PatchStatistics { min_m, max_m, mesh_error_m, voids };
        patches.push(nodes.into_iter().map(patch).collect());
    }
    let statistics = Statistics { tiles, patches };
    body.bytes.is_empty().then_some(Sidecar { link, finest, max_error_m, min_m, max_m, georeference, statistics })
}

type Node = (f32, f32, f32, Voids);

const NODE_BYTES: usize = 13;

fn put_node(body: &mut Vec<u8>, min_m: f32, max_m: f32, error_m: f32, voids: Voids) {
    for number in [min_m, max_m, error_m] {
        body.extend(number.to_le_bytes());
    }
    body.push(match voids {
        Voids::None => 0,
        Voids::Some => 1,
        Voids::All => 2,
    });
}

/// What is left of the bytes; every read is none beyond their end.
struct Cursor<'a> {
    bytes: &'a [u8],
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    fn nodes(&mut self, x: u32, y: u32) -> Option<Vec<Node>> {
        let count = (x as usize).checked_mul(y as usize)?;
        let mut nodes = Cursor { bytes: self.take(count.checked_mul(NODE_BYTES)?)? };
        (0..count)
            .map(|_| {
                let (min_m, max_m, error_m) = (nodes.f32()?, nodes.f32()?, nodes.f32()?);
                let voids = match nodes.array()? {
                    [0] => Voids::None,
                    [1] => Voids::Some,
                    [2] => Voids::All,
                    _ => return None,
                };
                Some((min_m, max_m, error_m, voids))
            })
            .collect()
    }
}
