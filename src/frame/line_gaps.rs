//! The gaps of lines: boxes in which contour lines are interrupted for numbers. See `shaders/layers/height_lines.wgsl`.
//!
//! Why: `docs/decisions/contour-numbers.md`.

use glam::DVec2;

use super::FrameInputs;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::layers::height_lines;
use crate::scene::view::Part;

/// Boxes, as `LineGap` of `shaders/layers/height_lines.wgsl`.
const GAPS: BufferKind = BufferKind::storage("line gaps");
/// The entry that ends the list.
const END: height_lines::LineGap =
    height_lines::LineGap { centre_px: [0.0; 2], along: [1.0, 0.0], half_px: [-1.0; 2], pad: [0.0; 2] };

/// A box in which contour lines are interrupted, in pixels of the whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineGap {
    /// Centre of the box.
    pub centre_px: DVec2,
    /// Unit vector along the length of the box.
    pub along: DVec2,
    /// Half of the length and half of the height.
    pub half_px: DVec2,
}

impl LineGap {
    /// Returns the gap in a picture with `factor` times as many pixels along each side.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { centre_px: factor * self.centre_px, half_px: factor * self.half_px, ..self }
    }

    /// Returns whether the box, with a margin of a pixel, may reach into a part of the picture.
    fn reaches(&self, part: &Part) -> bool {
        let reach_px = DVec2::splat(self.half_px.length() + 1.0);
        let first = DVec2::from(part.origin_px.map(f64::from));
        let end = first + DVec2::from(part.size_px.map(f64::from));
        (self.centre_px + reach_px).cmpge(first).all() && (self.centre_px - reach_px).cmple(end).all()
    }

    fn on_gpu(&self) -> height_lines::LineGap {
        let [centre_px, along, half_px] =
            [self.centre_px, self.along, self.half_px].map(|vector| vector.as_vec2().to_array());
        height_lines::LineGap { centre_px, along, half_px, ..END }
    }
}

/// Returns a buffer with the gaps in what the eyes of a frame see.
pub(super) fn upload(recorder: &mut Recorder<'_>, inputs: &FrameInputs<'_>) -> Buffer {
    let is_seen = |gap: &&LineGap| inputs.rig.eyes.iter().any(|eye| gap.reaches(&eye.part));
    let mut gaps: Vec<_> = inputs.line_gaps.iter().filter(is_seen).map(LineGap::on_gpu).collect();
    gaps.push(END);
    recorder.upload(&GAPS, &gaps)
}

impl super::Renderer {
    /// Sets the gaps of contour lines in the next frames; there are none by default.
    pub fn set_line_gaps(&mut self, gaps: Vec<LineGap>) {
        self.line_gaps = gaps;
    }
}
