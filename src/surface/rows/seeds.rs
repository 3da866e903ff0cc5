//! Seeds of hachures along the middles of rows. See `shaders/surface/rows/seeds.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::rows::CELLS;

/// Places candidates in the blocks.
pub(crate) fn run(recorder: &mut Recorder<'_>, blocks: u32, resources: &[Named]) {
    recorder.groups("surface/rows/seeds", [(CELLS * CELLS) as u32 / 64, blocks], resources);
}
