//! Shades the scene for lines from shading. See `shaders/lines/tone/tone_image.wgsl`.

use glam::DVec3;

use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::lines::tone::tone_image::ToneRules;
use crate::scene::view::Pose;
use crate::style::{ToneLight, ToneLines};

/// For each cell of the grid: diffuse tone, specular highlights and line width in pixels, all multiplied by the
/// fraction of the cell that is surface, which is the last channel; all 0 in the sky.
pub(crate) const TONE_IMAGE: TargetKind = TargetKind::storage(
    "tone image",
    wgpu::TextureFormat::Rgba16Float,
    Group::Lines.shows("Shaded image in which lines from shading are found"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub style: &'a ToneLines,
    /// The `Light` uniform of the style.
    pub light: Resource,
    /// Unit vector toward the scene's sun, in world space.
    pub to_sun: DVec3,
    /// The pose whose axes define the direction of a side light; both eyes of a stereo pair use the same one.
    pub pose: &'a Pose,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// [`FORM_NORMAL`](crate::surface::form::FORM_NORMAL), if there is one.
    pub form_normal: Option<&'a Target>,
    /// The target that is bound if there is no form normal.
    pub nothing: &'a Target,
    pub tone_image: &'a Target,
}

/// Returns the direction toward the light; zero for a light at the eye.
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

/// Shades the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
        ("distance_m", inputs.distance.into()),
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
    fn lights_come_from_their_directions() {
        let pose = Pose { position_m: DVec3::ZERO, forward: DVec3::Y, right: DVec3::X, up: DVec3::Z, fov_rad: 1.0 };
        let text = "name = \"t\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n[tone_lines]\n";
        let of = |keys: &str| {
            let style = Style::parse("t", &format!("{text}{keys}")).unwrap();
            to_light(style.tone_lines().unwrap(), DVec3::Z, &pose)
        };
        assert_eq!(of(""), DVec3::Z);
        assert_eq!(of("light = \"head\"\n"), DVec3::ZERO);
        let side = |side_deg: f64, rise_deg: f64| {
            of(&format!("light = \"side\"\nside_deg = {side_deg:.1}\nrise_deg = {rise_deg:.1}\n"))
        };
        assert!((side(0.0, 0.0) + DVec3::Y).length() < 1e-6, "behind the eye");
        assert!((side(-90.0, 0.0) + DVec3::X).length() < 1e-6, "to the left of the eye");
        assert!((side(0.0, 90.0) - DVec3::Z).length() < 1e-6, "above the eye");
    }
}
