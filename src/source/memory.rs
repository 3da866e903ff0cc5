//! Heights that are held in memory and handed out by windows: of formats that can only be read from their beginning
//! to their end, as text and PNG.

use std::path::{Path, PathBuf};

use super::SourceError;
use super::georeference::Georeference;
use super::place::check_window;
use super::reader::{HeightReader, Window};

/// More samples than this are not decoded into memory: 1 GiB of heights.
const MAX_SAMPLES: u64 = 1 << 28;

/// See the head of the file.
pub(super) struct MemoryReader {
    pub path: PathBuf,
    pub size: [u32; 2],
    pub heights_m: Vec<f32>,
    pub georeference: Georeference,
    pub identity: String,
}

/// Room for the heights of a grid whose size the file claims.
///
/// # Errors
/// More samples than are held in memory, or than there is memory.
pub(super) fn room(path: &Path, [width, height]: [u32; 2]) -> Result<Vec<f32>, SourceError> {
    let too_large = || SourceError::TooLarge { path: path.into(), width, height };
    let samples = u64::from(width) * u64::from(height);
    if samples > MAX_SAMPLES {
        return Err(too_large());
    }
    let mut room = Vec::new();
    room.try_reserve_exact(samples as usize).map_err(|_| too_large())?;
    Ok(room)
}

impl HeightReader for MemoryReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        check_window(&self.path, window, self.size)?;
        let mut heights_m = Vec::with_capacity(window.samples());
        for row in window.y..window.y + window.height {
            let first = row as usize * self.size[0] as usize + window.x as usize;
            heights_m.extend_from_slice(&self.heights_m[first..first + window.width as usize]);
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        // Nothing is decoded, so any window is as good; rows are what lies together.
        [self.size[0], 256.min(self.size[1])]
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}
