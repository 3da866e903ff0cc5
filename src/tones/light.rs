//! `Light` in `shaders/shared/light.wgsl`: how a style and a scene light the land.

pub use crate::gpu::wgsl::shared::light::Light as LightUniform;
use crate::scene;
use crate::style::{Shading, Style};

impl LightUniform {
    /// Of a style in a scene's light.
    pub fn new(style: &Style, light: &scene::Light) -> Self {
        let Shading { wrap, ambient, shadow, occlusion, slope, exposure, contrast } = style.light;
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
        }
    }
}
