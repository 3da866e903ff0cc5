//! How light the scene is, for lines that are found in its tones. See `shaders/lines/tone/tone_image.wgsl`.

use glam::DVec3;

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::tone_image::ToneRules;
use crate::scene::view::Pose;
use crate::style::{ToneLight, ToneLines};

/// Of each cell of the grid: diffuse tone, specular highlights and width of lines in pixels, all times which part of it is
/// surface, which is the last; all 0 is the sky.
pub const TONE_IMAGE: TargetKind = TargetKind::storage("tone image", wgpu::TextureFormat::Rgba16Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Whose lines.
    pub style: &'a ToneLines,
    /// `Light` of the style.
    pub light: Resource,
    /// Unit, toward the scene's sun.
    pub to_sun: DVec3,
    /// Whose axes say where a light beside the eye stands: one for both eyes of a pair.
    pub pose: &'a Pose,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// [`FORM_NORMAL`](crate::surface::form::FORM_NORMAL), if there is one.
    pub form_normal: Option<&'a Target>,
    /// What stands for it where there is none.
    pub nothing: &'a Target,
    /// Out.
    pub tone_image: &'a Target,
}

/// Toward the light; 0 is a light at the eye.
fn to_light(style: &ToneLines, to_sun: DVec3, pose: &Pose) -> DVec3 {
    match style.light {
        ToneLight::Sun => to_sun,
        ToneLight::Head => DVec3::ZERO,
        ToneLight::Side => {
            let (side, ahead) = f64::from(style.side_deg).to_radians().sin_cos();
            let (rise, level) = f64::from(style.rise_deg).to_radians().sin_cos();
            (level * (side * pose.right - ahead * pose.forward) + rise * pose.up).normalize_or(-pose.forward)
        }
    }
}

/// Shades what the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let rules = ToneRules {
        to_light: to_light(style, inputs.to_sun, inputs.pose).as_vec3().to_array(),
        specular: style.specular,
        shininess: style.shininess,
        width_px: style.width_px,
        depth_width: style.depth_width,
        abstracted: if inputs.form_normal.is_some() { style.abstracted } else { 0.0 },
        cell_px: super::cell_px(style) as i32,
        ..ToneRules::default()
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("light", inputs.light.clone()),
        ("tone_rules", recorder.uniform("tone rules", &rules)),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("form_normal", inputs.form_normal.unwrap_or(inputs.nothing).into()),
        ("tone_image", inputs.tone_image.into()),
    ];
    recorder.pixels("lines/tone/tone_image", inputs.tone_image.size_px(), &resources);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::style::Style;

    #[test]
    fn lights_stand_where_they_are_said_to() {
        let pose = Pose { position_m: DVec3::ZERO, forward: DVec3::Y, right: DVec3::X, up: DVec3::Z, fov_rad: 1.0 };
        let text = "name = \"t\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n[tone_lines]\n";
        let of = |keys: &str| {
            let style = Style::parse("t", &format!("{text}{keys}")).unwrap();
            to_light(style.tone_lines.as_ref().unwrap(), DVec3::Z, &pose)
        };
        assert_eq!(of(""), DVec3::Z);
        assert_eq!(of("light = \"head\"\n"), DVec3::ZERO);
        let side = |side_deg: f64, rise_deg: f64| {
            of(&format!("light = \"side\"\nside_deg = {side_deg:.1}\nrise_deg = {rise_deg:.1}\n"))
        };
        assert!((side(0.0, 0.0) + DVec3::Y).length() < 1e-6, "behind the eye");
        assert!((side(-90.0, 0.0) + DVec3::X).length() < 1e-6, "on its left");
        assert!((side(0.0, 90.0) - DVec3::Z).length() < 1e-6, "above it");
    }
}
