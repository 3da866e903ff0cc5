//! The height of the rows in each cell, as an octave. See `shaders/surface/rows/octaves.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::rows::OCTAVES;

/// Computes the octaves of the blocks' cells.
pub(crate) fn run(recorder: &mut Recorder<'_>, blocks: u32, resources: &[Named]) {
    recorder.groups("surface/rows/octaves", [(OCTAVES * OCTAVES) as u32 / 64, blocks], resources);
}
