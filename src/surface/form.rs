//! The normal used for lighting: that of the land's form at the scale of the picture. See `shaders/surface/form.wgsl`.
//!
//! Why: `docs/decisions/form-light.md`.

use std::f32::consts::PI;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::form::FormRules;
use crate::gpu::wgsl::surface::planes::PlaneStep;
use crate::scene::Light;
use crate::style::{Shading, Style};

/// xyz: unit normal in world space; w: distance along the view axis. All 0 where there is no land. The size is
/// [`mark_normal_size`](super::mark_normal::mark_normal_size).
pub(crate) const FORM_NORMAL: TargetKind = TargetKind::storage(
    "form normal",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Normal of the smoothed land that is lit"),
);

/// Every second step of the planes, in the layout and size of [`FORM_NORMAL`].
pub(crate) const PLANES: TargetKind = TargetKind::storage(
    "planes",
    wgpu::TextureFormat::Rgba32Float,
    Group::Form.shows("Normal of slopes while they are drawn together into planes"),
);

/// Side of a block of pixels that has one form normal, in pixels.
const BLOCK_PX: f32 = 4.0;

/// Angle by which the samples of a step are turned from those of the step before: 60 % of a right angle.
const TURN_RAD: f32 = 0.3 * PI;

/// Angle between normals at which one counts 61 % less for the plane of the other.
const SIMILAR_RAD: f32 = 0.2;

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The style whose light settings apply.
    pub style: &'a Style,
    /// The direction of the sun.
    pub light: &'a Light,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub form_normal: &'a Target,
    /// [`PLANES`], in a style with planes.
    pub planes: Option<&'a Target>,
}

/// Computes the form normal of the visible land, and draws it together into planes if the style has them.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    smooth(recorder, inputs);
    let Some(planes) = inputs.planes else { return };
    let [mut from, mut to] = [inputs.form_normal, planes];
    // The number of steps is even, so that the last one writes the form normal. That one smooths all of a face, so that
    // no border of two planes has the steps of blocks.
    let steps = plane_steps(inputs.style.light.planes_px);
    for (number, apart) in steps.iter().enumerate() {
        let similar_rad = if number + 1 < steps.len() { SIMILAR_RAD } else { PI };
        let turn_rad = number as f32 * TURN_RAD;
        let step = PlaneStep { apart: *apart, similar_rad, turn: [turn_rad.cos(), turn_rad.sin()] };
        let resources = [
            ("view", inputs.view.clone()),
            ("plane_step", recorder.uniform("plane step", &step)),
            ("form_normal", from.into()),
            ("planes", to.into()),
        ];
        recorder.pixels("surface/planes", to.size_px(), &resources);
        (from, to) = (to, from);
    }
}

/// Returns the distances of the samples of the steps of the filter for planes of a size, in blocks, from the widest to 1;
/// their number is even.
fn plane_steps(planes_px: f32) -> Vec<i32> {
    let widest = (planes_px / (2.0 * BLOCK_PX)).max(1.0);
    let count = 2 * ((widest.log2().floor() as i32 + 2) / 2).max(1);
    let apart = |step: i32| (widest * (-step as f32).exp2()).round().max(1.0) as i32;
    (0..count - 1).map(apart).chain([1]).collect()
}

/// Returns how far planes reach, in pixels.
pub(crate) fn reach_px(shading: &Shading) -> u32 {
    if shading.planes_px > 0.0 {
        let reach: i32 = plane_steps(shading.planes_px).into_iter().sum();
        // The tone of a pixel is between four blocks.
        (reach as u32 + 1) * BLOCK_PX as u32
    } else {
        0
    }
}

fn smooth(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let shading = &inputs.style.light;
    let rules = FormRules {
        to_sun: inputs.light.to_sun.truncate().normalize_or_zero().as_vec2().to_array(),
        form_px: shading.form_px,
        turn_rad: shading.turn_deg.to_radians(),
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("form_rules", recorder.uniform("form rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("form_normal", inputs.form_normal.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/form", inputs.form_normal.size_px(), &resources);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_drawn_in_an_even_number_of_steps_that_ends_with_neighbours() {
        assert_eq!(plane_steps(64.0), [8, 4, 2, 1]);
        for planes_px in [0.1, 8.0, 20.0, 63.9, 96.0, 127.0, 300.0, 512.0] {
            let steps = plane_steps(planes_px);
            assert!(steps.len().is_multiple_of(2) && steps.last() == Some(&1), "{planes_px}: {steps:?}");
            assert!(
                steps.is_sorted_by(|wide, near| wide >= near)
                    && f32::from(steps[0] as u16) * 8.0 <= planes_px.max(8.0) + 4.0
            );
            let shading = Shading { planes_px, ..Style::load("ink").unwrap().light };
            assert!(reach_px(&shading) as i32 >= 4 * steps.iter().sum::<i32>());
        }
    }
}
