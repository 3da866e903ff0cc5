//! `Light` in `shaders/shared/light.wgsl`: how a style and a scene light the land.

pub(crate) use crate::gpu::wgsl::shared::light::Light as LightUniform;
use crate::scene;
use crate::style::{Shading, Style};

/// Multiple of the slope angle up to which land is left as paper; from this multiple on, land has all of its tone.
const LEVEL_END: f32 = 4.0;

impl LightUniform {
    /// Returns the uniform of a style in a scene's light.
    pub(crate) fn new(style: &Style, light: &scene::Light) -> Self {
        let Shading { wrap, ambient, shadow, occlusion, slope, exposure, contrast, form_px, detail, level_deg, .. } =
            style.light;
        Self {
            to_sun: light.to_sun.as_vec3().to_array(),
            wrap,
            ambient,
            shadow,
            occlusion,
            slope,
            exposure,
            contrast,
            haze_m: light.haze_m as f32,
            faintest: style.haze.faintest_tone,
            detail: if form_px > 0.0 { detail } else { 1.0 },
            level: level_deg.to_radians().tan(),
            level_end: (LEVEL_END * level_deg).to_radians().tan(),
            ..Self::default()
        }
    }
}
