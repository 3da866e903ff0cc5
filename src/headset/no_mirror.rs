//! In place of `mirror`, in a build without windows.

use crate::gpu::Gpu;
use crate::gpu::target::Target;

/// There is none.
pub enum Mirror {}

impl Mirror {
    /// None.
    pub fn open(_gpu: &Gpu, _eye_px: [u32; 2]) -> Option<Self> {
        None
    }

    /// Never asked.
    pub fn is_closed(&mut self) -> bool {
        match *self {}
    }

    /// Never called.
    pub fn show(&mut self, _picture: &Target) {
        match *self {}
    }
}
