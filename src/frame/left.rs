//! What the last frame left, for windows, files and measurements.

use super::mark_layers::LAYER_INKS;
use super::{EyeMemory, Renderer, inks};
use crate::composite::temporal_aa;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::timer::PassTime;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::DrawnStrokes;
use crate::style::Style;
use crate::surface::meshes::cull::MeshDraws;
use crate::surface::rows::marks::RowSample;
use crate::surface::{land, meshes, rows};
use crate::tiles::terrain::Prepared;
use crate::world::Surfaces;

/// How many of the meshes that stand on the land an eye was shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawnMeshCounts {
    /// Meshes that are in view.
    pub instances: u32,
    /// Their triangles, at their levels of detail.
    pub triangles: u32,
    /// Meshes in view that found no room.
    pub left_out: u32,
}

/// Eyes count from 0; none is the first.
impl Renderer {
    /// A picture of the first eye, if the last frame made it.
    pub fn target(&self, kind: &TargetKind) -> Option<&Target> {
        self.eye_target(0, kind)
    }

    /// A picture of an eye, if the last frame made it.
    pub fn eye_target(&self, eye: usize, kind: &TargetKind) -> Option<&Target> {
        self.eyes.get(eye)?.targets.get(kind)
    }

    /// A buffer that passes share, if a recent frame made it.
    pub fn buffer(&self, kind: &BufferKind) -> Option<Buffer> {
        self.pools.buffers.get(kind)
    }

    /// Width and height of the first eye's pictures.
    pub fn size_px(&self) -> [u32; 2] {
        self.eyes.first().map_or([0, 0], |eye| eye.targets.size_px())
    }

    /// Bytes of the pictures of all eyes on the GPU.
    pub fn target_bytes(&self) -> u64 {
        self.eyes.iter().map(|eye| eye.targets.bytes()).sum()
    }

    /// The mesh as the last picture drew it, for measurements: 17 × 17 vertices for each leaf of its selection, row by
    /// row, in metres from the rig's origin (the fourth number is 1). None when the selection was so large that it was
    /// drawn in several batches: only the last of them is left.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub fn drawn_vertices(&self, gpu: &Gpu, drawn: &Prepared) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let Some(positions) = self.buffer(&land::vertices::POSITIONS) else {
            return Ok(None);
        };
        land::vertices::read(gpu, &positions, drawn.selection.leaves.len())
    }

    /// As [`Renderer::drawn_vertices`], of what is in view of all that stands on the land, if anything does: in the order
    /// of the scene, each at its level.
    ///
    /// # Errors
    /// As [`Renderer::drawn_vertices`].
    pub fn drawn_mesh_vertices(&self, gpu: &Gpu, world: &Surfaces) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let (Some(placed), Some(positions)) = (world.meshes(), self.buffer(&meshes::POSITIONS)) else {
            return Ok(None);
        };
        crate::gpu::readback::read_buffer(gpu, &positions.raw, placed.room().vertices as usize).map(Some)
    }

    /// What the last frame drew of all that stands on the land, and what it had no room for. Waits for the GPU.
    ///
    /// # Errors
    /// As [`Renderer::drawn_vertices`].
    pub fn drawn_meshes(&self, gpu: &Gpu) -> Result<Option<DrawnMeshCounts>, GpuError> {
        let Some(draws) = self.buffer(&meshes::DRAWS) else { return Ok(None) };
        let draws: Vec<MeshDraws> = crate::gpu::readback::read_buffer(gpu, &draws.raw, 1)?;
        let of = |draws: &MeshDraws| DrawnMeshCounts {
            instances: draws.listed - draws.left_out,
            triangles: draws.draw[0] / 3,
            left_out: draws.left_out,
        };
        Ok(draws.first().map(of))
    }

    /// The rows of hachures that the last frame drew of its last eye, as lines; none if its style has none. Waits for the
    /// GPU.
    ///
    /// # Errors
    /// As [`Renderer::drawn_vertices`].
    pub fn drawn_rows(&self, gpu: &Gpu) -> Result<Option<Vec<Vec<RowSample>>>, GpuError> {
        let (Some(drawn), Some(samples)) = (self.buffer(&rows::marks::DRAWN), self.buffer(&rows::marks::MARKS)) else {
            return Ok(None);
        };
        rows::marks::read(gpu, &drawn, &samples).map(Some)
    }

    /// The ink of a layer of hatching of the first eye, 0 to 1, if it was asked for ([`Renderer::set_wants_mark_layers`]) and
    /// the style has that layer.
    pub fn mark_layer(&self, layer: usize) -> Option<&Target> {
        self.target(LAYER_INKS.get(layer)?)
    }

    /// How long the CPU took to record and submit the last frame, without its tiles and patches. Means nothing where
    /// each pass was submitted and waited for by itself.
    pub fn record_ms(&self) -> f64 {
        self.record_ms
    }

    /// The times of the oldest finished frame that has not been asked for.
    pub fn take_times(&mut self) -> Option<Vec<PassTime>> {
        self.timer.take()
    }

    /// Returns whether the last frame continued the temporal mean of the frames before it.
    pub fn continues(&self) -> bool {
        self.samples.continues()
    }

    /// Whether the next frame of the same view would be another picture: strokes are still coming or going, or samples
    /// of a picture at rest are still to come. What wind moves is another matter ([`Renderer::may_sway`]).
    pub fn is_settling(&self) -> bool {
        self.samples.is_settling() || self.has_settling_strokes() || self.rows.is_late()
    }

    /// Whether trees may be in view that wind moves, so that the same view is another picture at another time: there are
    /// blocks of forest that may be seen and are near enough to be drawn as more than canopy.
    pub fn may_sway(&self) -> bool {
        self.may_sway
    }

    /// Whether strokes are still coming or going.
    pub(super) fn has_settling_strokes(&self) -> bool {
        self.eyes.iter().any(EyeMemory::has_settling_strokes)
    }

    /// The strokes of the first eye, if the style has any, with what the last frame left.
    pub fn strokes(&self) -> Option<DrawnStrokes<'_>> {
        self.eye_strokes(0)
    }

    /// The strokes of an eye, as [`Renderer::strokes`].
    pub fn eye_strokes(&self, eye: usize) -> Option<DrawnStrokes<'_>> {
        let memory = self.eyes.get(eye)?.drawn_strokes()?;
        Some(DrawnStrokes::new(memory, &self.pools))
    }

    /// What an eye's next frame takes over, if frames are samples of one picture: of [`temporal_aa::HISTORY`] and
    /// [`temporal_aa::SEEN`] what was written last.
    pub fn history_targets(&self, eye: usize) -> Option<[&Target; 2]> {
        let written = self.samples.writes()?;
        Some([
            self.eye_target(eye, &temporal_aa::HISTORY[written])?,
            self.eye_target(eye, &temporal_aa::SEEN[written])?,
        ])
    }

    /// Which line picture the composite of an eye read, if the style has lines.
    pub fn line_target(&self, eye: usize, style: &Style) -> Option<&Target> {
        style.lines()?;
        inks::last_line(&self.eyes.get(eye)?.targets)
    }

    /// The picture of a layer's ink that an eye drew last; `index` is that of the layer in the style.
    pub fn ink_target(&self, eye: usize, style: &Style, index: usize) -> Option<&Target> {
        inks::last(&self.eyes.get(eye)?.targets, style, index)
    }
}
