//! Detectors: where pictures of the surface have lines. LSA contours, and the baselines that they are compared with:
//! Sobel on depth and Roystan's outline. See `shaders/lines/sobel.wgsl` and `shaders/lines/roystan.wgsl`.

use super::lsa;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::style::{Detector, Lines};

/// Errors of four axes, from 0; detectors that know no axes write the same four times.
pub const ERRORS: TargetKind = TargetKind::storage("errors", wgpu::TextureFormat::Rgba16Float);

/// What detectors read and write.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out.
    pub errors: &'a Target,
    /// Out, for a style of LSA contours whose density filter has eight directions: [`lsa::DIRECTIONS`].
    pub directions: Option<&'a Target>,
}

impl Inputs<'_> {
    /// By the names in the shaders.
    pub(super) fn resources(&self) -> [Named; 4] {
        [
            ("view", self.view.clone()),
            ("position", self.position.into()),
            ("normal", self.normal.into()),
            ("errors", self.errors.into()),
        ]
    }
}

/// Runs the style's detector.
pub fn run(recorder: &mut Recorder<'_>, lines: &Lines, inputs: &Inputs<'_>) {
    match lines.detector {
        // Lines by curvature have LSA contours of trees.
        Detector::Lsa | Detector::Curvature => lsa::run(recorder, lines, inputs),
        Detector::Sobel => recorder.pixels("lines/sobel", inputs.errors.size_px(), &inputs.resources()),
        Detector::Roystan => recorder.pixels("lines/roystan", inputs.errors.size_px(), &inputs.resources()),
    }
}
