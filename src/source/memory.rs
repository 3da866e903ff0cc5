//! Memory for samples, which is reserved before it is used, so that a failed allocation is an error and does not abort
//! the program; and a reader of heights that are held in memory, for formats that can only be read from beginning to
//! end, such as text.

use std::path::{Path, PathBuf};

use super::SourceError;
use super::georeference::Georeference;
use super::place::begin_window;
use super::reader::{HeightReader, Window};

/// Largest number of samples that are decoded into memory: 1 GiB of heights.
pub(super) const MAX_SAMPLES: u64 = 1 << 28;

/// Heights that are held in memory, 4 bytes per sample, and read by windows.
pub(super) struct MemoryReader {
    pub path: PathBuf,
    pub size: [u32; 2],
    pub heights_m: Vec<f32>,
    /// Metres per unit of the file's heights.
    pub unit_m: f64,
    pub georeference: Georeference,
    pub identity: String,
}

/// Checks that a grid is not too large for a format that must be decoded whole.
///
/// # Errors
/// Returns [`SourceError::TooLarge`] beyond [`MAX_SAMPLES`].
pub(super) fn check_count(path: &Path, [width, height]: [u32; 2]) -> Result<(), SourceError> {
    match u64::from(width) * u64::from(height) > MAX_SAMPLES {
        true => Err(SourceError::TooLarge { path: path.into(), width, height }),
        false => Ok(()),
    }
}

/// Reserves memory for `count` numbers; `size` is the grid size in the error message.
///
/// # Errors
/// Returns [`SourceError::Memory`] if the allocation fails.
pub(crate) fn room<T>(path: &Path, size: [u32; 2], count: u64) -> Result<Vec<T>, SourceError> {
    let mut room = Vec::new();
    let reserved = usize::try_from(count).is_ok_and(|count| room.try_reserve_exact(count).is_ok());
    reserved.then_some(room).ok_or_else(|| lacking(path, size, count.saturating_mul(size_of::<T>() as u64)))
}

/// Returns the error for a failed allocation of `needed_bytes`.
pub(super) fn lacking(path: &Path, [width, height]: [u32; 2], needed_bytes: u64) -> SourceError {
    SourceError::Memory { path: path.into(), width, height, needed_bytes }
}

/// Reserves memory for the heights of a window.
///
/// # Errors
/// The same as [`room`].
pub(super) fn window_room(path: &Path, window: Window) -> Result<Vec<f32>, SourceError> {
    room(path, [window.width, window.height], window.samples() as u64)
}

impl HeightReader for MemoryReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = begin_window(&self.path, window, self.size)?;
        for row in window.rows_in(Window::whole(self.size)) {
            heights_m.extend_from_slice(&self.heights_m[row]);
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        // Nothing is decoded, so that any window is as good as another; rows are contiguous in memory.
        [self.size[0], 256.min(self.size[1])]
    }

    fn declared_unit_m(&self) -> Option<f64> {
        Some(self.unit_m).filter(|unit_m| *unit_m != 1.0)
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}
