//! The sidecar of a remote baked pyramid: its header is read when it is opened, a record together with its tile.

use std::path::PathBuf;
use std::sync::Arc;

use crate::pyramid::error::PyramidError;
use crate::pyramid::format::bytes::fnv;
use crate::pyramid::format::fingerprint::{END_BYTES, Fingerprint};
use crate::pyramid::format::record::Record;
use crate::pyramid::format::sidecar::{HEAD_BYTES, HeaderFault, Sidecar};
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::TileAddress;
use crate::remote::{Cancelled, RemoteFile, never};

/// The measured errors of a pyramid that is read over a network.
pub(super) struct Measured {
    file: Arc<RemoteFile>,
    sidecar: Sidecar,
}

impl Measured {
    /// Opens the sidecar `file` of the GeoTIFF `tif`, whose levels have the sizes `sizes`.
    ///
    /// # Errors
    /// [`PyramidError::StaleSidecar`] or [`PyramidError::CorruptSidecar`] if the sidecar does not match or is damaged,
    /// or an error of the network.
    pub(super) fn open(file: Arc<RemoteFile>, tif: &RemoteFile, sizes: &[LevelSize]) -> Result<Self, PyramidError> {
        let path = || PathBuf::from(file.name());
        let stale = |cause: &str| PyramidError::StaleSidecar { path: path(), cause: cause.into() };
        let corrupt = |cause: &str| PyramidError::CorruptSidecar { path: path(), cause: cause.into() };
        let fault = |fault| match fault {
            HeaderFault::Stale(cause) => stale(cause),
            HeaderFault::Corrupt(cause) => corrupt(cause),
        };
        let first = file.read(0, HEAD_BYTES.min(file.size() as usize), &never)?;
        let header_bytes = Sidecar::header_bytes(&first).map_err(fault)?;
        if header_bytes as u64 > file.size() {
            return Err(corrupt("the file is truncated"));
        }
        let sidecar = Sidecar::parse_header(&file.read(0, header_bytes, &never)?).map_err(fault)?;
        if sidecar.file_bytes() != file.size() {
            return Err(corrupt("its length does not match its header"));
        }
        let size = tif.size();
        let end = size.min(END_BYTES);
        let mut ends = tif.read(0, end as usize, &never)?;
        ends.extend(tif.read(size - end, end as usize, &never)?);
        if sidecar.fingerprint != (Fingerprint { tif_bytes: size, tif_hash: fnv(&ends) }) || sidecar.sizes != sizes {
            return Err(stale("the GeoTIFF has changed since it was baked"));
        }
        // The records have checksums.
        file.read_twice(false);
        Ok(Self { file, sidecar })
    }

    /// Reads the sidecar's record of a tile.
    ///
    /// # Errors
    /// If there is no such tile or reading fails; [`PyramidError::CorruptSidecar`] if the record arrived damaged, in
    /// which case another attempt may succeed.
    pub(super) fn record(&self, address: TileAddress, cancelled: Cancelled<'_>) -> Result<Record, PyramidError> {
        let path = || PathBuf::from(self.file.name());
        let range = self.sidecar.record_range(address);
        let range = range.ok_or_else(|| PyramidError::NoSuchTile { path: path(), address })?;
        let bytes = self.file.read(range.start, (range.end - range.start) as usize, cancelled)?;
        self.sidecar.parse_record(address, &bytes).ok_or_else(|| {
            self.file.invalidate(range);
            let TileAddress { level, x, y } = address;
            let cause = format!("the checksum of the record of tile {level} {x} {y} is wrong");
            PyramidError::CorruptSidecar { path: path(), cause }
        })
    }

    /// Returns the lowest and highest height of level 0 in metres.
    pub(super) fn range_m(&self) -> [f32; 2] {
        [self.sidecar.min_m, self.sidecar.max_m]
    }

    /// Returns whether level 0 has no-data samples.
    pub(super) fn has_voids(&self) -> bool {
        self.sidecar.void_samples > 0
    }

    /// Returns the patches whose stride is larger than that of the coarsest level; see `TileStore::coarse_patches`.
    pub(super) fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.sidecar.coarse_patches
    }
}
