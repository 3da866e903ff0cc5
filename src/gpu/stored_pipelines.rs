//! Pipelines as the driver compiled them, stored between runs where the driver supports it.
//!
//! A file holds the data of one [`wgpu::PipelineCache`]; its name is that of the device, and it begins with a checksum.
//! A file that is damaged, or that another version of the driver wrote, is ignored and replaced.
//!
//! Why: `docs/decisions/pipelines-in-background.md`.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::file::atomic;

/// First bytes of a file; the number is that of the format.
const MAGIC: &[u8; 12] = b"hachurepipe1";
/// Largest file that is read, in bytes.
const LARGEST_BYTES: u64 = 256 << 20;
/// Folder below the cache folder.
const FOLDER: &str = "pipelines";

/// The stored pipelines of a device. They are written when this is dropped, if pipelines were compiled.
pub(crate) struct StoredPipelines {
    raw: wgpu::PipelineCache,
    pub(crate) path: PathBuf,
    /// Checksum of the data that the file holds; 0 if it holds none.
    held: AtomicU64,
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
        // SAFETY: the data was returned by `get_data`, and a checksum protects it from damage. wgpu compares its header,
        // which names the device and the version of its driver, and with `fallback` ignores data of another one.
        #[expect(unsafe_code, reason = "wgpu cannot check the data of a driver")]
        let raw = unsafe { device.create_pipeline_cache(&descriptor) };
        let held = data.as_deref().map_or(0, checksum);
        Some(Self { raw, path, held: AtomicU64::new(held) })
    }

    /// Returns the cache for the descriptor of a pipeline.
    pub(crate) fn raw(&self) -> &wgpu::PipelineCache {
        &self.raw
    }

    /// Writes the file, if its content would change. Returns whether it was written; a folder that cannot be written
    /// only costs time in the next run.
    pub(crate) fn store(&self) -> bool {
        let Some(data) = self.raw.get_data().filter(|data| !data.is_empty()) else { return false };
        let sum = checksum(&data);
        if self.held.load(Ordering::Relaxed) == sum {
            return false;
        }
        let content = [MAGIC.as_slice(), &sum.to_le_bytes(), &data].concat();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let written = std::fs::create_dir_all(folder).and_then(|()| atomic::write(&self.path, &content));
        if let Err(error) = &written {
            tracing::debug!("{}: cannot store compiled pipelines: {error}", self.path.display());
            return false;
        }
        self.held.store(sum, Ordering::Relaxed);
        true
    }

    /// Returns whether the file had usable data when it was opened, or has been written since.
    #[cfg(test)]
    pub(crate) fn has_data(&self) -> bool {
        self.held.load(Ordering::Relaxed) != 0
    }
}

impl Drop for StoredPipelines {
    fn drop(&mut self) {
        self.store();
    }
}

/// Returns the data of a file, if it is whole.
fn read(path: &Path) -> Option<Vec<u8>> {
    let is_small = std::fs::metadata(path).is_ok_and(|metadata| metadata.len() <= LARGEST_BYTES);
    let content = is_small.then(|| std::fs::read(path).ok()).flatten()?;
    let data = content.strip_prefix(MAGIC)?;
    let (sum, data) = data.split_first_chunk::<8>()?;
    (u64::from_le_bytes(*sum) == checksum(data)).then(|| data.to_vec())
}

/// Returns a checksum, which is never 0.
fn checksum(data: &[u8]) -> u64 {
    (u64::from(crc32fast::hash(data)) << 32 | (data.len() as u64 & 0xffff_ffff)).max(1)
}
