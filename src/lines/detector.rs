//! Line detectors on pictures of the surface: LSA contours, and the baselines that they are compared with, Sobel on
//! depth and Roystan's outline. See `shaders/lines/sobel.wgsl` and `shaders/lines/roystan.wgsl`.

use super::lsa;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::style::{Detector, Lines};

/// Errors along four axes, from 0; a detector without axes writes the same value to all four channels.
pub(crate) const ERRORS: TargetKind = TargetKind::storage(
    "errors",
    wgpu::TextureFormat::Rgba16Float,
    Group::Lines.shows("Errors of the line detector, from which lines are made"),
);

/// Inputs and outputs of the detectors.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub distance: &'a Target,
    pub normal: &'a Target,
    pub errors: &'a Target,
    /// Written if the style has LSA contours whose density filter has eight directions: [`lsa::DIRECTIONS`].
    pub directions: Option<&'a Target>,
}

impl Inputs<'_> {
    /// Returns the bindings that all detectors have.
    pub(super) fn resources(&self) -> [Named; 4] {
        [
            ("view", self.view.clone()),
            ("distance_m", self.distance.into()),
            ("normal", self.normal.into()),
            ("errors", self.errors.into()),
        ]
    }
}

/// Runs the style's detector.
pub(crate) fn run(recorder: &mut Recorder<'_>, lines: &Lines, inputs: &Inputs<'_>) {
    match lines.detector {
        // Lines from curvature use LSA contours for trees.
        Detector::Lsa | Detector::Curvature => lsa::run(recorder, lines, inputs),
        Detector::Sobel => recorder.pixels("lines/sobel", inputs.errors.size_px(), &inputs.resources()),
        Detector::Roystan => recorder.pixels("lines/roystan", inputs.errors.size_px(), &inputs.resources()),
    }
}
