//! Local Surface Approximation contours. See `shaders/lines/lsa.wgsl`.
//!
//! Why: `docs/decisions/lsa-contours.md`.

use super::detector::Inputs;
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::lsa::Lsa as LsaUniform;
use crate::style::{Epsilon, Lines};

/// ε of Eq. 6, as in the paper, in metres.
pub(crate) const PAPER_EPSILON_M: f32 = 1e-5;
/// ε of Eq. 6 as a fraction of the pixel's size in the world: the paper's 1e-5 m is this fraction of a pixel at some 5
/// m, the scale of its scenes.
pub(crate) const FOOTPRINT_EPSILON: f32 = 2e-3;
/// The ramp k of Eq. 6.
pub(crate) const PLANE_RAMP: [f32; 2] = [50.0, 150.0];

/// The errors of the eight directions, 0 to 1, in 16 bits each. The words are the axes (1,0), (0,1), (1,1), (1,−1); the
/// low half is the error along the axis, the high half that against it.
pub(crate) const DIRECTIONS: TargetKind = TargetKind::storage(
    "errors of directions",
    wgpu::TextureFormat::Rgba32Uint,
    Group::Lines.shows("Errors of the line detector in eight directions, packed into numbers"),
);

/// Computes how far each pixel's neighbourhood is from the surface that the opposite neighbours predict. `directions`
/// is written for a density filter with eight directions.
pub(crate) fn run(recorder: &mut Recorder<'_>, lines: &Lines, inputs: &Inputs<'_>) {
    let (epsilon_paper_m, epsilon_footprint) = match lines.epsilon {
        Epsilon::Paper => (PAPER_EPSILON_M, 0.0),
        Epsilon::Footprint => (0.0, FOOTPRINT_EPSILON),
    };
    let uniform = LsaUniform { epsilon_paper_m, epsilon_footprint, plane_ramp: PLANE_RAMP, ramp: lines.ramp };
    let mut resources = inputs.resources().to_vec();
    resources.push(("lsa", recorder.uniform("lsa", &uniform)));
    resources.extend(inputs.directions.map(|directions| ("directions", directions.into())));
    let definitions = defined([("ANTIALIASED", lines.geometric_antialias), ("EIGHT", inputs.directions.is_some())]);
    recorder.pixels(Compute { name: "lines/lsa", definitions }, inputs.errors.size_px(), &resources);
}
