//! Local Surface Approximation contours. See `shaders/lines/lsa.wgsl`.
//!
//! Why: `docs/decisions/lsa-contours.md`.

use super::detector::Inputs;
use crate::gpu::recorder::Cx;
pub(crate) use crate::gpu::wgsl::lines::lsa::Lsa as LsaUniform;
use crate::style::Epsilon;

/// ε of Eq. 6 as the paper has it.
pub const PAPER_EPSILON_M: f32 = 1e-5;
/// ε of Eq. 6 in sizes of the pixel in the world: the paper's 1e-5 m is this part of a pixel some 5 m away, the scale
/// of its scenes.
pub const FOOTPRINT_EPSILON: f32 = 2e-3;
/// The ramp k of Eq. 6.
pub const PLANE_RAMP: [f32; 2] = [50.0, 150.0];

/// Finds how far each pixel's surroundings are from the plane of the pixel.
pub fn run(cx: &mut Cx<'_>, epsilon: Epsilon, inputs: &Inputs<'_>) {
    let (epsilon_paper_m, epsilon_footprint) = match epsilon {
        Epsilon::Paper => (PAPER_EPSILON_M, 0.0),
        Epsilon::Footprint => (0.0, FOOTPRINT_EPSILON),
    };
    let uniform = LsaUniform { epsilon_paper_m, epsilon_footprint, plane_ramp: PLANE_RAMP };
    let mut resources = inputs.resources().to_vec();
    resources.push(("lsa", cx.uniform("lsa", &uniform)));
    cx.pixels("lines/lsa", inputs.errors.size_px(), &resources);
}
