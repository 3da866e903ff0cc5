//! The vertices of the selected patches, morphed. See `shaders/surface/land/vertices.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::pyramid::tile::PATCH_QUADS;
use crate::tiles::selection::{PatchInstance, Selection};

/// Vertices of a patch.
const VERTICES: u32 = (PATCH_QUADS + 1) * (PATCH_QUADS + 1);
/// Threads of a workgroup; must equal `@workgroup_size(64)` in the shader.
const WORKGROUP: u32 = 64;
/// Bytes of a position.
const POSITION_BYTES: u64 = 16;
/// The size of a batch is a multiple of this, in patches: 16 × 48 bytes are three times the largest alignment of
/// binding offsets.
const BATCH_STEP: u32 = 16;

/// [`PatchInstance`]s: `Patch` in `shaders/shared/patch.wgsl`.
const PATCHES: BufferKind = BufferKind::storage("patches");
/// The vertices of the last batch, 17 × 17 per patch, row by row: metres from the rig's origin.
pub(crate) const POSITIONS: BufferKind = BufferKind::storage("vertices");

/// A selection of patches on the GPU. It is drawn in batches; one is enough for usual picture sizes and errors.
#[derive(Clone, Debug)]
pub(crate) struct PatchMesh {
    patches: Buffer,
    positions: Buffer,
    /// First patch and number of patches of each batch. An empty selection has one empty batch, which still clears the
    /// targets.
    pub batches: Vec<[u32; 2]>,
    /// Number of patches without holes; they come first, those with holes follow.
    pub solid: u32,
}

impl PatchMesh {
    /// Uploads the patches of a selection, for all eyes of a rig.
    pub(crate) fn upload(recorder: &mut Recorder<'_>, selection: &Selection) -> Self {
        let instances: Vec<PatchInstance> = [selection.solid.as_slice(), &selection.with_holes].concat();
        let count = instances.len() as u32;
        let limits = recorder.gpu().device.limits();
        let room = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let most =
            (room / (u64::from(VERTICES) * POSITION_BYTES)).min(u64::from(limits.max_compute_workgroups_per_dimension));
        // A batch's patches are bound at an offset, which must be aligned.
        let most = (most as u32 / BATCH_STEP).max(1) * BATCH_STEP;
        // Rounded up, so that a selection that changes from frame to frame rarely needs another buffer.
        let patches = count.next_power_of_two().min(most).max(count.min(most));
        let bytes = u64::from(patches) * u64::from(VERTICES) * POSITION_BYTES;
        Self {
            patches: recorder.upload(&PATCHES, &instances),
            positions: recorder.buffer(&POSITIONS, bytes),
            batches: (0..count.max(1)).step_by(most as usize).map(|first| [first, most.min(count - first)]).collect(),
            solid: selection.solid.len() as u32,
        }
    }

    /// Returns whether any patch has holes.
    pub(crate) fn has_holes(&self) -> bool {
        self.solid < self.batches.iter().map(|[_, count]| count).sum()
    }

    /// Computes the vertices of a batch. If there is only one batch, this is done once for all eyes.
    pub(crate) fn place(&self, recorder: &mut Recorder<'_>, batch: [u32; 2], terrain: &[Named]) {
        let mut resources = self.resources(batch).to_vec();
        resources.extend(terrain.iter().cloned());
        recorder.groups("surface/land/vertices", [VERTICES.div_ceil(WORKGROUP), batch[1]], &resources);
    }

    /// Returns the bindings of a batch's patches and vertices.
    pub(crate) fn resources(&self, batch: [u32; 2]) -> [Named; 2] {
        let patches = match self.batches.len() {
            // The whole buffer, so that the same bind group serves any number of patches.
            1 => self.patches.clone(),
            _ => {
                let size = size_of::<PatchInstance>() as u64;
                self.patches.slice(u64::from(batch[0]) * size, u64::from(batch[1]) * size)
            }
        };
        [("patches", patches.binding()), ("positions", self.positions.binding())]
    }
}

/// Reads back [`POSITIONS`] of a selection of `patches` patches. Returns `None` if it was drawn in several batches,
/// since only the vertices of the last batch remain.
///
/// # Errors
/// The same as [`crate::gpu::readback::read_buffer`].
#[cfg(test)]
pub(crate) fn read(
    gpu: &crate::gpu::Gpu,
    positions: &Buffer,
    patches: usize,
) -> Result<Option<Vec<[f32; 4]>>, crate::gpu::GpuError> {
    let count = patches * VERTICES as usize;
    if count as u64 * POSITION_BYTES > positions.raw.size() {
        return Ok(None);
    }
    crate::gpu::readback::read_buffer(gpu, &positions.raw, count).map(Some)
}
