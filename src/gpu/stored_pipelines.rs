//! Pipelines as the driver compiled them, stored between runs where the driver supports it.
//!
//! A file holds the data of one [`wgpu::PipelineCache`]; its name has the vendor and the device, and it begins with a
//! checksum. [`read`] ignores a damaged file, and wgpu ignores the data of another version of the driver; either is
//! then replaced.
//!
//! Why: `docs/decisions/pipelines-in-background.md`.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::file::cache_folder;

/// First bytes of a file; the number is that of the format.
const MAGIC: &[u8; 12] = b"hachurepipe1";
/// Largest file that is read, in bytes.
const LARGEST_BYTES: u64 = 256 << 20;
/// Folder below the cache folder.
const FOLDER: &str = "pipelines";

/// The stored pipelines of a device. They are written when this is dropped, if they changed.
pub(crate) struct StoredPipelines {
    cache: wgpu::PipelineCache,
    /// The file; it may not exist.
    pub(crate) path: PathBuf,
    /// Checksum of the data in the file; 0 if it has no usable data.
    checksum_of_file: AtomicU64,
}

impl StoredPipelines {
    /// Opens the stored pipelines in `folder`, which need not exist. Returns `None` if the device or its driver cannot
    /// store pipelines.
    pub(crate) fn open(device: &wgpu::Device, info: &wgpu::AdapterInfo, folder: &Path) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        let name = wgpu::util::pipeline_cache_key(info)?;
        let path = folder.join(FOLDER).join(format!("{name}.bin"));
        let data = read(&path);
        let descriptor =
            wgpu::PipelineCacheDescriptor { label: Some("stored pipelines"), data: data.as_deref(), fallback: true };
        // SAFETY: the data was returned by `get_data`, and a checksum protects it from damage. wgpu compares its
        // header, which names the device and the version of its driver, and with `fallback` ignores data of another
        // one.
        #[expect(unsafe_code, reason = "wgpu cannot check the data of a driver")]
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        let checksum_of_file = AtomicU64::new(data.as_deref().map_or(0, checksum));
        Some(Self { cache, path, checksum_of_file })
    }

    /// Returns the cache for the descriptor of a pipeline.
    pub(crate) fn cache(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Writes the file, if its content would change. Returns whether it was written; a folder that cannot be written
    /// only costs time in the next run.
    pub(crate) fn store(&self) -> bool {
        let Some(data) = self.cache.get_data().filter(|data| !data.is_empty()) else { return false };
        let sum = checksum(&data);
        if self.checksum_of_file.load(Ordering::Relaxed) == sum {
            return false;
        }
        let content = [MAGIC.as_slice(), &sum.to_le_bytes(), &data].concat();
        let written = cache_folder::write(&self.path, &content);
        if let Err(error) = &written {
            tracing::debug!("{}: cannot store compiled pipelines: {error}", self.path.display());
            return false;
        }
        self.checksum_of_file.store(sum, Ordering::Relaxed);
        true
    }

    /// Returns whether the file had usable data when it was opened, or has been written since.
    #[cfg(test)]
    pub(crate) fn has_data(&self) -> bool {
        self.checksum_of_file.load(Ordering::Relaxed) != 0
    }
}

impl Drop for StoredPipelines {
    fn drop(&mut self) {
        self.store();
    }
}

/// Returns the data of a file; `None` if it does not exist, is too large, or is damaged.
fn read(path: &Path) -> Option<Vec<u8>> {
    let content = cache_folder::read(path, LARGEST_BYTES)?;
    let data = content.strip_prefix(MAGIC)?;
    let (sum, data) = data.split_first_chunk::<8>()?;
    (u64::from_le_bytes(*sum) == checksum(data)).then(|| data.to_vec())
}

/// Returns a checksum, which is never 0. Its lower half is the length of the data, so that data that is cut off never
/// matches.
fn checksum(data: &[u8]) -> u64 {
    ((u64::from(crc32fast::hash(data)) << 32) | (data.len() as u64 & 0xffff_ffff)).max(1)
}
