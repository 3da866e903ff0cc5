//! Tiles read directly from a COG: one that another program wrote, local or remote, or a remote baked pyramid.
//!
//! Without measured errors, the statistics of tiles are estimated from their samples (`derive`). Fetched bytes are
//! decoded; if that fails, they are dropped from memory and disk, so that the next request fetches them again.
//!
//! A codec with a checksum (DEFLATE, LERC, Zstandard frames) detects bytes that were corrupted on the way. Those of
//! uncompressed files, LZW and PackBits may be corrupted unnoticed: over a network, a COG should be compressed, as
//! GDAL's are by default, or come over HTTPS, which has checksums of its own.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tiff_reader::TiffError;
use tiff_reader::source::TiffSource;

use super::cog_levels::CogLevels;
use super::derive::{coarse_patches, derive};
use super::measured::Measured;
use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::record::{Record, checksum};
use crate::pyramid::surface::fill::{HeightLevels, RADIUS};
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::served::serve;
use crate::pyramid::surface::statistics::{PatchStatistics, Voids, tile_index};
use crate::pyramid::tile::{TILE_BORDER, TileAddress};
use crate::remote::{RemoteError, RemoteFile, Traffic, never};
use crate::source::cog::Pictures;
use crate::source::georeference::Georeference;
use crate::source::{SourceError, VoidMode};

/// A remote file as a source for the TIFF reader. Its reads wait for the network unless the blocks are cached.
struct Bytes(Arc<RemoteFile>);

impl TiffSource for Bytes {
    fn len(&self) -> u64 {
        self.0.size()
    }

    fn read_exact_at(&self, offset: u64, length: usize) -> Result<Vec<u8>, TiffError> {
        let size = self.0.size();
        if offset.checked_add(length as u64).is_none_or(|end| end > size) {
            return Err(TiffError::OffsetOutOfBounds { offset, length: length as u64, data_len: size });
        }
        self.0
            .read(offset, length, &never)
            .map_err(|error| TiffError::Io(std::io::Error::other(error), self.0.name().to_owned()))
    }
}

/// Returns the network's error, if there was one, instead of the decoder's error that it caused.
fn of_network(error: PyramidError) -> PyramidError {
    match error {
        PyramidError::Source(SourceError::Damaged { source: TiffError::Io(error, _), .. })
        | PyramidError::Unread { source: SourceError::Damaged { source: TiffError::Io(error, _), .. } }
            if error.get_ref().is_some_and(|inner| inner.is::<RemoteError>()) =>
        {
            let inner = error.into_inner().map(|inner| inner.downcast::<RemoteError>());
            inner.and_then(Result::ok).map_or(PyramidError::Cancelled, |error| PyramidError::from(*error))
        }
        error => error,
    }
}

/// A COG of another program as a store of tiles.
pub struct CogStore {
    file: Arc<RemoteFile>,
    levels: CogLevels,
    range_m: [f32; 2],
    /// The filling of no-data far from everything: the lowest height of the coarsest level, in metres.
    fallback_m: f32,
    coarse: Vec<Vec<PatchStatistics>>,
    /// Whether a tile with no-data was found. From then on the levels that fill no-data are fetched with each tile.
    has_voids: AtomicBool,
    measured: Option<Measured>,
}

impl CogStore {
    /// Opens a file, with its sidecar if it has one. A remote header is read twice, because it has no checksum. About
    /// `decoded_bytes` of decoded blocks are cached. `voids` applies to files without a sidecar; a pyramid with
    /// measured errors is drawn as it was baked.
    ///
    /// # Errors
    /// If the file is not a GeoTIFF of heights, or [`PyramidError::NoOverviews`].
    pub fn open(
        file: Arc<RemoteFile>,
        sidecar: Option<Arc<RemoteFile>>,
        decoded_bytes: usize,
        voids: VoidMode,
    ) -> Result<Self, PyramidError> {
        file.read_twice(true);
        let opened = Self::open_carefully(&file, sidecar, decoded_bytes, voids);
        file.read_twice(false);
        opened.map_err(of_network).map_err(|error| match error {
            // The header was read twice, so it was not damaged on the way: the server has another kind of file.
            PyramidError::Source(SourceError::Damaged { source: TiffError::InvalidMagic, .. }) if file.is_remote() => {
                let cause = "is not a GeoTIFF, and only GeoTIFFs are read over a network; download the file first";
                PyramidError::Remote(RemoteError::Unusable { name: file.name().to_owned(), cause: cause.to_owned() })
            }
            PyramidError::Source(SourceError::Damaged { .. }) | PyramidError::Decode { .. } if file.is_remote() => {
                error.sent(file.name().as_ref(), "a GeoTIFF")
            }
            error => error,
        })
    }

    fn open_carefully(
        file: &Arc<RemoteFile>,
        sidecar: Option<Arc<RemoteFile>>,
        decoded_bytes: usize,
        voids: VoidMode,
    ) -> Result<Self, PyramidError> {
        let name = PathBuf::from(file.name());
        let pictures = Pictures::open(Arc::new(Bytes(file.clone())), &name, decoded_bytes)?;
        let declared = pictures.declared_range_m();
        let mut levels = CogLevels::new(pictures, name.clone())?;
        if let Some(sidecar) = sidecar {
            match Measured::open(sidecar, file, levels.sizes()) {
                Ok(measured) => return Ok(Self::of_measured(file.clone(), levels, measured)),
                Err(error) if error.wants_bake() => tracing::warn!("{error}; using estimated errors"),
                Err(error) => return Err(error),
            }
        }
        if voids == VoidMode::Fill {
            levels.fill_voids();
        }
        let last = levels.sizes().len() - 1;
        let size = levels.sizes()[last];
        let heights_m = levels.read(last, size.region())?;
        let fallback_m = heights_m.iter().copied().fold(f32::NAN, f32::min);
        if fallback_m.is_nan() {
            return Err(PyramidError::NoHeights { path: name });
        }
        let address = TileAddress { level: last as u32, x: 0, y: 0 };
        let top = derive(levels.sizes(), address, serve(&levels, address, fallback_m)?);
        let [min_m, max_m] = [top.statistics.min_m, top.statistics.max_m];
        let range_m = declared.map_or([min_m, max_m], |[low, high]| [low.min(min_m), high.max(max_m)]);
        let coarse = coarse_patches(levels.sizes(), &top);
        let has_voids = AtomicBool::new(top.statistics.voids != Voids::None);
        Ok(Self { file: file.clone(), levels, range_m, fallback_m, coarse, has_voids, measured: None })
    }

    fn of_measured(file: Arc<RemoteFile>, levels: CogLevels, measured: Measured) -> Self {
        let [min_m, max_m] = measured.range_m();
        Self {
            file,
            levels,
            range_m: [min_m, max_m],
            fallback_m: min_m,
            coarse: measured.coarse_patches().to_vec(),
            has_voids: AtomicBool::new(measured.has_voids()),
            measured: Some(measured),
        }
    }

    /// Returns the network traffic so far.
    pub fn traffic(&self) -> Traffic {
        self.file.traffic()
    }

    /// Returns the byte ranges that a tile needs; with `voids`, including the levels that fill its no-data.
    fn ranges(&self, address: TileAddress, voids: bool) -> Vec<Range<u64>> {
        let level = address.level as usize;
        let size = self.levels.sizes()[level];
        let region = size.tile_region(address.x, address.y, TILE_BORDER);
        if !voids {
            return self.levels.ranges(level, region);
        }
        let mut ranges = self.levels.ranges(level, region.grown(RADIUS, size));
        ranges.extend(self.levels.ranges_above(level, region));
        ranges
    }

    fn decode(
        &self,
        address: TileAddress,
        record: Option<Record>,
        fetched: &[Range<u64>],
    ) -> Result<LoadedTile, PyramidError> {
        let served = self.verify(address, record.as_ref()).and_then(|()| serve(&self.levels, address, self.fallback_m));
        match served {
            Ok(tile) => {
                let loaded = match record {
                    Some(Record { statistics, patches, .. }) => LoadedTile::new(tile, statistics, patches),
                    None => derive(self.levels.sizes(), address, tile),
                };
                if loaded.statistics.voids != Voids::None {
                    self.has_voids.store(true, Ordering::Relaxed);
                }
                Ok(loaded)
            }
            Err(error) => {
                let error = of_network(error);
                if matches!(error, PyramidError::Decode { .. } | PyramidError::Mismatch { .. }) {
                    let also = self.ranges(address, true);
                    fetched.iter().chain(&also).for_each(|range| self.file.invalidate(range.clone()));
                    if self.file.is_remote() {
                        let TileAddress { level, x, y } = address;
                        return Err(error.sent(self.file.name().as_ref(), &format!("tile {level} {x} {y}")));
                    }
                }
                Err(error)
            }
        }
    }
}

impl CogStore {
    /// Compares the bytes of a tile with the checksum that was computed when it was baked.
    fn verify(&self, address: TileAddress, record: Option<&Record>) -> Result<(), PyramidError> {
        let Some(sum) = record.and_then(|record| record.checksum) else { return Ok(()) };
        let Some(stored) = self.levels.stored(address) else { return Ok(()) };
        let bytes = self.file.read(stored.start, (stored.end - stored.start) as usize, &never)?;
        if checksum(&bytes) == sum {
            return Ok(());
        }
        let TileAddress { level, x, y } = address;
        let cause = format!("the checksum of tile {level} {x} {y} is wrong");
        Err(PyramidError::Mismatch { path: self.file.name().into(), cause })
    }
}

impl TileStore for CogStore {
    fn name(&self) -> String {
        self.file.name().to_owned()
    }

    fn levels(&self) -> &[LevelSize] {
        self.levels.sizes()
    }

    fn georeference(&self) -> &Georeference {
        self.levels.pictures().georeference()
    }

    fn range_m(&self) -> [f32; 2] {
        self.range_m
    }

    fn is_measured(&self) -> bool {
        self.measured.is_some()
    }

    fn is_sparse(&self) -> bool {
        false
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.coarse
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        if tile_index(self.levels.sizes(), address).is_none() {
            return Err(PyramidError::NoSuchTile { path: self.file.name().into(), address });
        }
        if cancel.is_cancelled() {
            return Err(PyramidError::Cancelled);
        }
        let ranges = self.ranges(address, self.has_voids.load(Ordering::Relaxed));
        let cancelled = || cancel.is_cancelled();
        let record = self.measured.as_ref().map(|measured| measured.record(address, &cancelled)).transpose()?;
        let held = self.file.hold(&ranges, &cancelled)?;
        Ok(Box::new(move || {
            let decoded = self.decode(address, record, &ranges);
            drop(held);
            decoded
        }))
    }
}
