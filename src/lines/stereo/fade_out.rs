//! Fades contours out toward the other eye's contour. See `shaders/lines/stereo/fade_out.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::stereo::fade_out::FadeOut as FadeOutUniform;
use crate::scene::view::Rig;
use crate::style::Lines;

/// Line strength (0 no line, 1 full), with contours that fade out.
pub(crate) const FADED: TargetKind = TargetKind::storage(
    "faded line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Detected lines of an eye, with contours that fade out"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// Lines of this eye alone.
    pub line: &'a Target,
    pub faded: &'a Target,
}

/// Adds to the lines of an eye of a stereo pair the strips in which its contours fade out.
pub(crate) fn run(recorder: &mut Recorder<'_>, lines: &Lines, rig: &Rig, inputs: &Inputs<'_>) {
    let places_m: Vec<_> = rig.eyes.iter().map(|eye| eye.pose.position_m - rig.origin_m).collect();
    let (first_m, last_m) = (places_m[0], places_m[places_m.len() - 1]);
    let uniform = FadeOutUniform {
        middle_m: ((first_m + last_m) * 0.5).as_vec3().to_array(),
        radius_m: (0.5 * first_m.distance(last_m)) as f32,
        forward: rig.eyes[0].pose.forward.as_vec3().to_array(),
        start: lines.fade_start,
        end: lines.fade_end,
        ..FadeOutUniform::default()
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("fade_out", recorder.uniform("fade out", &uniform)),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("line", inputs.line.into()),
        ("faded", inputs.faded.into()),
    ];
    recorder.pixels("lines/stereo/fade_out", inputs.faded.size_px(), &resources);
}
