//! Blurs the gradient of depth up to silhouettes and creases (anisotropic diffusion). See
//! `shaders/tones/relief/diffuse.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::tones::relief::diffuse::DiffuseStep;
use crate::style::Relief;

/// Largest number of steps.
const MAX_STEPS: i32 = 12;

/// Returns the distance of the neighbours of a step, in pixels: 1, 1, 2, 2, 4, 4 ...
fn stride_px(step: i32) -> i32 {
    1 << (step / 2)
}

/// Returns the steps of a blur of the given standard deviation. A step adds half of its stride's square to the
/// variance.
fn steps(sigma_px: f32) -> Vec<DiffuseStep> {
    let mut variance = 0.0;
    let mut all = Vec::new();
    for step in 0..MAX_STEPS {
        if variance >= sigma_px * sigma_px {
            break;
        }
        let stride_px = stride_px(step);
        let variance_before = variance;
        variance += 0.5 * (stride_px * stride_px) as f32;
        all.push(DiffuseStep { stride_px, variance_before, variance_after: variance, ..DiffuseStep::default() });
    }
    all
}

/// Returns the standard deviation of the widest blur of a style, in pixels.
fn widest_px(relief: &Relief) -> f32 {
    relief.scale_px * (1.0 + relief.coarser_far + relief.coarser_aside + relief.coarser_level)
}

/// Returns how far around a pixel its curvature depends on the picture, in pixels.
pub(crate) fn reach_px(relief: &Relief) -> u32 {
    if !relief.needs_curvature() {
        return 0;
    }
    let blur_px: i32 = steps(widest_px(relief)).iter().map(|step| step.stride_px).sum();
    blur_px.unsigned_abs() + 2
}

/// Blurs the first of two targets, alternating between both, and returns the one that holds the result.
pub(super) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, pictures: &[Target; 2]) -> Target {
    let mut current = 0;
    for step in steps(widest_px(inputs.relief)) {
        let (before, after) = (&pictures[current], &pictures[1 - current]);
        let resources = [
            ("view", inputs.view.clone()),
            ("diffuse_step", recorder.uniform("diffuse step", &step)),
            ("before", before.into()),
            ("after", after.into()),
        ];
        recorder.pixels("tones/relief/diffuse", after.size_px(), &resources);
        current = 1 - current;
    }
    pictures[current].clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_reach_the_deviation_that_is_asked() {
        assert!(steps(0.0).is_empty());
        for sigma_px in [0.5, 1.0, 2.0, 5.0, 12.0] {
            let all = steps(sigma_px);
            let last = all[all.len() - 1];
            assert!(last.variance_before < sigma_px * sigma_px && last.variance_after >= sigma_px * sigma_px);
            assert!(all.windows(2).all(|pair| pair[0].variance_after == pair[1].variance_before));
        }
    }
}
