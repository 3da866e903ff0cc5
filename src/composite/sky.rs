//! A drawn sky: ruled lines, clouds, bands, the sun and stars over the gradient. See `shaders/composite/sky.wgsl`.
//!
//! Why: `docs/decisions/sky.md`.

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::composite::sky::SkyLook;
use crate::scene::Light;
use crate::style::Panorama;
use crate::style::sky::{CloudForm, Sky};

/// rgb: linear colour before the paper; a: ink of ruled lines and outlines. It is also drawn behind the land.
pub(crate) const SKY: TargetKind = TargetKind::storage(
    "sky",
    wgpu::TextureFormat::Rgba16Float,
    Group::Whole.shows("Colour of the sky before the paper, and the ink of its lines"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The contents of the sky.
    pub style: &'a Sky,
    /// The panorama, which sets the position of the horizon.
    pub panorama: &'a Panorama,
    /// The light of the scene, for the direction of the sun.
    pub light: &'a Light,
    /// Left, top, right and bottom of the area inside the paper's margin, in pixels of the whole picture.
    pub frame_px: [f32; 4],
    /// Whether clouds are composed for this picture, so that its frame cuts none. Several eyes need the same clouds,
    /// which then depend on directions alone.
    pub is_composed: bool,
    pub sky: &'a Target,
}

/// Draws the sky.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let look = SkyLook {
        zenith: style.zenith.linear(),
        rules_px: style.rules_px,
        horizon: style.horizon.linear(),
        spacing_px: style.spacing_px,
        cloud: style.cloud.linear(),
        fade: style.fade,
        bokashi_color: style.bokashi_color.linear(),
        bokashi: style.bokashi,
        sun: style.sun.linear(),
        sun_rad: style.sun_deg.to_radians(),
        glow_rad: style.sun_glow_deg.to_radians(),
        to_sun: inputs.light.to_sun.as_vec3().to_array(),
        clouds: style.clouds,
        star: style.star.linear(),
        stars: style.stars,
        star_px: style.star_px,
        outline_px: style.outline_px,
        horizon_bokashi: style.horizon_bokashi,
        below_level: inputs.panorama.horizon(),
        streaks: u32::from(style.cloud_form == CloudForm::Streaks),
        cloud_shade: style.cloud_shade.linear(),
        cloud_rules_px: style.cloud_rules_px,
        frame_px: inputs.frame_px,
        composed: inputs.is_composed.into(),
        sun_in_view: style.sun_in_view.into(),
        ..SkyLook::default()
    };
    let resources =
        [("view", inputs.view.clone()), ("sky_look", recorder.uniform("sky look", &look)), ("sky", inputs.sky.into())];
    recorder.pixels("composite/sky", inputs.sky.size_px(), &resources);
}
