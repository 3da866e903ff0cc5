//! Contours fade out where the other eye sees beyond them. See `shaders/lines/stereo/fade_out.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::stereo::fade_out::FadeOut as FadeOutUniform;
use crate::scene::view::Rig;
use crate::style::Lines;

/// Lines, with contours that fade out: 0 none, 1 full.
pub const FADED: TargetKind = TargetKind::storage("faded line", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Lines of one eye alone.
    pub line: &'a Target,
    /// Out: [`FADED`].
    pub faded: &'a Target,
}

/// Adds to the lines of an eye of a pair what its contours fade out to.
pub fn run(recorder: &mut Recorder<'_>, lines: &Lines, rig: &Rig, inputs: &Inputs<'_>) {
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
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("line", inputs.line.into()),
        ("faded", inputs.faded.into()),
    ];
    recorder.pixels("lines/stereo/fade_out", inputs.faded.size_px(), &resources);
}
