//! Replaces `mirror` in a build without windows.

use crate::gpu::Gpu;
use crate::gpu::target::Target;

/// A mirror that cannot exist.
pub(super) enum Mirror {}

impl Mirror {
    /// Returns `None`: this build cannot open a window.
    pub(super) fn open(_gpu: &Gpu, _eye_px: [u32; 2]) -> Option<Self> {
        None
    }

    /// Is never called.
    pub(super) fn is_closed(&mut self) -> bool {
        match *self {}
    }

    /// Is never called.
    pub(super) fn show(&mut self, _picture: &Target) {
        match *self {}
    }
}
