//! The results of the last frame, for windows, files and measurements.

use super::mark_sets::SET_INKS;
use super::{EyeMemory, FrameCpu, Renderer, inks};
use crate::composite::temporal_aa;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::cache_counts::CacheCounts;
use crate::gpu::finite::NonFinite;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::timer::PassTime;
use crate::gpu::trace::memory_bytes;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::DrawnStrokes;
use crate::style::Style;
use crate::surface::meshes::cull::MeshDraws;
use crate::surface::rows::marks::RowSample;
use crate::surface::{meshes, rows};
use crate::world::Surfaces;

/// Counts of the models that an eye was shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DrawnMeshCounts {
    /// Number of models that were drawn.
    pub instances: u32,
    /// Number of their triangles, at the levels of detail that were drawn.
    pub triangles: u32,
    /// Number of models in view for which the buffers had no room.
    pub left_out: u32,
}

// Eyes are numbered from 0. Methods without the number of an eye are for the first.
impl Renderer {
    /// Returns a picture of the first eye, if a recent frame drew it.
    pub fn target(&self, kind: &TargetKind) -> Option<&Target> {
        self.eye_target(0, kind)
    }

    /// Returns a picture of an eye, if a recent frame drew it.
    pub fn eye_target(&self, eye: usize, kind: &TargetKind) -> Option<&Target> {
        self.eyes.get(eye)?.targets.get(kind)
    }

    /// Returns all pictures that an eye's latest frames drew or read, each with its number among those of its name, by name.
    #[cfg(feature = "window")]
    pub(crate) fn eye_targets(&self, eye: usize) -> Vec<(usize, &Target)> {
        self.eyes.get(eye).map_or_else(Vec::new, |eye| eye.targets.of_latest_frames())
    }

    /// Returns a buffer that passes share, if a recent frame used it.
    pub(crate) fn buffer(&self, kind: &BufferKind) -> Option<Buffer> {
        self.pools.buffers.get(kind)
    }

    /// Returns the width and height of the first eye's pictures in pixels; zeros before the first frame.
    pub fn size_px(&self) -> [u32; 2] {
        self.eyes.first().map_or([0, 0], |eye| eye.targets.size_px())
    }

    /// Returns the GPU memory of the pictures of all eyes, in bytes.
    pub(crate) fn target_bytes(&self) -> u64 {
        self.eyes.iter().map(|eye| eye.targets.bytes()).sum()
    }

    /// Returns the memory that the last frame needs, in bytes, if it was traced: the pictures and buffers that its passes
    /// bind, the blocks of rows of hachures, and the maps of tiles that shadows and water require. The tiles of the land
    /// do not count, because they are the same in all styles.
    pub(crate) fn drawing_bytes(&self, world: &Surfaces) -> Option<u64> {
        let trace = self.trace.as_ref().filter(|trace| !trace.is_empty())?;
        Some(memory_bytes(trace) + self.rows.bytes() + world.terrain.map_bytes())
    }

    /// Reads back how many models the last frame drew, and for how many it had no room. Returns `None` if no recent
    /// frame drew models. Waits for the GPU.
    ///
    /// # Errors
    /// The errors of [`Renderer::drawn_vertices`].
    pub(crate) fn drawn_meshes(&self, gpu: &Gpu) -> Result<Option<DrawnMeshCounts>, GpuError> {
        let Some(draws) = self.buffer(&meshes::DRAWS) else { return Ok(None) };
        let draws: Vec<MeshDraws> = crate::gpu::readback::read_buffer(gpu, &draws.raw, 1)?;
        let of = |draws: &MeshDraws| DrawnMeshCounts {
            instances: draws.listed - draws.left_out,
            triangles: draws.draw[0] / 3,
            left_out: draws.left_out,
        };
        Ok(draws.first().map(of))
    }

    /// Reads back the rows of hachures that the last frame drew for its last eye, as polylines. Returns `None` if no
    /// recent frame drew rows. Waits for the GPU.
    ///
    /// # Errors
    /// The errors of [`Renderer::drawn_vertices`].
    pub(crate) fn drawn_rows(&self, gpu: &Gpu) -> Result<Option<Vec<Vec<RowSample>>>, GpuError> {
        let (Some(drawn), Some(samples)) = (self.buffer(&rows::marks::DRAWN), self.buffer(&rows::marks::MARKS)) else {
            return Ok(None);
        };
        rows::marks::read(gpu, &drawn, &samples).map(Some)
    }

    /// Returns the ink of one set of hatching marks, 0 to 1, as the first eye sees it, if a recent frame drew it
    /// ([`Renderer::set_wants_mark_sets`]).
    pub(crate) fn mark_set(&self, set: usize) -> Option<&Target> {
        self.target(SET_INKS.get(set)?)
    }

    /// Returns the CPU time to record and submit the last frame, in milliseconds, without the time for its tiles and
    /// patches. It is meaningless if each pass was submitted and waited for separately.
    pub fn record_ms(&self) -> f64 {
        self.cpu.record_ms + self.cpu.submit_ms
    }

    /// Returns the CPU time of the last frame in parts.
    pub(crate) fn cpu(&self) -> FrameCpu {
        self.cpu
    }

    /// Returns how many pipelines were compiled so far while the renderer waited, and the time to compile them in
    /// milliseconds, summed over all threads.
    pub(crate) fn compiled(&self) -> (u64, f64) {
        (self.pools.compiles.built_at_once, self.pools.compiles.build_ms)
    }

    /// Returns the hits and misses of each cache, by its name.
    pub(crate) fn cache_counts(&self) -> [(&'static str, CacheCounts); 3] {
        self.pools.cache_counts()
    }

    /// Takes the pass times of the oldest finished frame whose times have not been taken.
    pub fn take_times(&mut self) -> Option<Vec<PassTime>> {
        self.timer.take().map(|(_, times)| times)
    }

    /// Takes the tag of that frame ([`Renderer::set_frame_tag`]), and its pass times.
    pub(crate) fn take_tagged_times(&mut self) -> Option<(u64, Vec<PassTime>)> {
        self.timer.take()
    }

    /// Takes the numbers that were not finite in pictures of checked frames ([`Submits::Checked`]), the first of each
    /// picture that each pass wrote, in the order of the passes.
    ///
    /// [`Submits::Checked`]: crate::gpu::recorder::Submits::Checked
    pub(crate) fn take_non_finite(&mut self) -> Vec<NonFinite> {
        std::mem::take(&mut self.non_finite)
    }

    /// Returns whether the last frame continued the temporal mean of the frames before it.
    pub fn continues(&self) -> bool {
        self.samples.continues()
    }

    /// Returns whether the next frame of the same view would be a different picture: strokes are still fading in or
    /// out, samples of a picture at rest are missing, blocks of hachures are not built yet, the tones still follow,
    /// streams and ridge lines are being computed, or tiles of images on the land are missing. Wind is not considered;
    /// see [`Renderer::may_sway`].
    pub fn is_settling(&self) -> bool {
        self.samples.is_settling()
            || self.has_settling_strokes()
            || self.rows.is_late()
            || self.tones.is_settling()
            || self.drainage_is_late
            || self.imagery_is_late
    }

    /// Returns whether blocks of hachures are missing in the last frame, or were built without all tiles, because a window
    /// builds only a few in a frame.
    pub(crate) fn has_late_rows(&self) -> bool {
        self.rows.is_late()
    }

    /// Returns whether trees that wind moves may be in view, so that the picture changes with time: blocks of forest
    /// that may be visible are near enough to be drawn as more than canopy.
    pub(crate) fn may_sway(&self) -> bool {
        self.may_sway
    }

    /// Returns whether strokes of any eye are still fading in or out.
    pub(super) fn has_settling_strokes(&self) -> bool {
        self.eyes.iter().any(EyeMemory::has_settling_strokes)
    }

    /// Returns the strokes of the first eye in the last frame, if its style has any.
    pub(crate) fn strokes(&self) -> Option<DrawnStrokes<'_>> {
        self.eye_strokes(0)
    }

    /// Returns the strokes of an eye in the last frame, if its style has any.
    pub(crate) fn eye_strokes(&self, eye: usize) -> Option<DrawnStrokes<'_>> {
        let memory = self.eyes.get(eye)?.drawn_strokes()?;
        Some(DrawnStrokes::new(memory, &self.pools))
    }

    /// Returns the history of temporal anti-aliasing that an eye's next frame continues: the targets of
    /// [`temporal_aa::HISTORY`] and [`temporal_aa::SEEN`] that were written last. Returns `None` without temporal
    /// anti-aliasing.
    pub(crate) fn history_targets(&self, eye: usize) -> Option<[&Target; 2]> {
        let written = self.samples.written()?;
        Some([
            self.eye_target(eye, &temporal_aa::HISTORY[written])?,
            self.eye_target(eye, &temporal_aa::SEEN[written])?,
        ])
    }

    /// Returns the picture of detected lines that the composite of an eye read, if the style has detected lines.
    pub(crate) fn line_target(&self, eye: usize, style: &Style) -> Option<&Target> {
        style.lines()?;
        inks::final_line(&self.eyes.get(eye)?.targets)
    }

    /// Returns the picture of a layer's ink in an eye's last frame; `index` is that of the layer in the style.
    pub(crate) fn ink_target(&self, eye: usize, index: usize) -> Option<&Target> {
        self.eyes.get(eye)?.layer_inks.get(index)?.as_ref()
    }
}

#[cfg(test)]
impl Renderer {
    /// Reads back the vertices of the land's mesh in the last frame, for measurements: 17 × 17 for each leaf of its
    /// selection, row by row, in metres relative to the rig's origin; the fourth number is 1. Returns `None` if the
    /// selection was drawn in several batches, because only the last of them is still stored. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] if the device is lost or out of memory.
    pub(crate) fn drawn_vertices(
        &self,
        gpu: &Gpu,
        drawn: &crate::tiles::terrain::Prepared,
    ) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let Some(positions) = self.buffer(&crate::surface::land::vertices::POSITIONS) else {
            return Ok(None);
        };
        crate::surface::land::vertices::read(gpu, &positions, drawn.selection.leaves.len())
    }

    /// Reads back the vertices of the models in view, like [`Renderer::drawn_vertices`]: in the order of the scene,
    /// each model at its level of detail. Returns `None` in a world without models.
    ///
    /// # Errors
    /// The errors of [`Renderer::drawn_vertices`].
    pub(crate) fn drawn_mesh_vertices(&self, gpu: &Gpu, world: &Surfaces) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let (Some(placed), Some(positions)) = (world.meshes(), self.buffer(&meshes::POSITIONS)) else {
            return Ok(None);
        };
        crate::gpu::readback::read_buffer(gpu, &positions.raw, placed.room().vertices as usize).map(Some)
    }
}

#[cfg(test)]
impl Renderer {
    /// Lets `frames` frames of a style pass without any request, so that resources that earlier frames have not used
    /// for long are released. `view` is that of the last frame.
    pub(crate) fn pass_frames(&mut self, gpu: &Gpu, view: &crate::scene::view::View, style: &Style, frames: u64) {
        for _ in 0..frames {
            for eye in &mut self.eyes {
                eye.begin_frame(gpu, view, style, self.room_px).unwrap_or_else(|error| panic!("{error}"));
            }
            self.skip_unused(style);
            self.pools.end_frame();
            gpu.cache().end_frame();
        }
    }
}
