//! Traces the marks of candidates up and down the slope. See `shaders/surface/rows/trace.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::rows::MAX_CANDIDATES;

/// Traces the marks of the blocks' candidates.
pub(crate) fn run(recorder: &mut Recorder<'_>, blocks: u32, resources: &[Named]) {
    recorder.groups("surface/rows/trace", [MAX_CANDIDATES / 64, blocks], resources);
}
